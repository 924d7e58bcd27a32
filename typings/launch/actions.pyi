from collections.abc import Callable, Sequence

from launch.launch_context import LaunchContext
from launch.launch_description_entity import LaunchDescriptionEntity

class Action(LaunchDescriptionEntity): ...

class DeclareLaunchArgument(Action):
    def __init__(self, name: str, *, default_value: str | None = None, description: str | None = None) -> None: ...

class OpaqueFunction(Action):
    def __init__(self, *, function: Callable[[LaunchContext], Sequence[LaunchDescriptionEntity] | None]) -> None: ...

class SetEnvironmentVariable(Action):
    def __init__(self, name: str, value: str) -> None: ...

class Shutdown(Action):
    def __init__(self, *, reason: str = "reason not given") -> None: ...
