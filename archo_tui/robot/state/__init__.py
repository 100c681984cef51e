"""The types of a snapshot, which holds all that is known of the robot: each in its own file.

They are frozen. `received`, `sent` and the like are seconds on the monotonic clock of this
process, `time` is a Unix time. None means that nothing was received, or that this robot does not
report it.

Most are NamedTuples, which are made and copied in a fraction of a dataclass's time.
"""

from archo_tui.robot.state.diagnostic import GONE, WORST_FIRST, Diagnostic, DiagnosticLevel
from archo_tui.robot.state.event import LAUNCH, OWN_LEVELS, Event
from archo_tui.robot.state.goal import Goal, Phase, values_text
from archo_tui.robot.state.hosted import Hosted, Life
from archo_tui.robot.state.names import in_namespace, logger_node, not_offered
from archo_tui.robot.state.node import LEVELS, LogLevel, Names, NodeInfo, NodeState, level_word
from archo_tui.robot.state.parameter import (
    NO_PARAMETER_SERVICES,
    NOT_REPORTED,
    Parameter,
    linked_number,
)
from archo_tui.robot.state.resource import ACTION, SERVICE, TOPIC, Resource
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.state.stop import Latch, OpenStop, StopAnswer
from archo_tui.robot.state.telemetry import Battery, GaugeReading, Motion, Pose
from archo_tui.robot.state.topic_info import TopicEnd, TopicInfo
from archo_tui.robot.state.topic_view import (
    SHOWN_ELEMENTS,
    Curve,
    FieldKind,
    FieldView,
    Range,
    TopicRequest,
    TopicView,
)

__all__ = [
    "ACTION",
    "GONE",
    "LAUNCH",
    "LEVELS",
    "NOT_REPORTED",
    "NO_PARAMETER_SERVICES",
    "OWN_LEVELS",
    "SERVICE",
    "SHOWN_ELEMENTS",
    "TOPIC",
    "WORST_FIRST",
    "Battery",
    "Curve",
    "Diagnostic",
    "DiagnosticLevel",
    "Event",
    "FieldKind",
    "FieldView",
    "GaugeReading",
    "Goal",
    "Hosted",
    "Latch",
    "Life",
    "LogLevel",
    "Motion",
    "Names",
    "NodeInfo",
    "NodeState",
    "OpenStop",
    "Parameter",
    "Phase",
    "Pose",
    "Range",
    "Resource",
    "Snapshot",
    "StopAnswer",
    "TopicEnd",
    "TopicInfo",
    "TopicRequest",
    "TopicView",
    "in_namespace",
    "level_word",
    "linked_number",
    "logger_node",
    "not_offered",
    "values_text",
]
