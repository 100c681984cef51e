"""Questions about the nodes of a program, answered where it runs, on either engine."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterable, Mapping
from traceback import extract_stack
from types import FrameType
from typing import Any
from weakref import WeakSet

from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from archo_tui.base.errors import in_one_line
from archo_tui.robot.messages.types import name_of
from archo_tui.user_code.errors import OwnCode, code_of
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.interrupt import frame_of, stack_of

# The functions of rclpy that return only after other nodes have done something.
_WAITING_FUNCTIONS = {
    *("spin", "spin_once", "spin_until_future_complete"),
    *("wait_for_server", "wait_for_service", "wait_for_services"),
}
# How the types of interfaces, and the names of parameters, begin that every node has.
_OF_EVERY_NODE = (
    *("rcl_interfaces/", "type_description_interfaces/"),
    *("qos_overrides.", "use_sim_time", "start_type_description_service"),
)


class Probe:
    """The answers to questions about the nodes of a program, as plain data.

    The questions are `nodes`, `busy`, `constructor`, `set` and `wake`.
    """

    def __init__(
        self,
        code: OwnCode,
        nodes: Callable[[], Iterable[Node]],
        threads: Callable[[], Iterable[threading.Thread]],
    ) -> None:
        self._code, self._nodes, self._threads = code, nodes, threads

    def answer(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Answer a question, wake nodes, or set values of one; {} if one is just made or gone."""
        with contextlib.suppress(Exception):
            if request["ask"] == "nodes":
                return {"nodes": [self._described(node) for node in self._nodes()]}
            if request["ask"] == "busy":
                return {"busy": self.busy_line()}
            if request["ask"] == "constructor":
                found = map(self.constructor_line, self._threads())
                return {"constructor": next(filter(None, found), "")}
            for node in self._nodes():
                if request["ask"] == "wake" and node.executor is not None:
                    # An executor of threads raises what a callback raised at its next turn.
                    node.executor.create_task(lambda: None)
                elif node.get_fully_qualified_name() == request.get("node"):
                    vars(node).update(request["values"])
        return {}

    def busy_line(self) -> str:
        """Return `FILE:LINE, in: ...` of the line of the file that a thread executes, or ""."""
        for thread in self._threads():
            for frame in _frames(thread):
                if _waits(frame):
                    break
                if self._code.is_own(frame.f_code.co_filename):
                    where, line = self._code.place(extract_stack(frame, limit=1))
                    return f"{where}{line}"
        return ""

    def constructor_line(self, thread: threading.Thread) -> str:
        """Return `FILE:LINE: Talker.__init__ has not returned, in: ...` of a thread, or ""."""
        class_name = constructed_class(thread)
        if not class_name:
            return ""
        where, line = self._code.place(stack_of(thread))
        does = "waits for other nodes" if waits_for_others(thread) else "has not returned"
        return f"{where}: {class_name}.__init__ {does}{line}"

    def _described(self, node: Node) -> dict[str, Any]:
        """Return a node's interfaces and parameters, but those of every node, and its numbers."""
        actions = get_action_server_names_and_types_by_node(
            node, node.get_name(), node.get_namespace()
        )
        publishers = ((p.topic_name, p.msg_type, None) for p in node.publishers)
        subscriptions = ((s.topic_name, s.msg_type, s.callback) for s in node.subscriptions)
        services = ((s.service_name, s.srv_type, s.callback) for s in node.services)
        return {
            "name": node.get_fully_qualified_name(),
            "publishers": self._interfaces(publishers),
            "subscriptions": self._interfaces(subscriptions),
            "services": self._interfaces(services),
            "actions": {name: {"type": types[0]} for name, types in actions},
            "parameters": {
                name: _plain(node.get_parameter_or(name).value)
                for name in node.list_parameters([], 0).names
                if not name.startswith(_OF_EVERY_NODE)
            },
            "numbers": {
                attribute: value
                for attribute, value in vars(node).items()
                if type(value) in (int, float)
            },
        }

    def _interfaces(self, found: Iterable[tuple[str, Any, Any]]) -> dict[str, dict[str, str]]:
        """Return the type of each name, and the place of its callback, if it has one."""
        typed = ((name, name_of(kind), callback) for name, kind, callback in found)
        return {
            name: {"type": kind, "place": self._place_of(callback)}
            for name, kind, callback in typed
            if "/_action/" not in name and not kind.startswith(_OF_EVERY_NODE)
        }

    def _place_of(self, callback: Any) -> str:
        """Return `FILE:LINE: ` of the definition of a callback in the program's files, or ""."""
        code = code_of(callback)
        if code is None or not self._code.is_own(code.co_filename):
            return ""
        return f"{self._code.display_name(code.co_filename)}:{code.co_firstlineno}: "


def _plain(value: Any) -> Any:
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def restore(node: Node, values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Set parameters on a node that does not spin; return those taken, and why others were not."""
    taken, refused = {}, {}
    for name, value in values.items():
        try:
            result = node.set_parameters([Parameter(name, value=value)])[0]
            reason = "" if result.successful else result.reason or "refused"
        except Exception as error:  # The user's callback may raise anything.
            reason = in_one_line(error)
        if reason:
            refused[name] = reason
        else:
            taken[name] = value
    return taken, refused


class SpinWatch:
    """The spins of a program's nodes: the first of each, and those that take one away."""

    def __init__(
        self,
        file: ProgramFile,
        operator_values: Callable[[str], Mapping[str, Any]],
        report: Callable[..., object],
    ) -> None:
        self._file, self._operator_values, self._report = file, operator_values, report
        self._spun: WeakSet[Node] = WeakSet()
        self._taken: WeakSet[Node] = WeakSet()

    def add(self, node: Node, executor: Executor, global_executor: Executor | None) -> None:
        """Report a node's first spin, after the operator's values were restored; or a mistake.

        The spins of its constructor do not count: it may not have declared its parameters yet. As
        `HostedProgram.take_report` has it, the report is `spins` and `restored`, or `warning`.
        """
        if constructed_class(threading.current_thread()):
            return
        name, before = node.get_fully_qualified_name(), node.executor
        if node not in self._spun:
            self._spun.add(node)
            declared = [*node.list_parameters([], 0).names]
            self._report(spins=[name, declared], all_spin=len(self._spun) >= self._file.class_count)
            if values := self._operator_values(name):
                self._report(restored=[name, *restore(node, values)])
        elif (
            before is not None
            and before not in (executor, global_executor)
            and node not in self._taken
            and node in before.get_nodes()
        ):
            self._taken.add(node)
            (where, line), short = self._file.code.place(extract_stack()), node.get_name()
            what = f"takes {short} from the executor of main(), which calls nothing of {short}"
            text = f"{where}: {what} any more: pass executor=self.executor{line}"
            self._report(warning=[name, text])


def destroy(node: Node) -> None:
    """Take a node off the graph, with its action servers and clients.

    rclpy leaves action servers and clients on the graph until they are garbage collected. Beside
    the next node of the same name, they would be second servers of its actions.
    """
    for waitable in list(getattr(node, "waitables", ())):
        destroy_waitable = getattr(waitable, "destroy", None)
        if destroy_waitable is not None:
            destroy_waitable()
    node.destroy_node()


def served_names(node: Node) -> tuple[str, ...]:
    """Return the full names of a node's services and actions, sorted.

    Services below the node's own name (`NODE/...`), such as those of its parameters, and those of
    which an action consists are left out.
    """
    own = f"{node.get_fully_qualified_name()}/"
    names = {service.service_name for service in node.services}
    services = {name for name in names if not name.startswith(own) and "/_action/" not in name}
    actions = get_action_server_names_and_types_by_node(node, node.get_name(), node.get_namespace())
    return tuple(sorted(services | {name for name, _ in actions}))


def waits_for_others(thread: threading.Thread) -> bool:
    """Return True if a thread is within `rclpy.spin` or its like, or waits for a server.

    A callback that the spin runs counts as within it.
    """
    return any(map(_waits, _frames(thread)))


def _waits(frame: FrameType) -> bool:
    module = frame.f_globals.get("__name__", "").partition(".")[0]
    return module == "rclpy" and frame.f_code.co_name in _WAITING_FUNCTIONS


def constructed_class(thread: threading.Thread) -> str:
    """Return the name of the class of the node in whose constructor a thread is, or ""."""
    for frame in _frames(thread):
        this = frame.f_locals.get("self") if frame.f_code.co_name == "__init__" else None
        if isinstance(this, Node):
            return type(this).__name__
    return ""


def _frames(thread: threading.Thread) -> Iterable[FrameType]:
    """Yield the frames of a thread as it is now, the innermost first."""
    frame = frame_of(thread)
    while frame is not None:
        yield frame
        frame = frame.f_back
