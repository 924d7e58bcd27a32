"""Between scenes with their objects and mbd_msgs/Scene."""

from __future__ import annotations

import math

from geometry_msgs.msg import Point, Vector3
from mbd_msgs import msg as m

from mbd_model.errors import MbdError
from mbd_model.objects import FeatureDeviations, Relation, Role, Scene, SceneObject
from mbd_model.ros.conversions.times import header, time_from_msg

ROLE_TO_CODE = {Role.SOURCE: m.Scene.SOURCE, Role.TARGET: m.Scene.TARGET}
CODE_TO_ROLE = {code: role for role, code in ROLE_TO_CODE.items()}


def role_from_code(code: int) -> Role:
    """Role of a Scene or Observe message; raises MbdError for a number that is none."""
    if code not in CODE_TO_ROLE:
        raise MbdError(f"role {code} is neither SOURCE (1) nor TARGET (2)")
    return CODE_TO_ROLE[code]


def object_to_msg(value: SceneObject) -> m.ObjectFeatures:
    """One object; size is (x depth, y width, z height) there, a missing hue is NaN."""
    width, depth, height = value.size
    msg = m.ObjectFeatures(
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
    if (std := value.deviations) is not None:
        width, depth, height = std.size
        msg.has_std = True
        msg.centroid_std = Vector3(**dict(zip("xyz", std.centroid, strict=True)))
        msg.box_center_std = Vector3(**dict(zip("xyz", std.box_center, strict=True)))
        msg.size_std = Vector3(x=depth, y=width, z=height)
        msg.yaw_std, msg.volume_std, msg.saturation_std = std.yaw, std.volume, std.saturation
        msg.hue_std = std.hue or 0.0
    return msg


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
        deviations=_deviations_from_msg(msg) if getattr(msg, "has_std", False) else None,
    )


def _deviations_from_msg(msg: m.ObjectFeatures) -> FeatureDeviations:
    """The standard deviations of a message that has them; raises MbdError for one that is none."""
    depth, width, height = _three(msg.size_std)
    return FeatureDeviations(
        centroid=_three(msg.centroid_std),
        box_center=_three(msg.box_center_std),
        size=(width, depth, height),
        yaw=float(msg.yaw_std),
        volume=float(msg.volume_std),
        hue=float(msg.hue_std) if msg.has_hue else None,
        saturation=float(msg.saturation_std),
    )


def _three(vector: Vector3) -> tuple[float, float, float]:
    return float(vector.x), float(vector.y), float(vector.z)


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
