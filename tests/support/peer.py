"""Another console, as far as it tells what it did."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.robot import acts
from archo_tui.robot.acts import Act
from archo_tui.robot.outcome import Code


class Peer(Node):
    """Does nothing, and says that it did."""

    def __init__(self, **options: Any) -> None:
        super().__init__("_archo_console_other_lab_1", **options)
        self._acts = self.create_publisher(String, acts.TOPIC, 10)

    def tell(self, verb: str) -> None:
        said = acts.write("other_lab_1", Act(verb, {}, Code.DONE), f"{verb}: done")
        self._acts.publish(String(data=said))
