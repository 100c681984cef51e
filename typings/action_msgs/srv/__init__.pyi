# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar

import action_msgs.msg

class CancelGoal:
    class Request:
        goal_info: action_msgs.msg.GoalInfo
        def __init__(self, *, goal_info: action_msgs.msg.GoalInfo = ...) -> None: ...
        @classmethod
        def get_fields_and_field_types(cls) -> dict[str, str]: ...
        def __received__(self) -> Any: ...

    class Response:
        ERROR_NONE: ClassVar[int]
        ERROR_REJECTED: ClassVar[int]
        ERROR_UNKNOWN_GOAL_ID: ClassVar[int]
        ERROR_GOAL_TERMINATED: ClassVar[int]
        return_code: int
        goals_canceling: list[action_msgs.msg.GoalInfo]
        def __init__(self, *, return_code: int = ..., goals_canceling: list[action_msgs.msg.GoalInfo] = ...) -> None: ...
        @classmethod
        def get_fields_and_field_types(cls) -> dict[str, str]: ...
        def __received__(self) -> Any: ...
