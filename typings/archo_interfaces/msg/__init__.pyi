# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar


class BatteryStatus:
    percentage: float
    voltage: float
    is_charging: bool
    battery_health: str
    def __init__(self, *, percentage: float = ..., voltage: float = ..., is_charging: bool = ..., battery_health: str = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class MotorStatus:
    encoder_ticks: int
    speed: float
    moving: bool
    emergency_stopped: bool
    def __init__(self, *, encoder_ticks: int = ..., speed: float = ..., moving: bool = ..., emergency_stopped: bool = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...
