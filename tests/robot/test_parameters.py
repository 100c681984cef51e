"""Parameters of the robot's nodes: read as reported, set in order, secret, and who changed them."""

from __future__ import annotations

import asyncio
import json
from dataclasses import replace
from typing import Any

import pytest
from rcl_interfaces import srv
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from rosbags.highlevel import AnyReader

from archo_tui.base.paths import journal_file, state_file
from archo_tui.recordings import recorder, store
from archo_tui.robot.clients import CLIENT, CONSOLE, UnexplainedChanges
from archo_tui.robot.graph.parameter_values import is_secret
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.readings import Motion
from tests.support import clock
from tests.support.console import console
from tests.support.quiet import ended, until
from tests.support.robot import robot
from tests.support.ros import begin
from tests.support.shells import heard, raw, served, typed
from tests.support.stand_in import Made, beside


class Guest(Node):
    """Has a number."""

    def __init__(self, number: int = 1, **options: Any) -> None:
        super().__init__("guest", **options)
        self.declare_parameter("number", number)


async def test_parameters_of_a_node_that_comes_and_goes_come_and_go() -> None:
    guest = Made(Guest)
    async with robot(guest) as it:
        await until(lambda: it.snapshot.parameter("number"))
        outcome = await it.set_parameters("/guest", {"number": 2})
        assert outcome == (Code.DONE, "number is 2, was 1")
        parameter = it.snapshot.parameter("number")
        assert parameter is not None
        assert (parameter.value, parameter.initial, parameter.is_changed) == (2, 1, True)
        guest.node.declare_parameter("later", "x")
        await until(lambda: it.snapshot.parameter("later"))
        guest.node.destroy_node()
        await until(lambda: it.snapshot.parameter("number") is None)


async def test_values_of_a_node_that_was_restarted_under_its_name_are_read_again() -> None:
    keeper = Made(Node, "keeper")
    async with robot(keeper) as it:
        await until(lambda: keeper.node.executor is not None)
        guest = beside(keeper.node, Guest(context=keeper.node.context))
        await until(lambda: it.snapshot.parameter("number"))
        again: list[Node] = []

        def restart() -> None:  # between two looks at the graph, with no word on parameter events
            guest.destroy_node()
            given: Any = [Parameter("number", value=5)]
            node = Node("guest", context=keeper.node.context, parameter_overrides=given)
            node._parameter_events = None
            node.declare_parameter("number", 1)
            keeper.node.executor.add_node(node)  # type: ignore[union-attr]
            again.append(node)

        begin(keeper.node, restart)
        await until(lambda: it.snapshot.parameter("number").value == 5)  # type: ignore[union-attr]
        again[0].destroy_node()


async def test_what_is_commanded_at_once_reaches_the_node_in_its_order() -> None:
    numbers: list[int] = []

    class Noting(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("noting", **options)
            self.declare_parameter("number", 0)
            self.add_post_set_parameters_callback(lambda given: numbers.append(given[0].value))

    async with robot(Noting) as it:
        await until(lambda: it.snapshot.parameter("number"))
        each = [it.set_parameters("/noting", {"number": n}) for n in range(1, 6)]
        assert all(outcome.ok for outcome in await ended(asyncio.gather(*each)))
    assert numbers == [1, 2, 3, 4, 5]


class Unset(Node):
    """Has a parameter that was declared and never set, and one that is not a number."""

    def __init__(self, **options: Any) -> None:
        super().__init__("unset", **options)
        self.declare_parameter("speed", 0.5)
        self.declare_parameter("later", Parameter.Type.DOUBLE)
        self.declare_parameter("odd", float("nan"))


async def test_a_parameter_without_a_value_hides_none_of_the_others() -> None:
    async with robot(Unset) as it:
        await until(lambda: it.snapshot.parameter("speed"))
        known = {p.name: p for p in it.snapshot.parameters}
        assert (known["speed"].value, known["later"].value) == (0.5, None)
        assert known["later"].type == "double"
        assert not known["odd"].is_changed
        assert (await ended(it.set_parameters("/unset", {"later": 1.5}))).ok
        await until(lambda: it.snapshot.parameter("later").value == 1.5)  # type: ignore[union-attr]


async def test_a_value_that_is_not_read_back_is_not_said_to_be_as_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with robot(Unset) as it:
        await until(lambda: it.snapshot.parameter("speed"))
        call = it.node.call

        async def hangs(kind: Any, *given: Any, **options: Any) -> Any:
            return None if kind is srv.GetParameters else await call(kind, *given, **options)

        monkeypatch.setattr(it.node, "call", hangs)
        outcome = await ended(it.set_parameters("/unset", {"speed": 0.7}))
        said = "accepted, but /unset has not reported the new value; speed was 0.5"
        assert outcome == (Code.DONE, said)


async def test_a_parameter_without_a_value_is_edited_from_an_empty_field() -> None:
    async with console(node_makers=[Unset], wait=False) as op:
        await op.until("later")
        assert "--" in op.line("later")
        assert "*" not in op.line("odd")
        await op.press("4", "slash", *"later", "enter")
        await op.at(clock.seconds() + 1.0)
        await op.press("enter", *"2.5", "enter")
        await op.until("2.5 *")


class Mute(Node):
    """Offers its parameters and never answers when asked for them."""

    def __init__(self, **options: Any) -> None:
        super().__init__("mute", **options, start_parameter_services=False)
        self.asked: list[float] = []
        self.never: Future[bool] = Future()
        group = ReentrantCallbackGroup()
        for name in ("list", "get", "describe"):
            kind = getattr(srv, f"{name.capitalize()}Parameters")
            self.create_service(kind, f"~/{name}_parameters", self.ask, callback_group=group)

    async def ask(self, _: Any, response: Any) -> Any:
        self.asked.append(clock.seconds())
        await self.never
        return response


async def test_a_node_that_never_answers_is_asked_ever_more_rarely_but_not_never() -> None:
    mute = Made(Mute)
    async with robot(mute):
        await until(lambda: mute.node.asked)
        # so long as real time may take: two questions; a clock that is moved, ten minutes
        end = mute.node.asked[0] + (10.0 if clock.current is None else 600.0)
        while clock.seconds() < end:
            step = clock.seconds() + 90.0 if clock.current is not None else end
            await until(lambda step=step: clock.seconds() >= step)  # type: ignore[misc]
        gaps = [b - a for a, b in zip(mute.node.asked, mute.node.asked[1:], strict=False)]
        assert gaps
        assert max(gaps) < 80.0  # 60 s, the answers' deadlines and a look


# Who changed them: what no console reports to have done is another client's doing.


def set_(node: str, code: Code = Code.DONE, **values: Any) -> AuditRecord:
    return AuditRecord("set", {"node": node, "values": values}, code)


def test_what_was_not_answered_in_time_is_ours_when_it_is_done_later() -> None:
    others = UnexplainedChanges()
    others.on_audit_record(set_("/motor", Code.TIMEOUT, speed=0.5), 10.0)
    others.on_audit_record(set_("/motor", ramp=2.0), 10.0)
    others.on_parameter("/motor", "speed", 1.0, 0.5, 15.0)
    others.on_parameter("/motor", "ramp", 2.0, 3.0, 15.0)
    assert others.take_due(19.5) == ["motor ramp changed by another client: 3.0, was 2.0"]
    others.on_parameter("/motor", "speed", 0.5, 0.6, 40.0)
    assert others.take_due(44.5) == ["motor speed changed by another client: 0.6, was 0.5"]


def test_what_a_console_says_late_is_still_its_doing() -> None:
    others = UnexplainedChanges()
    moving = Motion(count=1, moving=True, stopped=False, received=10.0)
    others.on_motion(moving, 10.0)
    others.on_motion(replace(moving, stopped=True, received=10.2), 10.2)
    assert others.take_due(13.0) == []
    others.on_audit_record(AuditRecord("stop", {}, Code.TIMEOUT), 13.1)
    assert others.take_due(20.0) == []


@pytest.mark.pure
@pytest.mark.parametrize(
    ("record", "is_explained"),
    [
        (set_("/motor", speed=0.5), True),
        (set_("/motor", ramp=1.0, speed=0.5), True),
        (set_("/motor", Code.REFUSED, speed=0.5), True),  # it may have been done in part
        (set_("/motor", Code.CANCELLED, speed=0.5), False),  # it never left
        (set_("/motor", ramp=2.0), False),
        (set_("/other", speed=0.5), False),
        (AuditRecord("stop", {"node": "/motor", "values": {"speed": 0.5}}, Code.DONE), False),
        (AuditRecord("set", {"node": "/motor", "values": "speed"}, Code.DONE), False),
        (AuditRecord("set", {}, Code.DONE), False),
    ],
)
def test_a_change_of_a_parameter_is_explained_by_its_node_and_name(
    record: AuditRecord, is_explained: bool
) -> None:
    others = UnexplainedChanges()
    others.on_audit_record(record, 10.0)
    others.on_parameter("/motor", "speed", 1.0, 0.5, 10.5)
    said = [] if is_explained else ["motor speed changed by another client: 0.5, was 1.0"]
    assert others.take_due(15.0) == said


def test_where_a_console_does_not_tell_what_it_does_it_may_have_been_that() -> None:
    others = UnexplainedChanges()
    others.author = CONSOLE
    others.on_parameter("/motor", "speed", 1.0, 0.5, 10.0)
    others.author = CLIENT  # it has left since
    assert others.take_due(15.0) == ["motor speed changed by another console: 0.5, was 1.0"]


# Secrets: which names are, and who does not get to see the values.

SECRET = [
    *("password", "Password", "wifi.password", "WIFI_PASSWORD_2", "auth_tokens", "token_file"),
    *("key", "api_key", "apiKey", "APIKey", "key2", "api_key.value", "client-secret", "keys"),
    *("dbpassword", "WIFIPASSWORD", "authtokens", "clientsecret.value", "apikey", "mapsapikey"),
]


OPEN = [
    *("monkey", "key_bindings", "keyframe", "key_rate.hz", "turkey", "tokenizer", "secretary"),
    *("passwordless", "max_speed", ""),
]


@pytest.mark.pure
def test_words_of_a_name_make_it_a_secret_and_parts_of_words_do_not() -> None:
    assert list(filter(is_secret, SECRET + OPEN)) == SECRET


class Door(Node):
    """Has a secret, and refuses one by quoting it."""

    def __init__(self, **options: Any) -> None:
        super().__init__("door", **options)
        described = ParameterDescriptor(description="of the gate")
        self.declare_parameter("api_key", "hunter2", described)
        self.declare_parameter("pin_secret", 471135082)
        self.declare_parameter("key_bindings", "qwerty")
        self.add_on_set_parameters_callback(self.check)

    def check(self, parameters: list[Any]) -> SetParametersResult:
        bad = [one.value for one in parameters if one.value == "letmein"]
        return SetParametersResult(successful=not bad, reason=f"weak: {bad[0]}" if bad else "")


@pytest.mark.real_time
async def test_only_the_operator_sees_a_secret(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "SECONDS_AFTER", 0.2)
    async with served(Door) as person:
        person.type("set door api_key s3same\nset door pin_secret 843237972\n")
        person.type("set door key_bindings dvorak\n")
        await heard(person, "key_bindings is dvorak, was qwerty")
        assert "set door api_key ***: api_key is ***, was ***" in person.said
        person.type("set door api_key letmein\n")
        await heard(person, "weak: ***")
        client = await raw()
        await client.line()
        told = ""
        for number, words in enumerate((["params"], ["get", "door", "api_key"], ["events", "99"])):
            client.send({"id": number, "assistant": True, "words": words})
            told += json.dumps(await client.line())
        client.close()
        shown = await typed("get", "door", "api_key")
        assert "api_key is s3same, was hunter2 at the start" in shown.out  # the operator's own
        assert (await typed("keep")).code == 0
        await person.end()
    (recording,) = store.list_recordings(state_file("recordings"))
    with AnyReader([recording.folder]) as reader:
        recorded = b"".join(data for _, _, data in reader.messages()).decode(errors="replace")
    journal = journal_file().read_text()
    for secret in ("s3same", "hunter2", "letmein", "843237972", "471135082"):
        for where in (told, recorded, journal):
            assert secret not in where, secret
    for where in (told, recorded, journal):
        assert "dvorak" in where
