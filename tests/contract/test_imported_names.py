"""Two hundred names that public programs import from rclpy, each from where they import it."""

from __future__ import annotations

import pytest

from tests.support import chosen

pytestmark = pytest.mark.pure

# The embedded engine leaves out those with a `!`, as docs/embedded_engine.md says.
IMPORTED = """\
rclpy: init shutdown try_shutdown ok spin spin_once spin_until_future_complete create_node
    get_default_context get_global_executor Context Future Parameter SignalHandlerOptions
rclpy.node: Node Rate Publisher Subscription Client Service Timer Clock Parameter QoSProfile
    CallbackGroup ReentrantCallbackGroup MutuallyExclusiveCallbackGroup SetParametersResult
    ParameterDescriptor FloatingPointRange IntegerRange ParameterType ParameterEvent
    ParameterValue get_logger Context Executor ROSClock NodeNameNonExistentError
rclpy.action: ActionClient ActionServer CancelResponse GoalResponse
    get_action_client_names_and_types_by_node get_action_names_and_types
    get_action_server_names_and_types_by_node
rclpy.action.client: ActionClient ClientGoalHandle GoalStatus
rclpy.action.server: ActionServer CancelResponse GoalEvent GoalResponse ServerGoalHandle
    GoalStatus default_cancel_callback default_goal_callback default_handle_accepted_callback
rclpy.callback_groups: CallbackGroup MutuallyExclusiveCallbackGroup ReentrantCallbackGroup
rclpy.client: Client Future
rclpy.clock: Clock ClockType ROSClock ClockChange! JumpThreshold! TimeJump! JumpHandle!
rclpy.constants: S_TO_NS
rclpy.context: Context
rclpy.duration: Duration Infinite
rclpy.event_handler: PublisherEventCallbacks SubscriptionEventCallbacks QoSMessageLostInfo
    QoSOfferedIncompatibleQoSInfo QoSRequestedIncompatibleQoSInfo IncompatibleTypeInfo
    UnsupportedEventTypeError QoSRequestedDeadlineMissedInfo! QoSOfferedDeadlineMissedInfo!
    QoSLivelinessChangedInfo! QoSLivelinessLostInfo!
rclpy.exceptions: InvalidHandle InvalidNodeNameException InvalidNamespaceException
    InvalidParameterException InvalidParameterTypeException InvalidParameterValueException
    InvalidServiceNameException InvalidTopicNameException NameValidationException
    NotInitializedException ParameterAlreadyDeclaredException ParameterException
    ParameterImmutableException ParameterNotDeclaredException ParameterUninitializedException
    ROSInterruptException NoTypeSupportImportedException
rclpy.executors: Executor ExternalShutdownException MultiThreadedExecutor ShutdownException
    SingleThreadedExecutor TimeoutException ConditionReachedException await_or_execute
rclpy.experimental: EventsExecutor!
rclpy.expand_topic_name: expand_topic_name!
rclpy.guard_condition: GuardCondition!
rclpy.impl.implementation_singleton: rclpy_implementation
rclpy.impl.logging_severity: LoggingSeverity
rclpy.impl.rcutils_logger: RcutilsLogger
rclpy.lifecycle: LifecycleNode LifecyclePublisher LifecycleState Node Publisher State
    TransitionCallbackReturn
rclpy.logging: LoggingSeverity get_logger set_logger_level get_logger_effective_level
    get_logging_severity_from_string get_logger_level get_logging_directory!
rclpy.parameter: Parameter ParameterType ParameterMsg ParameterValue get_parameter_value
    parameter_value_to_python parameter_dict_from_yaml_file! PARAMETER_SEPARATOR_STRING
rclpy.parameter_client: AsyncParameterClient
rclpy.parameter_event_handler: ParameterEventHandler!
rclpy.parameter_service: ParameterService
rclpy.publisher: Publisher
rclpy.qos: DurabilityPolicy HistoryPolicy LivelinessPolicy QoSDurabilityPolicy QoSHistoryPolicy
    QoSLivelinessPolicy QoSPresetProfiles QoSProfile QoSReliabilityPolicy ReliabilityPolicy
    qos_profile_action_status_default qos_profile_parameter_events qos_profile_parameters
    qos_profile_sensor_data qos_profile_services_default qos_profile_system_default
    qos_profile_unknown qos_profile_best_available InvalidQoSProfileException Duration
    QoSPolicyKind qos_check_compatible! QoSCompatibility!
rclpy.qos_overriding_options: QoSOverridingOptions! QosCallbackResult! QoSPolicyKind!
rclpy.serialization: deserialize_message serialize_message
rclpy.service: Service
rclpy.service_introspection: ServiceIntrospectionState!
rclpy.signals: SignalHandlerOptions
rclpy.subscription: Subscription
rclpy.task: Future Task
rclpy.time: Duration Time
rclpy.time_source: TimeSource
rclpy.timer: Rate Timer
rclpy.topic_endpoint_info: TopicEndpointInfo TopicEndpointTypeEnum
rclpy.topic_or_service_is_hidden: topic_or_service_is_hidden!
rclpy.type_support: check_for_type_support check_is_valid_msg_type check_is_valid_srv_type
rclpy.utilities: get_available_rmw_implementations get_default_context
    get_rmw_implementation_identifier ok remove_ros_args shutdown timeout_sec_to_nsec try_shutdown
rclpy.validate_full_topic_name: validate_full_topic_name!
rclpy.validate_namespace: validate_namespace!
rclpy.validate_node_name: validate_node_name!
rclpy.validate_parameter_name: validate_parameter_name!
rclpy.validate_topic_name: validate_topic_name!
rclpy.wait_for_message: wait_for_message!
rclpy.waitable: NumberOfEntities! Waitable!
"""


@pytest.mark.parametrize("line", IMPORTED.replace("\n    ", " ").splitlines())
def test_a_name_can_be_imported_or_its_error_says_who_has_it(line: str) -> None:
    module, _, words = line.partition(": ")
    for word in words.split():
        name = word.removesuffix("!")
        if name != word and chosen.ENGINE == "embedded":
            with pytest.raises(ImportError, match=rf"no {module}.*: if real ROS 2 has it"):
                exec(f"from {module} import {name}")
        else:
            exec(f"from {module} import {name}")
