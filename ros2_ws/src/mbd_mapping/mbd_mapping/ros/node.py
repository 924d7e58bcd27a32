"""The mapping node: task, target scene and assists in, the estimate out.

The estimate is a pure function of the three latched inputs and the parameters: a node that is killed and started again
gets its inputs again and states the same.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.ros.conversions import assists_from_msg, denials_from_msg, estimate_to_msg, scene_from_msg, task_from_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import LATCHED
from mbd_model.ros.run_node import run_node
from mbd_model.task import Task
from mbd_msgs import msg as m
from rclpy.parameter import Parameter

from mbd_mapping.inference import infer
from mbd_mapping.parameters import MAPPING, mapping_config


class MappingNode(TableNode):
    """Publishes ``mapping/estimate`` after every change of an input or of the threshold."""

    def __init__(self, **options: Any) -> None:
        super().__init__(MAPPING, **options)
        self._config = mapping_config(self.values)
        self.add_post_set_parameters_callback(self._on_parameters)

        self._task: tuple[Task, Time] | None = None
        self._target: tuple[Scene, Time] | None = None
        self._assists = m.Assists()
        self._problems: dict[str, str] = {}
        self._last: m.MappingEstimate | None = None
        self._estimates = self.create_publisher(m.MappingEstimate, "mapping/estimate", LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, "diagnostics", 10)
        self.create_subscription(m.Task, "demonstration/task", self._on_task, LATCHED)
        self.create_subscription(m.Scene, "perception/target_scene", self._on_target, LATCHED)
        self.create_subscription(m.Assists, "interaction/assists", self._on_assists, LATCHED)
        self.create_timer(1.0, self._report)

    def _on_parameters(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "threshold":
                self._config = replace(self._config, threshold=parameter.value)
                self._estimate()

    def _on_task(self, msg: m.Task) -> None:
        try:
            self._task = task_from_msg(msg), msg.header.stamp
        except ValueError as error:
            self._refuse("task", error)
            return
        self._accept("task")

    def _on_target(self, msg: m.Scene) -> None:
        try:
            scene = scene_from_msg(msg)
            if scene.role != Role.TARGET:
                raise MbdError(f"the scene on perception/target_scene has role {scene.role}; it must be target")
        except ValueError as error:
            self._refuse("target scene", error)
            return
        self._target = scene, msg.header.stamp
        self._accept("target scene")

    def _on_assists(self, msg: m.Assists) -> None:
        try:
            assists_from_msg(msg)
        except ValueError as error:
            self._refuse("assists", error)
            return
        self._assists = msg
        self._accept("assists")

    def _refuse(self, what: str, error: Exception) -> None:
        self.get_logger().error(f"{what} refused, the last one stays in force: {error}")
        self._problems[what] = str(error)
        self._report()

    def _accept(self, what: str) -> None:
        self._problems.pop(what, None)
        self._estimate()

    def _estimate(self) -> None:
        if self._task is None or self._target is None:
            return
        assists, denials = assists_from_msg(self._assists), denials_from_msg(self._assists)
        estimate = infer(self._task[0], self._target[0], assists, self._config, denials)
        self._last = estimate_to_msg(
            estimate,
            session=self._assists.session,
            threshold=estimate.threshold,
            stamps=(self._task[1], self._target[1], self._assists.header.stamp),
        )
        self._estimates.publish(self._last)
        for warning in estimate.warnings:
            self.get_logger().warning(warning)
        self._report()

    def _report(self) -> None:
        """Publish on diagnostics what the node waits for, refused or was warned of."""
        missing = [
            n for n, v in (("demonstration/task", self._task), ("perception/target_scene", self._target)) if not v
        ]
        warnings = list(self._last.warnings) if self._last else []
        status = DiagnosticStatus(name="mapping: estimate", hardware_id=self._config.strategy)
        if self._problems:
            status.level, status.message = DiagnosticStatus.ERROR, "; ".join(self._problems.values())
        elif warnings:
            status.level, status.message = DiagnosticStatus.WARN, "; ".join(warnings)
        elif missing:
            status.level, status.message = DiagnosticStatus.OK, f"waiting for {' and '.join(missing)}"
        else:
            status.level, status.message = DiagnosticStatus.OK, "up to date"
        threshold = self._last.threshold if self._last else self._config.stop_at
        status.values = [KeyValue(key="threshold", value=f"{threshold:g}")]
        if self._last:
            status.values += [
                KeyValue(key="confidence", value=f"{self._last.confidence:.4f}"),
                KeyValue(key="winning", value=" ".join(self._last.winning)),
                KeyValue(key="assists", value=str(self._last.num_assists)),
                KeyValue(key="ties", value=str(self._last.ties)),
                KeyValue(key="doubted", value=self._last.doubted.source_id),
            ]
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("mapping", MappingNode)


if __name__ == "__main__":
    main()
