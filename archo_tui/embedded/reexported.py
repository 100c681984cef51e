"""The names that a module of rclpy has only because it imports them, and programs import from it.

`from rclpy.node import ReentrantCallbackGroup` is such an import: it works on real ROS 2, too.
"""

from __future__ import annotations

REEXPORTED: dict[
    str, dict[str, str]
] = {  # By module: the modules that define the names, and the names.
    "rclpy": {
        "rclpy.parameter": "Parameter",
        "rclpy.qos": "QoSProfile",
        "rclpy.signals": "install_signal_handlers uninstall_signal_handlers",
    },
    "rclpy.action.client": {
        "rclpy.clock": "Clock",
        "rclpy.executors": "await_or_execute",
        "rclpy.service_introspection": "ServiceIntrospectionState",
        "rclpy.type_support": "check_for_type_support",
        "rclpy.waitable": "NumberOfEntities Waitable",
    },
    "rclpy.action.graph": {
        "rclpy.node": "Node",
    },
    "rclpy.action.server": {
        "rclpy.clock": "Clock",
        "rclpy.service_introspection": "ServiceIntrospectionState",
        "rclpy.task": "Task",
        "rclpy.type_support": "check_for_type_support",
        "rclpy.waitable": "NumberOfEntities Waitable",
    },
    "rclpy.client": {
        "rclpy.clock": "Clock",
        "rclpy.service_introspection": "ServiceIntrospectionState",
    },
    "rclpy.event_handler": {
        "rclpy.waitable": "NumberOfEntities Waitable",
    },
    "rclpy.executors": {
        "rclpy._rclpy_pybind11": "InvalidHandle TimerCancelledError",
        "rclpy.client": "Client",
        "rclpy.clock": "Clock",
        "rclpy.clock_type": "ClockType",
        "rclpy.guard_condition": "GuardCondition",
        "rclpy.service": "Service",
        "rclpy.signals": "SignalHandlerGuardCondition",
        "rclpy.subscription": "MessageInfo Subscription",
        "rclpy.timer": "Timer TimerInfo",
        "rclpy.utilities": "timeout_sec_to_nsec",
        "rclpy.waitable": "NumberOfEntities Waitable",
    },
    "rclpy.lifecycle.node": {
        "rclpy.callback_groups": "CallbackGroup",
        "rclpy.impl.rcutils_logger": "RcutilsLogger",
        "rclpy.qos": "QoSProfile",
        "rclpy.service": "Service",
        "rclpy.type_support": "check_is_valid_srv_type",
    },
    "rclpy.lifecycle.publisher": {
        "rclpy.callback_groups": "CallbackGroup",
        "rclpy.event_handler": "PublisherEventCallbacks",
        "rclpy.qos": "QoSProfile",
    },
    "rclpy.logging_service": {
        "rcl_interfaces.srv": "GetLoggerLevels SetLoggerLevels",
        "rclpy.qos": "qos_profile_services_default",
    },
    "rclpy.node": {
        "rcl_interfaces.msg": (
            "FloatingPointRange IntegerRange ListParametersResult Parameter=ParameterMsg "
            "ParameterType ParameterValue SetParametersResult"
        ),
        "rcl_interfaces.srv": "ListParameters",
        "rclpy._rclpy_pybind11": "InvalidHandle",
        "rclpy.callback_groups": "ReentrantCallbackGroup",
        "rclpy.exceptions": (
            "InvalidParameterTypeException InvalidParameterValueException "
            "InvalidTopicNameException ParameterAlreadyDeclaredException "
            "ParameterImmutableException ParameterNotDeclaredException "
            "ParameterUninitializedException"
        ),
        "rclpy.expand_topic_name": "expand_topic_name",
        "rclpy.guard_condition": "GuardCondition",
        "rclpy.logging": "get_logger",
        "rclpy.qos_overriding_options": "QoSOverridingOptions",
        "rclpy.subscription": "MessageInfo",
        "rclpy.subscription_content_filter_options": "ContentFilterOptions",
        "rclpy.timer": "TimerInfo",
        "rclpy.type_description_service": "TypeDescriptionService",
        "rclpy.validate_full_topic_name": "validate_full_topic_name",
        "rclpy.validate_namespace": "validate_namespace",
        "rclpy.validate_node_name": "validate_node_name",
        "rclpy.validate_parameter_name": "validate_parameter_name",
        "rclpy.validate_topic_name": "validate_topic_name",
        "rclpy.waitable": "Waitable",
    },
    "rclpy.parameter_client": {
        "rcl_interfaces.msg": "Parameter=ParameterMsg",
        "rcl_interfaces.srv": (
            "DescribeParameters GetParameterTypes GetParameters ListParameters SetParameters "
            "SetParametersAtomically"
        ),
        "rclpy.client": "Client",
        "rclpy.event_handler": "SubscriptionEventCallbacks",
        "rclpy.node": "Node",
        "rclpy.qos_overriding_options": "QoSOverridingOptions",
        "rclpy.subscription": "MessageInfo Subscription",
    },
    "rclpy.parameter_service": {
        "rcl_interfaces.msg": "ListParametersResult",
        "rcl_interfaces.srv": (
            "DescribeParameters GetParameterTypes GetParameters ListParameters SetParameters "
            "SetParametersAtomically"
        ),
    },
    "rclpy.publisher": {
        "rclpy.callback_groups": "CallbackGroup",
        "rclpy.event_handler": "EventHandler PublisherEventCallbacks",
    },
    "rclpy.qos_event": {
        "rclpy.callback_groups": "CallbackGroup",
        "rclpy.event_handler": (
            "QoSEventHandler QoSLivelinessChangedInfo QoSLivelinessLostInfo "
            "QoSOfferedDeadlineMissedInfo QoSRequestedDeadlineMissedInfo"
        ),
        "rclpy.logging": "get_logger",
        "rclpy.qos": "qos_policy_name_from_kind",
        "rclpy.waitable": "NumberOfEntities Waitable",
    },
    "rclpy.serialization": {
        "rclpy.type_support": "check_for_type_support",
    },
    "rclpy.service": {
        "rclpy.clock": "Clock",
        "rclpy.service_introspection": "ServiceIntrospectionState",
    },
    "rclpy.signals": {
        "rclpy._rclpy_pybind11": "InvalidHandle",
        "rclpy.guard_condition": "GuardCondition",
    },
    "rclpy.subscription": {
        "rclpy._rclpy_pybind11": "RCLError",
        "rclpy.event_handler": "EventHandler SubscriptionEventCallbacks",
        "rclpy.subscription_content_filter_options": "ContentFilterOptions",
    },
    "rclpy.timer": {
        "rclpy._rclpy_pybind11": "InvalidHandle",
        "rclpy.utilities": "get_default_context",
    },
    "rclpy.topic_endpoint_info": {
        "rclpy.qos": "QoSHistoryPolicy QoSPresetProfiles",
        "rclpy.type_hash": "TypeHash",
    },
    "rclpy.validate_full_topic_name": {
        "rclpy.exceptions": "InvalidServiceNameException InvalidTopicNameException",
    },
    "rclpy.validate_namespace": {
        "rclpy.exceptions": "InvalidNamespaceException",
    },
    "rclpy.validate_node_name": {
        "rclpy.exceptions": "InvalidNodeNameException",
    },
    "rclpy.validate_topic_name": {
        "rclpy.exceptions": "InvalidServiceNameException InvalidTopicNameException",
    },
}


def home_of(module: str, name: str) -> tuple[str, str]:
    """Return the module that defines a name which `module` re-exports, and the name in that module.

    Both are empty when `module` does not re-export the name.
    """
    for home, names in REEXPORTED.get(module, {}).items():
        for entry in names.split():
            made_as, _, exported_as = entry.partition("=")
            if name == (exported_as or made_as):
                return home, made_as
    return "", ""
