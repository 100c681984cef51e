# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar

import builtin_interfaces.msg
import unique_identifier_msgs.msg

class GoalInfo:
    goal_id: unique_identifier_msgs.msg.UUID
    stamp: builtin_interfaces.msg.Time
    def __init__(self, *, goal_id: unique_identifier_msgs.msg.UUID = ..., stamp: builtin_interfaces.msg.Time = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class GoalStatus:
    STATUS_UNKNOWN: ClassVar[int]
    STATUS_ACCEPTED: ClassVar[int]
    STATUS_EXECUTING: ClassVar[int]
    STATUS_CANCELING: ClassVar[int]
    STATUS_SUCCEEDED: ClassVar[int]
    STATUS_CANCELED: ClassVar[int]
    STATUS_ABORTED: ClassVar[int]
    goal_info: GoalInfo
    status: int
    def __init__(self, *, goal_info: GoalInfo = ..., status: int = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class GoalStatusArray:
    status_list: list[GoalStatus]
    def __init__(self, *, status_list: list[GoalStatus] = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...
