"""The verbs about a node: its parameters, its log level, its lifecycle, what it has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.errors import in_one_line
from archo_tui.robot import ros2_command
from archo_tui.robot.calls import QUESTION_TIMEOUT
from archo_tui.robot.graph.lifecycle import CHANGE_TIMEOUT, Lifecycles
from archo_tui.robot.graph.nodes import Nodes, set_level_command
from archo_tui.robot.graph.parameters import Parameters, is_secret, masked
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.ros_thread import RosThread
from archo_tui.robot.state import NodeInfo, TopicInfo
from archo_tui.robot.verb_runner import VerbRunner

_NO_ANSWER = f"no answer in {QUESTION_TIMEOUT:g} s from the console's own node"


class NodeVerbs:
    """The verbs about one node: its parameters, log level and lifecycle, and questions about it.

    Called on the event loop. Only verbs that change something are reported as events.
    """

    def __init__(
        self,
        thread: RosThread,
        runner: VerbRunner,
        nodes: Nodes,
        parameters: Parameters,
        lifecycles: Lifecycles,
    ) -> None:
        self._thread, self._runner, self._nodes = thread, runner, nodes
        self._parameters, self._lifecycles = parameters, lifecycles

    async def set_parameters(self, node: str, values: Mapping[str, Any]) -> Outcome:
        """Set parameters of a node, all or none of them, and report it without secrets."""
        shown = masked(values)
        has_secret = any(map(is_secret, values))
        command = "" if has_secret else ros2_command.set_parameters(node, values)
        texts = ", ".join(f"{name} {text_of(value)}" for name, value in shown.items())
        return await self._runner.run(
            "set",
            {"node": node, "values": shown},
            f"set {node.lstrip('/')} {texts}",
            command,
            lambda gate: self._parameters.set(node, values, gate),
        )

    async def describe(self, node: str) -> NodeInfo | Outcome:
        """Return the topics, services, actions, log level and transitions of a node.

        The last two are asked of the node itself, and are missing if it does not answer.
        """
        try:
            found = await self._thread.run(lambda: self._describe(node), QUESTION_TIMEOUT)
            return found or Outcome(Code.REFUSED, "not on the graph")
        except TimeoutError:
            return Outcome(Code.TIMEOUT, _NO_ANSWER)
        except Exception as error:  # rclpy raises a dozen types, as for names that DDS allows.
            return Outcome(Code.REFUSED, in_one_line(error))

    async def _describe(self, node: str) -> NodeInfo | None:
        found = await self._nodes.describe(node)
        if found is None or not self._lifecycles.word(node):
            return found
        return found._replace(transitions=await self._lifecycles.transitions(node))

    async def topic_info(self, topic: str) -> TopicInfo | Outcome:
        """Return the publishers and subscriptions of a topic, or the outcome TIMEOUT.

        The timeout means that the console's own node does not answer. A topic that is not on the
        graph has no publishers and no subscriptions.

        Raises:
            ValueError: The name is not valid.
        """

        async def there() -> TopicInfo:
            return self._nodes.topic_info(topic)

        try:
            return await self._thread.run(there, QUESTION_TIMEOUT)
        except TimeoutError:
            return Outcome(Code.TIMEOUT, _NO_ANSWER)

    async def log_level(self, node: str) -> Outcome:
        """Ask a node for the level of its log, which the outcome's text names."""
        try:
            return await self._thread.run(lambda: self._nodes.level(node), QUESTION_TIMEOUT)
        except TimeoutError:
            return Outcome(Code.TIMEOUT, _NO_ANSWER)
        except Exception as error:
            return Outcome(Code.REFUSED, in_one_line(error))

    async def set_log_level(self, node: str, level: str) -> Outcome:
        """Set the level of a node's log, and report it; the outcome's text tells the new level.

        Raises:
            KeyError: The level is another word.
        """
        return await self._runner.run(
            "log_level",
            {"node": node, "level": level},
            f"log level of {node.lstrip('/')} {level}",
            set_level_command(node, level),
            lambda gate: self._nodes.set_level(node, level, gate),
        )

    async def change_lifecycle(self, node: str, transition: str) -> Outcome:
        """Have a managed node make a transition, wait for its answer, and report it.

        The outcome is that of `Lifecycles.change`. An answer that comes after CHANGE_TIMEOUT is
        reported as an event of its own.
        """
        title = f"lifecycle {node.lstrip('/')} {transition}"
        arguments = {"node": node, "transition": transition}
        late = self._runner.late_report(title, "lifecycle", arguments)
        return await self._runner.run(
            "lifecycle",
            arguments,
            title,
            ros2_command.change_lifecycle(node, transition),
            lambda gate: self._lifecycles.change(node, transition, gate, late),
            CHANGE_TIMEOUT,
        )

    async def lifecycle_transitions(self, node: str) -> tuple[str, ...]:
        """Return the words of the transitions that a managed node can make now."""
        try:
            return await self._thread.run(
                lambda: self._lifecycles.transitions(node), QUESTION_TIMEOUT
            )
        except TimeoutError:
            return ()
