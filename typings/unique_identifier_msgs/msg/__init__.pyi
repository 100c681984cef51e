# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar


class UUID:
    uuid: Any
    def __init__(self, *, uuid: Any = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...
