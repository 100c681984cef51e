# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar


class MoveToShelf:
    class Goal:
        shelf_number: int
        def __init__(self, *, shelf_number: int = ...) -> None: ...
        @classmethod
        def get_fields_and_field_types(cls) -> dict[str, str]: ...
        def __received__(self) -> Any: ...

    class Result:
        success: bool
        final_message: str
        def __init__(self, *, success: bool = ..., final_message: str = ...) -> None: ...
        @classmethod
        def get_fields_and_field_types(cls) -> dict[str, str]: ...
        def __received__(self) -> Any: ...

    class Feedback:
        distance_remaining: float
        status: str
        def __init__(self, *, distance_remaining: float = ..., status: str = ...) -> None: ...
        @classmethod
        def get_fields_and_field_types(cls) -> dict[str, str]: ...
        def __received__(self) -> Any: ...

    Impl: ClassVar[Any]
