"""The robot's own arm, where its joints are known, is no object, whether the camera's pose is known or not."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_cell.arm.kinematics import HOME, ArmKinematics, DownwardToolPose
from mbd_cell.layout.placement import Placement
from mbd_cell.layout.scenes import ObjectSpec, Shape
from mbd_cell.physics.camera import FOVY, INTRINSICS, Camera
from mbd_cell.physics.cell_model import build_model
from mbd_cell.physics.simulation import Simulation
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from mbd_model.objects import Role
from mbd_model.ros.qos import LATCHED, SENSOR
from mbd_perception.arm.description import DescriptionError, Rods, parse_description
from mbd_perception.arm.recognition import arm_labels
from mbd_perception.features.knowledge import load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.frame import RgbdFrame, make_frame
from mbd_perception.ros.node import PerceptionNode
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.synthetic.render import looking_at
from mbd_perception.synthetic.rooms import Kind, random_room
from mbd_robot.model_files import MODELS
from mbd_robot.profiles.find import robot_names, robot_profile
from perception_rig import Rig, image
from rclpy.context import Context
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, JointState
from std_msgs.msg import String

CONFIG = Path(__file__).parents[2] / "ros2_ws/src/mbd_perception/config"
URDF = CONFIG / "j2n6s300.urdf"
JACO = parse_description(URDF.read_text(encoding="utf-8"))
NAMES = [f"j2n6s300_joint_{i}" for i in range(1, 7)]
CAMERAS = {
    "above": looking_at((0.58, 0.0, 1.1), (0.58, 0.0, 0.0)),
    "in front": looking_at((1.5, 0.1, 0.75), (0.5, 0.0, 0.1)),
    "beside": looking_at((0.5, 1.0, 0.8), (0.5, 0.0, 0.05)),
}
THINGS = [
    ObjectSpec("cup", Shape.CUP, (0.08, 0.08, 0.1), 10.0, 0.1),
    ObjectSpec("box", Shape.BOX, (0.08, 0.1, 0.12), 200.0, 0.1),
]
PLACES = [Placement("cup", 0.6, 0.25, 0.0), Placement("box", 0.7, -0.3, 0.4)]
TWO_LINKS = """<robot name="two">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="hand"><visual><origin xyz="0 0 0.1"/>
  <geometry><sphere radius="0.03"/></geometry></visual></link>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.5"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="c" type="fixed"><parent link="lower"/><child link="hand"/><origin xyz="0 0 0.3"/></joint>
</robot>"""


@cache
def cell(view: str) -> tuple[RgbdFrame, CameraPose, dict[str, float]]:
    """The simulated cell with the hand 12 cm above the table: frame, the camera's pose, joints."""
    pose = CAMERAS[view]
    model = build_model(THINGS, PLACES, pose, FOVY)
    joints = ArmKinematics(model).solve(DownwardToolPose(0.55, 0.0, 0.12, 0.3), np.array(HOME), iterations=400)
    simulation = Simulation(model, THINGS, joints, np.full(3, 0.5))
    with Camera(model) as camera:
        picture = camera.render(simulation, np.random.default_rng(0))
    frame = make_frame(picture.color, picture.depth_mm, INTRINSICS)
    return frame, pose, dict(zip(NAMES, joints.tolist(), strict=True))


def rods(joints: dict[str, float]) -> Rods:
    """Where the Jaco is."""
    return JACO.rods(joints, "j2n6s300_link_base")


def test_forward_kinematics() -> None:
    """A right angle at either joint puts the links where they are expected."""
    arm = parse_description(TWO_LINKS)
    stretched = arm.rods({"a": 0.0, "b": 0.0}, "base").ends
    np.testing.assert_allclose(stretched[0], [[0, 0, 0.2], [0, 0, 0.7]], atol=1e-9)
    bent = arm.rods({"a": math.pi / 2, "b": -math.pi / 2}, "base").ends
    np.testing.assert_allclose(bent[0], [[0, 0, 0.2], [0.5, 0, 0.2]], atol=1e-9)
    np.testing.assert_allclose(bent[1], [[0.5, 0, 0.2], [0.5, 0, 0.5]], atol=1e-9)
    np.testing.assert_allclose(bent[2][0], [0.5, 0, 0.6], atol=1e-9)


def test_needed() -> None:
    """Of an arm's joints all but its last must be known; fingers need not."""
    assert JACO.needed == set(NAMES[:-1])


@pytest.mark.parametrize(
    "text",
    ["", "no xml", "<robot/>", '<robot name="x"><link name="one"/></robot>', TWO_LINKS.replace("0 0 0.5", "0 0 nan"),
     TWO_LINKS.replace('<parent link="base"/>', ""), TWO_LINKS.replace("revolute", "fixed")],
)  # fmt: skip
def test_no_arm(text: str) -> None:
    """What describes no arm is refused in words."""
    with pytest.raises(DescriptionError, match="robot description"):
        parse_description(text)


def test_distance() -> None:
    """The distance from a rod is that from its surface."""
    rod = Rods(np.array([[[0.0, 0, 0], [0, 0, 1]]]), np.array([0.1]))
    points = np.array([[0.3, 0, 0.5], [0, 0, 1.4], [0, 0.05, 0.2]])
    np.testing.assert_allclose(rod.distance(points), [0.2, 0.3, -0.05])


@pytest.mark.parametrize("view", CAMERAS)
@pytest.mark.parametrize("known", [True, False])
def test_arm_is_no_object(view: str, known: bool) -> None:
    """With the arm over the table, cup and box are the objects, and the arm is told, the camera's pose known or not."""
    frame, pose, joints = cell(view)
    config = ObserveConfig(knowledge=load_knowledge(CONFIG / "knowledge.yaml"))
    observation = observe(frame, Role.SOURCE, pose if known else None, config, arm=rods(joints))
    assert "robot's own arm is in view" in observation.summary
    heights = sorted(o.size[2] for o in observation.scene.objects)
    assert heights == pytest.approx([0.1, 0.12], abs=0.012)


@pytest.mark.parametrize("kind", [Kind.PLAIN, Kind.MANY, Kind.STACKED])
def test_no_arm_in_view(kind: Kind) -> None:
    """Where no arm is in view, nothing is taken for it, wherever it might be."""
    room = random_room(kind, np.random.default_rng(500))
    found = segment(room.view.frame, None, SegmentationConfig())
    arm = rods(dict(zip(NAMES, HOME, strict=True)))
    for known in (False, True):
        assert arm_labels(room.view.frame, found.labels, arm, room.view.pose, known=known) == frozenset()


@pytest.mark.parametrize("described", ["by file", "by topic"])
def test_node(rig: Callable[..., Rig], described: str) -> None:
    """The node tells the arm by its description and its joints, which come from more than one publisher."""
    frame, _, joints = cell("in front")
    k = [INTRINSICS.fx, 0.0, INTRINSICS.cx, 0.0, INTRINSICS.fy, INTRINSICS.cy, 0.0, 0.0, 1.0]
    messages = {
        "info": CameraInfo(width=640, height=480, k=k),
        "color": image(frame.color, "rgb8"),
        "depth": image(np.rint(frame.depth * 1000).astype(np.uint16), "16UC1"),
    }
    path = str(URDF) if described == "by file" else ""
    table = rig(lambda: messages, camera_pose="table", arm_description=path, joint_state="joint_states", frames=1)
    first = table.observe()
    assert "arm" not in first.message  # nothing is known of it yet
    assert len(first.scene.objects) > 2
    if described == "by topic":
        publisher = table.camera.create_publisher(String, "robot_description", LATCHED)
        publisher.publish(String(data="no description"))
        publisher.publish(String(data=URDF.read_text(encoding="utf-8")))
    states = table.camera.create_publisher(JointState, "joint_states", SENSOR)

    def shoot() -> dict[str, object]:
        names = list(joints)
        for part in (names[:3], names[3:]):
            states.publish(JointState(name=part, position=[joints[n] for n in part]))
        states.publish(JointState(name=["finger"], position=[math.nan]))
        return messages

    table.camera.messages = shoot
    answer = table.observe()
    for _ in range(10):  # until joints and description have come
        if "arm is in view" in answer.message:
            break
        answer = table.observe()
    assert "robot's own arm is in view" in answer.message
    assert len(answer.scene.objects) == 2


def test_no_description(context: Context, tmp_path: Path) -> None:
    """A file that describes no arm keeps the node from starting, and is named."""
    path = tmp_path / "arm.urdf"
    path.write_text("<robot/>", encoding="utf-8")
    with pytest.raises(MbdError, match=r"arm\.urdf.*no joint"):
        PerceptionNode(context=context, parameter_overrides=[Parameter("arm_description", value=str(path))])


@pytest.mark.parametrize("name", robot_names())
@given(seed=st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_the_model_of_every_robot_puts_its_links_where_mujoco_puts_them(name: str, seed: int):
    profile = robot_profile(name)
    file = MODELS / f"{profile.arm.model}.xml"
    arm = parse_description(file.read_text(encoding="utf-8"))
    assert arm.needed <= set(profile.arm.joints) <= arm.movable
    angles = np.random.default_rng(seed).uniform(-3.0, 3.0, len(profile.arm.joints))
    rods = arm.rods(dict(zip(profile.arm.joints, angles, strict=True)), profile.base_frame)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    for joint, angle in zip(profile.arm.joints, angles, strict=True):
        data.qpos[model.joint(joint).qposadr[0]] = angle
    mujoco.mj_kinematics(model, data)
    # Every capsule's middle lies on a rod's axis.
    axes = Rods(rods.ends, np.zeros(len(rods.radii)))
    assert axes.distance(data.geom_xpos) == pytest.approx(np.zeros(model.ngeom), abs=1e-6)
