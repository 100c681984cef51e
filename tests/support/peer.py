"""Another console, as far as it tells what it did."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.robot.outcome import Code
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord


class Peer(Node):
    """Does nothing, and says that it did."""

    def __init__(self, **options: Any) -> None:
        super().__init__("_archo_console_other_lab_1", **options)
        self._records = self.create_publisher(String, audit_records.TOPIC, 10)

    def tell(self, verb: str, code: Code = Code.DONE) -> None:
        record = AuditRecord(verb, {}, code)
        said = audit_records.to_json("other_lab_1", record, f"{verb}: {code.value}")
        self._records.publish(String(data=said))
