"""Lifecycle nodes: their states, the services for them, and what is silent unless active."""

from __future__ import annotations

from functools import partialmethod
from typing import Any

import pytest
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_msgs.msg import Int32

from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until

if chosen.ENGINE == "embedded":
    from rclpy.lifecycle.node import _LABELS as LABELS

SUCCESS = TransitionCallbackReturn.SUCCESS
FAILURE = TransitionCallbackReturn.FAILURE
ERROR = TransitionCallbackReturn.ERROR


class Told(LifecycleNode):
    """Notes its transitions, each with the state before it, and answers as it is told to."""

    def __init__(self, name: str, **options: Any) -> None:
        self.told: list[tuple[str, str]] = []
        self.says: dict[str, Any] = {}
        super().__init__(name, **options)

    def _say(self, callback: str, state: LifecycleState) -> TransitionCallbackReturn:
        self.told.append((callback, state.label))
        said = self.says.get(callback, SUCCESS)
        if isinstance(said, Exception):
            raise said
        answer: TransitionCallbackReturn = said
        return answer

    on_configure = partialmethod(_say, "configure")
    on_cleanup = partialmethod(_say, "cleanup")
    on_activate = partialmethod(_say, "activate")
    on_deactivate = partialmethod(_say, "deactivate")
    on_shutdown = partialmethod(_say, "shutdown")
    on_error = partialmethod(_say, "error")


def made(ros: Ros, kind: type[LifecycleNode] = Told, **options: Any) -> Any:
    """A node of the name "told"."""
    return ros.node(kind=lambda **given: kind("told", **given), **options)


def at(node: Any) -> str:
    """The label of the state in which a node is."""
    if chosen.ENGINE == "embedded":
        return LABELS[node._state]
    label: str = node._state_machine.current_state[1]
    return label


def go(node: Any, *transitions: str) -> list[tuple[Any, str]]:
    """What each transition returns, and where it leads."""
    return [(getattr(node, f"trigger_{t}")(), at(node)) for t in transitions]


@pytest.fixture
def node(ros: Ros) -> Any:
    return made(ros)


def test_a_node_goes_from_state_to_state(node: Any) -> None:
    assert at(node) == "unconfigured"
    assert go(node, "configure", "activate", "deactivate", "cleanup", "shutdown") == [
        (SUCCESS, "inactive"),
        (SUCCESS, "active"),
        (SUCCESS, "inactive"),
        (SUCCESS, "unconfigured"),
        (SUCCESS, "finalized"),
    ]
    assert node.told == [
        ("configure", "unconfigured"),
        ("activate", "inactive"),
        ("deactivate", "active"),
        ("cleanup", "inactive"),
        ("shutdown", "unconfigured"),
    ]


def test_a_transition_that_does_not_start_here_is_an_error_and_changes_nothing(node: Any) -> None:
    assert go(node, "activate", "configure", "configure") == [
        (ERROR, "unconfigured"),
        (SUCCESS, "inactive"),
        (ERROR, "inactive"),
    ]
    assert node.told == [("configure", "unconfigured")]


@pytest.mark.parametrize(
    ("path", "says", "returned", "left", "errors"),
    [
        ("configure", {"configure": FAILURE}, FAILURE, "unconfigured", 0),
        ("configure", {"configure": ERROR}, ERROR, "unconfigured", 1),
        ("configure", {"configure": KeyError("x")}, ERROR, "unconfigured", 1),
        ("configure", {"configure": ERROR, "error": FAILURE}, ERROR, "finalized", 1),
        ("configure", {"configure": ERROR, "error": ERROR}, ERROR, "finalized", 1),
        ("configure", {"configure": ERROR, "error": KeyError("x")}, ERROR, "finalized", 1),
        ("configure activate", {"activate": FAILURE}, FAILURE, "inactive", 0),
        ("configure activate", {"activate": ERROR}, ERROR, "unconfigured", 1),
        ("configure activate deactivate", {"deactivate": FAILURE}, FAILURE, "active", 0),
        ("configure cleanup", {"cleanup": FAILURE}, FAILURE, "inactive", 0),
        ("configure shutdown", {"shutdown": FAILURE}, FAILURE, "finalized", 0),
        ("configure shutdown", {"shutdown": ERROR}, ERROR, "unconfigured", 1),
    ],
)
def test_what_a_callback_says_decides_where_it_leads(
    path: str, says: dict[str, Any], returned: Any, left: str, errors: int, node: Any
) -> None:
    node.says = says
    assert go(node, *path.split())[-1] == (returned, left)
    assert sum(callback == "error" for callback, _ in node.told) == errors


def test_services_tell_and_change_the_state(ros: Ros) -> None:
    told = made(ros)
    asker = ros.node("asker")
    events: list[tuple[str, str]] = []
    asker.create_subscription(
        TransitionEvent,
        "/told/transition_event",
        lambda e: events.append((e.start_state.label, e.goal_state.label)),
        10,
    )
    clients = {
        name: asker.create_client(kind, f"/told/{name}")
        for name, kind in (
            ("get_state", GetState),
            ("change_state", ChangeState),
            ("get_available_states", GetAvailableStates),
            ("get_available_transitions", GetAvailableTransitions),
            ("get_transition_graph", GetAvailableTransitions),
        )
    }
    assert all(client.wait_for_service(10.0) for client in clients.values())
    wait_until(lambda: asker.count_publishers("/told/transition_event") == 1)
    ros.spin(told, asker)

    def ask(name: str, **transition: Any) -> Any:
        request = clients[name].srv_type.Request()
        if transition:
            request.transition = Transition(**transition)
        return ros.result(clients[name].call_async(request))

    assert ask("get_state").current_state.label == "unconfigured"
    assert ask("change_state", id=Transition.TRANSITION_CONFIGURE).success
    assert ask("get_state").current_state.label == "inactive"
    found = ask("get_available_transitions").available_transitions
    assert [(t.transition.id, t.transition.label, t.goal_state.label) for t in found] == [
        (2, "cleanup", "cleaningup"),
        (3, "activate", "activating"),
        (6, "shutdown", "shuttingdown"),
    ]
    assert ask("change_state", label="activate").success
    assert ask("change_state", id=1, label="deactivate").success  # the label counts
    assert len(ask("get_available_states").available_states) == 11
    graph = ask("get_transition_graph").available_transitions
    assert (len(graph), graph[0].transition.label) == (25, "configure")
    wait_until(lambda: len(events) == 6)
    assert events[:2] == [("unconfigured", "configuring"), ("configuring", "inactive")]


@pytest.mark.parametrize("transition", [Transition.TRANSITION_ACTIVATE, 77])
def test_a_transition_that_does_not_start_here_is_answered_so(ros: Ros, transition: int) -> None:
    told = made(ros)
    ros.spin(told)
    client = ros.spun("asker").create_client(ChangeState, "/told/change_state")
    assert client.wait_for_service(10.0)
    request = ChangeState.Request(transition=Transition(id=transition))
    assert not ros.result(client.call_async(request)).success
    assert at(told) == "unconfigured"


def test_a_lifecycle_publisher_is_silent_unless_its_node_is_active(ros: Ros) -> None:
    node = made(ros, LifecycleNode)
    publisher = node.create_lifecycle_publisher(Int32, "a", 10)
    heard: list[int] = []
    listener = ros.spun("listener")
    listener.create_subscription(Int32, "a", lambda m: heard.append(m.data), 10)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    for number, transition in enumerate(("configure", "activate", "deactivate")):
        publisher.publish(Int32(data=number))
        go(node, transition)
        assert publisher.is_activated == (transition == "activate")
    publisher.publish(Int32(data=3))
    go(node, "activate")
    publisher.publish(Int32(data=4))
    wait_until(lambda: heard == [2, 4])
    assert publisher in list(node.publishers)
    assert node.destroy_lifecycle_publisher(publisher)
    assert not node.destroy_lifecycle_publisher(publisher)
