"""The subscriptions to /tf and /tf_static, while somebody needs them. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from archo_tui.base.errors import ArchoError, in_one_line
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.runtime import Runtime
from archo_tui.robot.state.frames import Transforms, with_transforms
from archo_tui.robot.state.graph import node_of
from archo_tui.robot.topics.inspect import Inspection, missing_type

TF_MESSAGE = "tf2_msgs/msg/TFMessage"
_DEPTH = 100  # As tf2 has: many nodes may publish one static transform each, at once.


class FrameListener:
    """The transforms of the robot: those in its namespace if it has any, else all.

    They are received between `begin` and `end`; several may need them at a time.
    """

    def __init__(self, runtime: Runtime, graph: Graph, on_change: Callable[[], None]) -> None:
        self._node, self._clock = runtime.node, runtime.clock
        self._graph, self._on_change = graph, on_change
        self._users = 0
        self._inspections: dict[str, Inspection] = {}  # By `tf` and `tf_static`.
        self.transforms = Transforms()

    def begin(self) -> None:
        """Subscribe, if nobody has needed the transforms so far."""
        self._users += 1
        self.update()

    def end(self) -> None:
        """End the subscriptions, if nobody else needs the transforms."""
        self._users -= 1
        if not self._users:
            for inspection in self._inspections.values():
                inspection.unsubscribe()
            self._inspections, self.transforms = {}, Transforms()

    def update(self) -> None:
        """Fit the subscriptions to the present publishers; call this each second."""
        if self._users:
            moving, static = self._subscribe("tf"), self._subscribe("tf_static")
            # Only now: a subscription may have changed the transforms.
            found = self.transforms._replace(publishers=moving, static_publishers=static)
            self.transforms = found

    def _subscribe(self, name: str) -> tuple[str, ...]:
        """Subscribe to one of the topics, and return its publishers."""
        own, shared = self._node.resolve_topic_name(name), f"/{name}"
        topic = own if self._node.get_publishers_info_by_topic(own) else shared
        publishers = self._node.get_publishers_info_by_topic(topic)
        old = self._inspections.get(name)
        try:
            if old is not None and (old.topic == topic or not publishers):
                old.resubscribe_if_needed()
            elif publishers:
                if old is not None:
                    old.unsubscribe()
                self._inspect(name, topic)
        except Exception as error:  # Fast DDS allows one type of a topic in a process.
            self._inspections.pop(name, None)
            self._set_fault(f"{topic}: no subscription: {in_one_line(error)}")
        return tuple(sorted(node.lstrip("/") for node in set(map(node_of, publishers))))

    def _inspect(self, name: str, topic: str) -> None:
        message_class = load_class(TF_MESSAGE)
        if message_class is None:
            self._set_fault(missing_type(topic, TF_MESSAGE))
            return
        take = partial(self._take, name)
        made = Inspection(self._node, self._clock, topic, message_class, take, _DEPTH)
        self._inspections[name] = made  # First: a message may come at once.
        made.subscribe()

    def _set_fault(self, fault: str) -> None:
        self.transforms = self.transforms._replace(fault=fault)
        self._on_change()

    def _take(self, name: str, now: float, data: bytes, _was_kept: bool) -> None:
        try:
            received = self._inspections[name].decode(data).transforms
        except ArchoError as error:
            self._set_fault(f"{self._inspections[name].topic}: {error}")
            return
        # In simulated time a stamp is no time of day.
        wall_time = None if self._graph.has_clock else self._clock.now()
        frames = with_transforms(
            *(self.transforms.frames, received, now, wall_time), is_static=name == "tf_static"
        )
        self.transforms = self.transforms._replace(frames=frames, fault="")
        self._on_change()
