"""Between the frozen values of this package and mbd_msgs, both ways.

``..._from_msg`` only reads attributes, so it takes messages of rclpy and messages decoded by rosbags alike.
``..._to_msg`` makes rclpy messages. Times are float seconds here and builtin_interfaces/Time there; a float
holds simulated time to 1 ns and today's wall-clock time to 0.24 us, so stamps that identify an input stay Times.
"""

from __future__ import annotations

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from mbd_msgs import msg as m
from std_msgs.msg import Header

from mbd_model.assists import Assist, AssistKind
from mbd_model.errors import MbdError
from mbd_model.estimate import Feature, Mapping, MappingEstimate
from mbd_model.objects import Relation, Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep

ROLE_TO_CODE = {Role.SOURCE: m.Scene.SOURCE, Role.TARGET: m.Scene.TARGET}
CODE_TO_ROLE = {code: role for role, code in ROLE_TO_CODE.items()}


def time_to_msg(seconds: float) -> Time:
    """Seconds since the epoch (or start of simulation) as a Time."""
    nanoseconds = round(seconds * 1e9)
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def time_from_msg(stamp: Time) -> float:
    """A Time as float seconds."""
    return (int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)) / 1e9


def header(stamp: float, frame_id: str = "") -> Header:
    """A header of that time [s] and frame."""
    return Header(stamp=time_to_msg(stamp), frame_id=frame_id)


def role_from_code(code: int) -> Role:
    """Role of a Scene or Observe message; raises MbdError for a number that is none."""
    if code not in CODE_TO_ROLE:
        raise MbdError(f"role {code} is neither SOURCE (1) nor TARGET (2)")
    return CODE_TO_ROLE[code]


def object_to_msg(value: SceneObject) -> m.ObjectFeatures:
    """One object; size is (x depth, y width, z height) there, a missing hue is NaN."""
    width, depth, height = value.size
    return m.ObjectFeatures(
        id=value.object_id,
        centroid=Point(x=value.centroid[0], y=value.centroid[1], z=value.centroid[2]),
        has_box_center=value.box_center is not None,
        box_center=Point(**dict(zip("xyz", value.box_center or (0.0, 0.0, 0.0), strict=True))),
        size=Vector3(x=depth, y=width, z=height),
        yaw=value.yaw,
        volume=value.volume,
        has_hue=value.hue is not None,
        hue=math.nan if value.hue is None else value.hue,
        saturation=value.saturation,
        color_name=value.color_name,
        object_class=value.object_class,
        class_score=value.class_score,
        affordances=sorted(value.affordances),
        properties=sorted(value.properties),
        relations=[m.SpatialRelation(kind=int(kind), other_id=other) for kind, other in value.relations],
    )


def object_from_msg(msg: m.ObjectFeatures) -> SceneObject:
    """One object; raises MbdError for values that are out of range."""
    return SceneObject(
        object_id=msg.id,
        centroid=(float(msg.centroid.x), float(msg.centroid.y), float(msg.centroid.z)),
        size=(float(msg.size.y), float(msg.size.x), float(msg.size.z)),
        yaw=float(msg.yaw),
        hue=float(msg.hue) if msg.has_hue else None,
        saturation=float(msg.saturation),
        color_name=msg.color_name,
        object_class=msg.object_class,
        class_score=float(msg.class_score),
        affordances=frozenset(msg.affordances),
        properties=frozenset(msg.properties),
        relations=tuple((Relation(r.kind), r.other_id) for r in msg.relations),
        volume=float(msg.volume),
        # Bags of before this field have none.
        box_center=(float(msg.box_center.x), float(msg.box_center.y), float(msg.box_center.z))
        if getattr(msg, "has_box_center", False)
        else None,
    )


def scene_to_msg(value: Scene, table_plane: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)) -> m.Scene:
    """A scene, with the table's plane (a, b, c, d) [m] in the same frame when known."""
    return m.Scene(
        header=header(value.stamp, value.frame_id),
        role=ROLE_TO_CODE[value.role],
        objects=[object_to_msg(o) for o in value.objects],
        table_plane=list(table_plane),
    )


def scene_from_msg(msg: m.Scene) -> Scene:
    """A scene; raises MbdError for a role, an id or a value that cannot be."""
    return Scene(
        role=role_from_code(msg.role),
        objects=tuple(object_from_msg(o) for o in msg.objects),
        stamp=time_from_msg(msg.header.stamp),
        frame_id=msg.header.frame_id,
    )


def step_to_msg(value: TaskStep) -> m.TaskStep:
    """One step of a task."""
    px, py, pz = value.tool_position
    qx, qy, qz, qw = value.tool_quaternion
    return m.TaskStep(
        index=value.index,
        kind=int(value.kind),
        primary_object=value.primary_object,
        distance=value.distance,
        runner_up=value.runner_up,
        runner_up_distance=value.runner_up_distance,
        start=time_to_msg(value.start),
        end=time_to_msg(value.end),
        tool_pose=Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw)),
        offset=Vector3(x=value.offset[0], y=value.offset[1], z=value.offset[2]),
    )


def step_from_msg(msg: m.TaskStep) -> TaskStep:
    """One step of a task."""
    position, orientation = msg.tool_pose.position, msg.tool_pose.orientation
    return TaskStep(
        index=int(msg.index),
        kind=StepKind(msg.kind),
        primary_object=msg.primary_object,
        distance=float(msg.distance),
        runner_up=msg.runner_up,
        runner_up_distance=float(msg.runner_up_distance),
        start=time_from_msg(msg.start),
        end=time_from_msg(msg.end),
        tool_position=(float(position.x), float(position.y), float(position.z)),
        tool_quaternion=(float(orientation.x), float(orientation.y), float(orientation.z), float(orientation.w)),
        offset=(float(msg.offset.x), float(msg.offset.y), float(msg.offset.z)),
    )


def task_to_msg(value: Task) -> m.Task:
    """A demonstrated task."""
    return m.Task(
        header=header(value.stamp, value.source.frame_id),
        source=scene_to_msg(value.source),
        steps=[step_to_msg(s) for s in value.steps],
        problems=list(value.problems),
    )


def task_from_msg(msg: m.Task) -> Task:
    """A demonstrated task; raises MbdError when a step names an object its source scene lacks."""
    return Task(
        source=scene_from_msg(msg.source),
        steps=tuple(step_from_msg(s) for s in msg.steps),
        problems=tuple(msg.problems),
        stamp=time_from_msg(msg.header.stamp),
    )


def assist_to_msg(value: Assist) -> m.Assist:
    """One assist."""
    return m.Assist(
        source_id=value.source_id,
        target_id=value.target_id,
        step_index=value.step_index,
        kind=int(value.kind),
        stamp=time_to_msg(value.stamp),
    )


def assist_from_msg(msg: m.Assist) -> Assist:
    """One assist."""
    return Assist(
        source_id=msg.source_id,
        target_id=msg.target_id,
        step_index=int(msg.step_index),
        kind=AssistKind(msg.kind),
        stamp=time_from_msg(msg.stamp),
    )


def assists_to_msg(values: tuple[Assist, ...], stamp: float, session: str) -> m.Assists:
    """The whole list of assists in force, published at ``stamp`` [s]."""
    return m.Assists(header=header(stamp), session=session, assists=[assist_to_msg(a) for a in values])


def assists_from_msg(msg: m.Assists) -> tuple[Assist, ...]:
    """The whole list of assists in force, oldest first."""
    return tuple(assist_from_msg(a) for a in msg.assists)


def mapping_to_msg(value: Mapping) -> m.Mapping:
    """One mapping."""
    return m.Mapping(
        pairs=[m.Correspondence(source_id=source, target_id=target) for source, target in value.pairs],
        score=value.score,
    )


def mapping_from_msg(msg: m.Mapping) -> Mapping:
    """One mapping."""
    return Mapping(pairs=tuple((p.source_id, p.target_id) for p in msg.pairs), score=float(msg.score))


def estimate_to_msg(
    value: MappingEstimate, *, session: str, threshold: float, stamps: tuple[Time, Time, Time]
) -> m.MappingEstimate:
    """An estimate with the stamps (task, target scene, assists) of the inputs it came from.

    Its own stamp is the latest of those, never the wall clock: the output is a pure function of the inputs.
    """
    return m.MappingEstimate(
        header=Header(stamp=max(stamps, key=lambda t: (t.sec, t.nanosec))),
        session=session,
        strategy=value.strategy,
        mapping=mapping_to_msg(value.mapping),
        confidence=value.confidence,
        threshold=threshold,
        confident=bool(value.mapping.pairs) and value.confidence >= threshold,
        winning=[str(f) for f in value.winning],
        runner_up=[str(f) for f in value.runner_up],
        alternatives=[mapping_to_msg(a) for a in value.alternatives],
        ties=value.ties,
        num_assists=value.num_assists,
        warnings=list(value.warnings),
        next_question=value.next_question,
        information_gain=value.information_gain,
        task_stamp=stamps[0],
        scene_stamp=stamps[1],
        assists_stamp=stamps[2],
    )


def estimate_from_msg(msg: m.MappingEstimate) -> MappingEstimate:
    """An estimate, without its stamps and threshold."""
    return MappingEstimate(
        strategy=msg.strategy,
        mapping=mapping_from_msg(msg.mapping),
        confidence=float(msg.confidence),
        winning=tuple(Feature(f) for f in msg.winning),
        runner_up=tuple(Feature(f) for f in msg.runner_up),
        alternatives=tuple(mapping_from_msg(a) for a in msg.alternatives),
        ties=int(msg.ties),
        num_assists=int(msg.num_assists),
        warnings=tuple(msg.warnings),
        next_question=msg.next_question,
        information_gain=float(msg.information_gain),
    )


def prompt_to_msg(value: Prompt, stamp: float) -> m.Prompt:
    """What the robot says at ``stamp`` [s]."""
    return m.Prompt(
        header=header(stamp),
        kind=int(value.kind),
        text=value.text,
        step_index=value.step_index,
        source_id=value.source_id,
    )


def prompt_from_msg(msg: m.Prompt) -> Prompt:
    """What the robot says."""
    return Prompt(kind=PromptKind(msg.kind), text=msg.text, step_index=int(msg.step_index), source_id=msg.source_id)


def state_to_msg(value: SessionState, stamp: float) -> m.SessionState:
    """Where the session is at ``stamp`` [s]."""
    return m.SessionState(
        header=header(stamp),
        session=value.session,
        phase=int(value.phase),
        paused=value.paused,
        step_index=value.step_index,
        assists=[assist_to_msg(a) for a in value.assists],
        num_events=value.num_events,
        detail=value.detail,
    )


def state_from_msg(msg: m.SessionState) -> SessionState:
    """Where the session is."""
    return SessionState(
        session=msg.session,
        phase=Phase(msg.phase),
        paused=bool(msg.paused),
        step_index=int(msg.step_index),
        assists=tuple(assist_from_msg(a) for a in msg.assists),
        num_events=int(msg.num_events),
        detail=msg.detail,
    )
