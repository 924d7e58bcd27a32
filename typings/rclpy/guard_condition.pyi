from collections.abc import Callable

from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context

class GuardCondition:
    def __init__(
        self,
        callback: Callable[[], object] | None,
        callback_group: CallbackGroup | None,
        context: Context | None = None,
    ) -> None: ...
    def trigger(self) -> None: ...
    def destroy(self) -> None: ...
