"""The requests about a node: its parameters, its log level, its lifecycle, and what it has."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from typing import Any, TypeVar

from archo_tui.errors import in_one_line
from archo_tui.robot.calls import QUESTION_TIMEOUT
from archo_tui.robot.graph.lifecycle import CHANGE_TIMEOUT
from archo_tui.robot.graph.nodes import set_level_command
from archo_tui.robot.graph.parameter_values import is_secret, masked
from archo_tui.robot.graph.resources import SEND
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.run import late_report, run
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.graph import NodeInfo, TopicInfo

T = TypeVar("T")


async def _ask(robot: Parts, work: Callable[[], Coroutine[Any, Any, T]]) -> T | Outcome:
    """Run a question on the ROS thread; return its answer, or why there is none."""
    try:
        return await robot.thread.run(work, QUESTION_TIMEOUT)
    except TimeoutError:
        text = f"no answer in {QUESTION_TIMEOUT:g} s from the console's own node"
        return Outcome(Code.TIMEOUT, text)
    except Exception as error:  # rclpy raises a dozen types, as for names that DDS allows.
        return Outcome(Code.REFUSED, in_one_line(error))


async def set_parameters(robot: Parts, node: str, values: Mapping[str, Any]) -> Outcome:
    """Set parameters of a node, all of them or none, and report it without secrets.

    The text of the outcome tells the values that the node reports then, or why it refused.
    """
    shown = masked(values)
    command = "" if any(map(is_secret, values)) else ros2_command.set_parameters(node, values)
    return await run(
        *(robot, "set", {"node": node, "values": shown}),
        *(f"set {node.lstrip('/')} {_texts(shown)}", command),
        lambda gate: robot.parameters.set(node, values, gate),
    )


def _texts(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {text_of(value)}" for name, value in values.items())


def on_parameters_restored(robot: Parts, node: str, values: Mapping[str, Any]) -> None:
    """Report that a hosted node was restarted, and given these parameters. Any thread."""
    shown = masked(values)
    text = f"set {node.lstrip('/')} {_texts(shown)} again: it was restarted"
    record = AuditRecord("set", {"node": node, "values": shown}, Code.DONE)
    robot.thread.submit(lambda: robot.reporter.report_done(text, record))


async def describe(robot: Parts, node: str) -> NodeInfo | Outcome:
    """Ask for what a node publishes, serves and uses, its log level and its transitions."""

    async def there() -> NodeInfo | None:
        found = await robot.nodes.describe(node)
        if found is None or not robot.lifecycles.word(node):
            return found
        return found._replace(transitions=await robot.lifecycles.transitions(node))

    return await _ask(robot, there) or Outcome(Code.REFUSED, "not on the graph")


async def topic_info(robot: Parts, topic: str) -> TopicInfo | Outcome:
    """Return the publishers and subscriptions of a topic, by its full name, with their QoS."""

    async def there() -> TopicInfo:
        return robot.nodes.topic_info(topic)

    return await _ask(robot, there)


async def types_anywhere(robot: Parts, name: str, *, is_action: bool = False) -> tuple[str, ...]:
    """Return the types with which nodes, also of other namespaces, serve a service or an action."""

    async def there() -> tuple[str, ...]:
        served = robot.graph.served_types(name + SEND if is_action else name)
        return tuple(kind.removesuffix("_SendGoal") for kind in served)

    found = await _ask(robot, there)
    return () if isinstance(found, Outcome) else found


async def log_level(robot: Parts, node: str) -> Outcome:
    """Ask a node for the level of its log, which the text of the outcome tells."""
    return await _ask(robot, lambda: robot.nodes.level(node))


async def set_log_level(robot: Parts, node: str, level: str) -> Outcome:
    """Set the level of a node's log, one of LEVELS, and report what it is then."""
    return await run(
        *(robot, "log_level", {"node": node, "level": level}),
        *(f"log level of {node.lstrip('/')} {level}", set_level_command(node, level)),
        lambda gate: robot.nodes.set_level(node, level, gate),
    )


async def change_lifecycle(robot: Parts, node: str, transition: str) -> Outcome:
    """Have a managed node make a transition, such as `activate`, and wait for its answer."""
    title = f"lifecycle {node.lstrip('/')} {transition}"
    arguments = {"node": node, "transition": transition}
    late = late_report(robot, title, "lifecycle", arguments)
    return await run(
        *(robot, "lifecycle", arguments, title, ros2_command.change_lifecycle(node, transition)),
        lambda gate: robot.lifecycles.change(node, transition, gate, late),
        CHANGE_TIMEOUT,
    )


async def lifecycle_transitions(robot: Parts, node: str) -> tuple[str, ...]:
    """Ask a managed node for the transitions that it can make now, as words: `activate`."""
    found = await _ask(robot, lambda: robot.lifecycles.transitions(node))
    return () if isinstance(found, Outcome) else found
