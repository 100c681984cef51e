# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar

import builtin_interfaces.msg

class ServiceEventInfo:
    REQUEST_SENT: ClassVar[int]
    REQUEST_RECEIVED: ClassVar[int]
    RESPONSE_SENT: ClassVar[int]
    RESPONSE_RECEIVED: ClassVar[int]
    event_type: int
    stamp: builtin_interfaces.msg.Time
    client_gid: Any
    sequence_number: int
    def __init__(self, *, event_type: int = ..., stamp: builtin_interfaces.msg.Time = ..., client_gid: Any = ..., sequence_number: int = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...
