"""Where the objects of a session ended, against where the demonstration put those they stand for."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from mbd_cell.layout.scene_file import load_scenes
from mbd_cell.outcome import ObjectState, PlaceOutcome, outcomes
from mbd_cell.ros.conversions import object_states_from_truth
from mbd_cell.teacher.recognition import recognise
from mbd_model.objects import Role, Scene
from mbd_model.ros import conversions
from mbd_model.ros.qos import LATCHED
from mbd_msgs import msg as m
from rclpy.node import Node


class Ending:
    """Keeps what a session states of its objects, first and last.

    Args:
        node: whose subscriptions these are.
    """

    def __init__(self, node: Node) -> None:
        self._laid: dict[Role, tuple[tuple[str, int], dict[str, ObjectState]]] = {}
        self._left: dict[Role, dict[str, ObjectState]] = {}
        self._scenes: dict[Role, Scene] = {}
        self._mapping: dict[str, str] = {}
        node.create_subscription(m.CellTruth, "cell/truth", self._on_truth, LATCHED)
        node.create_subscription(m.MappingEstimate, "mapping/estimate", self._on_estimate, LATCHED)
        for role in Role:
            node.create_subscription(m.Scene, f"perception/{role}_scene", self._on_scene, LATCHED)

    def places(self) -> tuple[PlaceOutcome, ...]:
        """What became of each place step; () when the session did not get that far."""
        if set(self._left) != set(Role) or set(self._scenes) != set(Role):
            return ()
        names = {}
        for role in Role:
            laid = self._laid[role][1]
            names[role] = recognise(self._scenes[role], {n: s.pose.position[:2] for n, s in laid.items()})
        mapping = {
            names[Role.SOURCE][s]: names[Role.TARGET][t]
            for s, t in self._mapping.items()
            if s in names[Role.SOURCE] and t in names[Role.TARGET]
        }
        task = self._laid[Role.TARGET][0][0]
        steps = load_scenes(Path(get_package_share_directory("mbd_cell")) / "config" / f"{task}.yaml").steps
        return outcomes(steps, self._left[Role.SOURCE], self._left[Role.TARGET], mapping)

    def _on_truth(self, msg: m.CellTruth) -> None:
        role, states = conversions.role_from_code(msg.role), object_states_from_truth(msg)
        if role not in self._laid or self._laid[role][0] != (msg.task, msg.seed):
            self._laid[role] = ((msg.task, msg.seed), states)
        self._left[role] = states

    def _on_scene(self, msg: m.Scene) -> None:
        scene = conversions.scene_from_msg(msg)
        self._scenes[scene.role] = scene

    def _on_estimate(self, msg: m.MappingEstimate) -> None:
        self._mapping = conversions.estimate_from_msg(msg).executed.as_dict
