# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar

import builtin_interfaces.msg

class Clock:
    clock: builtin_interfaces.msg.Time
    def __init__(self, *, clock: builtin_interfaces.msg.Time = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...
