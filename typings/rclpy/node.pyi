from collections.abc import Awaitable, Callable, Iterator
from typing import Any, Literal, TypeVar, overload

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.callback_groups import CallbackGroup
from rclpy.client import Client
from rclpy.clock import Clock
from rclpy.context import Context
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import Executor
from rclpy.guard_condition import GuardCondition
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from rclpy.topic_endpoint_info import TopicEndpointInfo
from ros_kinds import Service as ServiceKind

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")

class Node:
    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        start_parameter_services: bool = True,
        parameter_overrides: list[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
    ) -> None: ...
    @property
    def context(self) -> Context: ...
    @property
    def executor(self) -> Executor | None: ...
    @property
    def default_callback_group(self) -> CallbackGroup: ...
    def get_name(self) -> str: ...
    def get_namespace(self) -> str: ...
    def get_fully_qualified_name(self) -> str: ...
    def get_clock(self) -> Clock: ...
    def get_logger(self) -> RcutilsLogger: ...
    def declare_parameter(
        self,
        name: str,
        value: Any = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Parameter: ...
    def undeclare_parameter(self, name: str) -> None: ...
    def has_parameter(self, name: str) -> bool: ...
    def get_parameter(self, name: str) -> Parameter: ...
    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]: ...
    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]: ...
    def describe_parameter(self, name: str) -> ParameterDescriptor: ...
    def add_on_set_parameters_callback(self, callback: Callable[[list[Parameter]], SetParametersResult]) -> None: ...
    def add_post_set_parameters_callback(self, callback: Callable[[list[Parameter]], None]) -> None: ...
    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str: ...
    def create_publisher(
        self,
        msg_type: type[MessageT],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
    ) -> Publisher[MessageT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
    ) -> Subscription[MessageT]: ...
    @overload
    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[bytes, dict[str, int]], object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        raw: Literal[True],
    ) -> Subscription[MessageT]: ...
    def create_client(
        self,
        srv_type: type[ServiceKind[RequestT, ResponseT]],
        srv_name: str,
        *,
        qos_profile: QoSProfile = ...,
        callback_group: CallbackGroup | None = None,
    ) -> Client[RequestT, ResponseT]: ...
    def create_service(
        self,
        srv_type: type[ServiceKind[RequestT, ResponseT]],
        srv_name: str,
        callback: Callable[[RequestT, ResponseT], ResponseT | Awaitable[ResponseT]],
        *,
        qos_profile: QoSProfile = ...,
        callback_group: CallbackGroup | None = None,
    ) -> Service[RequestT, ResponseT]: ...
    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], object],
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer: ...
    def create_guard_condition(
        self, callback: Callable[[], object], callback_group: CallbackGroup | None = None
    ) -> GuardCondition: ...
    def destroy_publisher(self, publisher: Publisher[Any]) -> bool: ...
    def destroy_subscription(self, subscription: Subscription[Any]) -> bool: ...
    def destroy_client(self, client: Client[Any, Any]) -> bool: ...
    def destroy_timer(self, timer: Timer) -> bool: ...
    def destroy_node(self) -> None: ...
    @property
    def waitables(self) -> Iterator[object]: ...
    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]: ...
    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]: ...
    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[TopicEndpointInfo]: ...
    def get_subscriptions_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[TopicEndpointInfo]: ...
    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]: ...
    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]: ...
    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> list[tuple[str, list[str]]]: ...
    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> list[tuple[str, list[str]]]: ...
    def get_node_names(self) -> list[str]: ...
    def count_publishers(self, topic_name: str) -> int: ...
    def count_subscribers(self, topic_name: str) -> int: ...
