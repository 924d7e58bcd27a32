"""What an arm's and a hand's drivers speak: the schema of a robot's profile (docs/robots/profiles.md)."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from mbd_model.errors import MbdError

from mbd_robot.profiles.guiding import GuidingProfile
from mbd_robot.profiles.moveit import MoveItProfile
from mbd_robot.profiles.safety import SafetyTopic


class ToolPoseSource(Enum):
    """Where the tool's pose comes from."""

    TOPIC = "topic"
    TF = "tf"
    JOINTS = "joints"


class ArmInterface(Enum):
    """How the arm is told to move."""

    FOLLOW_JOINT_TRAJECTORY = "follow_joint_trajectory"
    KINOVA_ARM_POSE = "kinova_arm_pose"
    MOVE_GROUP = "move_group"


class HandInterface(Enum):
    """How the hand is told to move."""

    GRIPPER_COMMAND = "gripper_command"
    PARALLEL_GRIPPER_COMMAND = "parallel_gripper_command"
    FOLLOW_JOINT_TRAJECTORY = "follow_joint_trajectory"
    KINOVA_FINGERS = "kinova_fingers"
    FRANKA_GRASP = "franka_grasp"


class GripperEvents(Enum):
    """What tells the demonstration that the hand closed and opened."""

    SPOKEN = "spoken"
    JOINT = "joint"


class Reliability(Enum):
    """Quality of service that a stream is subscribed to with."""

    RELIABLE = "reliable"
    BEST_EFFORT = "best_effort"


@dataclass(frozen=True)
class JointStates:
    """The joint states of arm and hand, over as many topics and messages as the driver likes.

    Attributes:
        topics: sensor_msgs/JointState; each may hold any of the joints in any order.
        reliability: best_effort also receives from a reliable publisher, and loses what is late.
        rate: [Hz] at which the driver publishes, to know when it is lost.
    """

    topics: tuple[str, ...]
    rate: float
    reliability: Reliability = Reliability.BEST_EFFORT

    def __post_init__(self) -> None:
        """Refuse what could never be received."""
        if not self.topics:
            raise MbdError("topics is empty; expected at least one topic of sensor_msgs/JointState")
        if not self.rate > 0.0:
            raise MbdError(f"rate is {self.rate:g}; expected hertz above 0")


@dataclass(frozen=True)
class ToolPoseProfile:
    """Where the tool is.

    Attributes:
        source: topic (geometry_msgs/PoseStamped), tf, or joints (joint states and the arm's model).
        topic: of the source topic.
        frame: child frame of the source tf.
        offset: x, y, z [m] of the suite's tool point, between the fingertips, in the frame that the source gives.
        turn: [rad] of the suite's tool about z against that frame; the hand closes along the suite's tool y.
    """

    source: ToolPoseSource
    topic: str = ""
    frame: str = ""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: float = 0.0

    def __post_init__(self) -> None:
        """Each source needs its own key."""
        if self.source is ToolPoseSource.TOPIC and not self.topic:
            raise MbdError("source is topic, and no topic is given")
        if self.source is ToolPoseSource.TF and not self.frame:
            raise MbdError("source is tf, and no frame is given")


@dataclass(frozen=True)
class ArmProfile:
    """The arm.

    Attributes:
        joints: their names, from the base on, in the order of the controller.
        model: its kinematics: a name of mbd_robot/models, the path of a URDF or MJCF, or `topic:NAME`.
        tip: link or body of the model that the tool is fixed to.
        interface: of its motions.
        action: name of the action.
        ready: joint angles [rad] with the hand down over the table, from which straight ways begin.
        max_velocity: of each joint [rad/s].
        max_acceleration: [rad/s^2]
        max_jerk: [rad/s^3]
        highest_tool: [m] the tool goes at most this high.
        look_from: tool position x, y, z [m, base frame] and turn [rad], fingers down, with the arm out of the camera's
            view.
        stop_service: kinova_msgs/Stop, called when the suite is stopped; "" for none.
        start_service: kinova_msgs/Start, called when a person has resumed.
        moveit: of the interface move_group.
    """

    joints: tuple[str, ...]
    model: str
    tip: str
    interface: ArmInterface
    action: str
    ready: tuple[float, ...]
    max_velocity: tuple[float, ...]
    max_acceleration: float = 1.5
    max_jerk: float = 8.0
    highest_tool: float = 0.40
    look_from: tuple[float, ...] = (0.15, -0.45, 0.35, 0.0)
    stop_service: str = ""
    start_service: str = ""
    moveit: MoveItProfile | None = None

    def __post_init__(self) -> None:
        """One number a joint; MoveIt has its own section; an arm that is stopped must be started again."""
        if (self.interface is ArmInterface.MOVE_GROUP) != (self.moveit is not None):
            raise MbdError("interface move_group and the section moveit belong together; expected both or neither")
        if bool(self.stop_service) != bool(self.start_service):
            raise MbdError("stop_service and start_service belong together; expected both or neither")
        if len(self.look_from) != 4:
            raise MbdError(f"look_from has {len(self.look_from)} numbers; expected x, y, z [m] and a turn [rad]")
        for name in ("ready", "max_velocity"):
            if len(getattr(self, name)) != len(self.joints):
                raise MbdError(f"{name} has {len(getattr(self, name))} numbers for {len(self.joints)} joints")
        if min(self.max_velocity, default=0.0) <= 0 or self.max_acceleration <= 0 or self.max_jerk <= 0:
            raise MbdError("velocities, acceleration and jerk must be above 0")

    @property
    def description_topic(self) -> str:
        """The topic (std_msgs/String, latched) that the model is read from; "" when it is a file."""
        return self.model.removeprefix("topic:") if self.model.startswith("topic:") else ""


@dataclass(frozen=True)
class HandProfile:
    """The hand.

    Attributes:
        joints: names among the joint states.
        open, closed: position of each of these joints [rad or m] with the hand open, and closed on nothing.
        interface: of its motions.
        action: name of the action.
        action_open: name of the action that opens, where it is another; "" where it is not.
        command_open, command_closed: what the action takes for the two, in its own unit (a 2F-85's radians, Franka's
            metres, Kinova's finger ticks).
        max_effort: [N], where the action takes one.
        holding_margin: share of the hand's way that it must stop short of closed to be holding something.
        settle: [s] after the action's end until the joints are read: some hands report a stall late.
        abort_is_stall: an aborted goal is how this hand says that it closed on something.
        widest_grasp: [m] a wider object is taken by its rim.
        events: what tells the demonstration of the hand: the operator's word, or the joint.
    """

    joints: tuple[str, ...]
    open: float
    closed: float
    interface: HandInterface
    action: str
    command_open: float
    command_closed: float
    action_open: str = ""
    max_effort: float = 40.0
    holding_margin: float = 0.04
    settle: float = 0.3
    abort_is_stall: bool = False
    widest_grasp: float = 0.08
    events: GripperEvents = GripperEvents.SPOKEN

    def __post_init__(self) -> None:
        """An open hand that equals a closed one tells nothing."""
        if self.open == self.closed or self.command_open == self.command_closed:
            raise MbdError("open and closed are equal; expected two positions, and two commands")
        if not self.joints:
            raise MbdError("joints is empty; expected at least one joint of the hand")


@dataclass(frozen=True)
class StandIn:
    """How the simulated cell plays this robot.

    Attributes:
        arm: jaco, gen3, ur5e or fr3.
        hand: jaco, 2f85 or franka.
        stall_late: [s] by which the hand reports a stall late.
        hand_topic: a joint state topic of the hand's own; "" where it shares the arm's.
        hand_rate: [Hz] of it.
    """

    arm: str
    hand: str
    stall_late: float = 0.0
    hand_topic: str = ""
    hand_rate: float = 30.0


@dataclass(frozen=True)
class RobotProfile:
    """One robot.

    Attributes:
        title: for people.
        base_frame: of tool poses, scenes and goals: x away from the robot, y to its left, z up.
        tested: on what it was run, in a sentence: a simulated stand-in, or hardware, with the date.
        packages: that its driver's interfaces need, each with how to get it.
        joint_states: where joints come from.
        tool_pose: where the tool's pose comes from.
        arm: the arm.
        hand: the hand.
        guiding: how a person guides it.
        safety: topics by which its driver says that the robot stands.
        stand_in: how the cell plays it.
    """

    title: str
    base_frame: str
    tested: str
    joint_states: JointStates
    tool_pose: ToolPoseProfile
    arm: ArmProfile
    hand: HandProfile
    guiding: GuidingProfile
    safety: tuple[SafetyTopic, ...] = ()
    stand_in: StandIn | None = None
    packages: tuple[str, ...] = field(default=())

    @property
    def needs_model(self) -> bool:
        """Whether the arm's kinematics are computed here: for the tool's pose, or to plan its motions."""
        planned = self.arm.interface is ArmInterface.FOLLOW_JOINT_TRAJECTORY
        return planned or self.tool_pose.source is ToolPoseSource.JOINTS
