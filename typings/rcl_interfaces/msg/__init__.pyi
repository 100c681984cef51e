# Made by tests.stubs from the interface files; a test keeps it fresh.

from typing import Any, ClassVar

import builtin_interfaces.msg

class FloatingPointRange:
    from_value: float
    to_value: float
    step: float
    def __init__(self, *, from_value: float = ..., to_value: float = ..., step: float = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class IntegerRange:
    from_value: int
    to_value: int
    step: int
    def __init__(self, *, from_value: int = ..., to_value: int = ..., step: int = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class ListParametersResult:
    names: list[str]
    prefixes: list[str]
    def __init__(self, *, names: list[str] = ..., prefixes: list[str] = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class Log:
    DEBUG: ClassVar[int]
    INFO: ClassVar[int]
    WARN: ClassVar[int]
    ERROR: ClassVar[int]
    FATAL: ClassVar[int]
    stamp: builtin_interfaces.msg.Time
    level: int
    name: str
    msg: str
    file: str
    function: str
    line: int
    def __init__(self, *, stamp: builtin_interfaces.msg.Time = ..., level: int = ..., name: str = ..., msg: str = ..., file: str = ..., function: str = ..., line: int = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class LoggerLevel:
    LOG_LEVEL_UNKNOWN: ClassVar[int]
    LOG_LEVEL_DEBUG: ClassVar[int]
    LOG_LEVEL_INFO: ClassVar[int]
    LOG_LEVEL_WARN: ClassVar[int]
    LOG_LEVEL_ERROR: ClassVar[int]
    LOG_LEVEL_FATAL: ClassVar[int]
    name: str
    level: int
    def __init__(self, *, name: str = ..., level: int = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class Parameter:
    name: str
    value: ParameterValue
    def __init__(self, *, name: str = ..., value: ParameterValue = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class ParameterDescriptor:
    name: str
    type: int
    description: str
    additional_constraints: str
    read_only: bool
    dynamic_typing: bool
    floating_point_range: list[FloatingPointRange]
    integer_range: list[IntegerRange]
    def __init__(self, *, name: str = ..., type: int = ..., description: str = ..., additional_constraints: str = ..., read_only: bool = ..., dynamic_typing: bool = ..., floating_point_range: list[FloatingPointRange] = ..., integer_range: list[IntegerRange] = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class ParameterEvent:
    stamp: builtin_interfaces.msg.Time
    node: str
    new_parameters: list[Parameter]
    changed_parameters: list[Parameter]
    deleted_parameters: list[Parameter]
    def __init__(self, *, stamp: builtin_interfaces.msg.Time = ..., node: str = ..., new_parameters: list[Parameter] = ..., changed_parameters: list[Parameter] = ..., deleted_parameters: list[Parameter] = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class ParameterEventDescriptors:
    new_parameters: list[ParameterDescriptor]
    changed_parameters: list[ParameterDescriptor]
    deleted_parameters: list[ParameterDescriptor]
    def __init__(self, *, new_parameters: list[ParameterDescriptor] = ..., changed_parameters: list[ParameterDescriptor] = ..., deleted_parameters: list[ParameterDescriptor] = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class ParameterType:
    PARAMETER_NOT_SET: ClassVar[int]
    PARAMETER_BOOL: ClassVar[int]
    PARAMETER_INTEGER: ClassVar[int]
    PARAMETER_DOUBLE: ClassVar[int]
    PARAMETER_STRING: ClassVar[int]
    PARAMETER_BYTE_ARRAY: ClassVar[int]
    PARAMETER_BOOL_ARRAY: ClassVar[int]
    PARAMETER_INTEGER_ARRAY: ClassVar[int]
    PARAMETER_DOUBLE_ARRAY: ClassVar[int]
    PARAMETER_STRING_ARRAY: ClassVar[int]
    def __init__(self) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class ParameterValue:
    type: int
    bool_value: bool
    integer_value: int
    double_value: float
    string_value: str
    byte_array_value: list[bytes]
    bool_array_value: list[bool]
    integer_array_value: Any
    double_array_value: Any
    string_array_value: list[str]
    def __init__(self, *, type: int = ..., bool_value: bool = ..., integer_value: int = ..., double_value: float = ..., string_value: str = ..., byte_array_value: list[bytes] = ..., bool_array_value: list[bool] = ..., integer_array_value: Any = ..., double_array_value: Any = ..., string_array_value: list[str] = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class SetLoggerLevelsResult:
    successful: bool
    reason: str
    def __init__(self, *, successful: bool = ..., reason: str = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...

class SetParametersResult:
    successful: bool
    reason: str
    def __init__(self, *, successful: bool = ..., reason: str = ...) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
    def __received__(self) -> Any: ...
