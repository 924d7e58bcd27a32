from collections.abc import Callable, Mapping, Sequence

from launch.actions import Action
from launch.events.process import ProcessExited
from launch.launch_context import LaunchContext
from launch_ros.parameter_descriptions import ParameterValue

Value = bool | int | float | str | Sequence[bool] | Sequence[int] | Sequence[float] | Sequence[str] | ParameterValue

class Node(Action):
    def __init__(
        self,
        *,
        executable: str,
        package: str | None = None,
        name: str | None = None,
        namespace: str | None = None,
        parameters: Sequence[str | Mapping[str, Value]] | None = None,
        additional_env: Mapping[str, str] | None = None,
        output: str = "log",
        respawn: bool = False,
        respawn_delay: float | None = None,
        on_exit: Action
        | Sequence[Action]
        | Callable[[ProcessExited, LaunchContext], Action | Sequence[Action] | None]
        | None = None,
        sigterm_timeout: str = "5",
        sigkill_timeout: str = "5",
    ) -> None: ...
