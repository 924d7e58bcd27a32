"""From a segmented frame to scene objects: centroid, box, colour, class, relations (paper sec. 4.1, Table 1)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from mbd_model.camera.pose import CameraPose, pose_above_plane
from mbd_model.errors import MbdError
from mbd_model.geometry.spatial import spatial_relations
from mbd_model.objects import Role, Scene, SceneObject
from numpy.typing import NDArray

from mbd_perception.arm.description import Rods
from mbd_perception.arm.recognition import arm_labels
from mbd_perception.features.box import UprightBox, upright_box
from mbd_perception.features.color import ColorConfig, object_color
from mbd_perception.features.deviations import feature_deviations
from mbd_perception.features.knowledge import KnowledgeBase
from mbd_perception.features.tracking import TrackingConfig, lasting_ids
from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.frames.units import distance_doubt, height_doubt
from mbd_perception.quantile import median, quantile
from mbd_perception.segmentation.segment import Segmentation, SegmentationConfig
from mbd_perception.segmentation.table.beside import TablesInView, tables_beside
from mbd_perception.segmentation.table.plane import NoTableError, Plane
from mbd_perception.segmenters.segmenter import Segmenter, SegmenterError
from mbd_perception.segmenters.with_table import table_segmenter

ARM_IN_VIEW = "the robot's own arm is in view, known by its joints, and left out: move it away to see what it hides"
ID_PREFIX = {Role.SOURCE: "s", Role.TARGET: "t"}


class NoObjectError(MbdError):
    """A table with nothing on it."""


@dataclass(frozen=True)
class MeasureConfig:
    """How the pixels of an object become numbers.

    Attributes:
        color: when an object has a hue.
        top: quantile of the heights of an object's points taken as its height.
        trim: share of points left out at each end of each horizontal axis.
        sample: about how many points of an object are looked at; more change nothing but the time.
    """

    color: ColorConfig = field(default_factory=ColorConfig)
    top: float = 0.98
    trim: float = 0.002
    sample: int = 1000


@dataclass(frozen=True)
class Measured:
    """One object of one frame, before it has relations.

    Attributes:
        label: its number in the label picture.
        object: its features; ``object_id`` is that number.
        box: its upright box; ``object.centroid`` is the mean of the visible points instead.
        agreement: how much the hues of its pixels agree, 0..1.
    """

    label: int
    object: SceneObject
    box: UprightBox
    agreement: float


def object_pixels(segmentation: Segmentation) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """(label, flat indices of its pixels) of each object, in label order."""
    flat = segmentation.labels.ravel()
    covered = np.flatnonzero(flat != 0)
    label = flat[covered].astype(np.uint16)  # sorted faster than what is wider
    order = covered[np.argsort(label, kind="stable")]
    ends = np.cumsum(np.bincount(label, minlength=segmentation.count + 1))
    for number in range(1, segmentation.count + 1):
        yield number, order[ends[number - 1] : ends[number]]


def measure(
    frame: RgbdFrame, segmentation: Segmentation, pose: CameraPose, knowledge: KnowledgeBase, config: MeasureConfig
) -> list[Measured]:
    """The features of every object, from left to right as the robot sees them (y falling).

    The centroid is the mean of the visible points, as in the paper; the height is that of the top above the table,
    on which every object stands.
    """
    columns, rows = frame.camera.rays()
    depth, heights = frame.depth.ravel(), segmentation.heights.ravel()
    color = frame.color
    found = []
    for label, pixels in object_pixels(segmentation):
        sample = pixels[:: max(1, len(pixels) // config.sample)]
        v, u = np.divmod(sample, frame.camera.width)
        z = depth[sample]
        points = pose.to_base(np.stack([columns[0, u] * z, rows[v, 0] * z, z], axis=1).astype(np.float64))
        box = upright_box(points[:, :2].astype(np.float32), config.trim)
        # A high quantile of noisy heights lies above the top: by 2 std for a flat lid, by less for a rim.
        bias = 1.5 * segmentation.noise * segmentation.plane.offset * median(z)
        height = max(quantile(heights[sample], config.top) - bias, 1e-3)
        size = (box.width, box.depth, height)
        look = object_color(color[v, u], config.color)
        match = knowledge.match(size, look.hue)
        x, y, height_of_mean = points.mean(axis=0)
        table = height_of_mean - float(heights[sample].mean())
        value = SceneObject(
            object_id=str(label),
            centroid=(float(x), float(y), float(height_of_mean)),
            box_center=(*box.center, float(table + height / 2)),
            size=size,
            yaw=box.yaw,
            hue=look.hue,
            saturation=look.saturation,
            color_name=look.name,
            object_class=match.name,
            class_score=match.score,
            affordances=frozenset() if match.object_class is None else match.object_class.affordances,
            properties=frozenset() if match.object_class is None else match.object_class.properties,
        )
        found.append(Measured(label, value, box, look.agreement))
    return sorted(found, key=lambda m: (-m.object.centroid[1], m.object.centroid[0]))


def with_deviations(
    frame: RgbdFrame, segmentation: Segmentation, pose: CameraPose, measured: Sequence[Measured]
) -> list[Measured]:
    """The same objects, each with the standard deviations of its features."""
    stds = feature_deviations(frame, segmentation, pose, measured)
    return [replace(m, object=replace(m.object, deviations=std)) for m, std in zip(measured, stds, strict=True)]


def related(measured: Sequence[Measured], ids: Sequence[str]) -> tuple[SceneObject, ...]:
    """The objects under their final ids, with their relations.

    Relations follow from boxes, whose centre differs from the visible centroid when a side faces away from the camera.
    """
    named = [replace(m.object, object_id=name) for m, name in zip(measured, ids, strict=True)]
    boxed = [replace(obj, centroid=(*m.box.center, obj.centroid[2])) for obj, m in zip(named, measured, strict=True)]
    return tuple(
        replace(obj, relations=relations) for obj, relations in zip(named, spatial_relations(boxed), strict=True)
    )


@dataclass(frozen=True)
class Observation:
    """Everything one look at the table gives.

    Attributes:
        scene: its objects from left to right; ids s1.. or t1..
        segmentation: where they are in the picture.
        labels: label in ``segmentation.labels`` of each object of the scene, in scene order.
        frame: the (fused) frame it came from.
        pose: the camera pose used.
        tables: which tables are in view; None when nobody looked for others.
        arm: labels in ``segmentation.labels`` of what is the robot's own arm.
        pose_known: whether the pose was given, and not worked out from the table.
    """

    scene: Scene
    segmentation: Segmentation
    labels: tuple[int, ...]
    frame: RgbdFrame
    pose: CameraPose
    tables: TablesInView | None = None
    arm: frozenset[int] = frozenset()
    pose_known: bool = False

    @property
    def table_in_base(self) -> tuple[float, float, float, float]:
        """(a, b, c, d) of the table, a x + b y + c z + d = 0 [m, base frame]."""
        plane = self.segmentation.plane
        a, b, c = (float(v) for v in self.pose.rotation @ plane.normal)
        x, y, z = self.pose.position
        return a, b, c, plane.offset - float(a * x + b * y + c * z)

    @property
    def summary(self) -> str:
        """One sentence for people."""
        objects = ", ".join(f"{o.object_id} {o.color_name} {o.object_class}" for o in self.scene.objects)
        return f"{len(self.scene.objects)} objects: {objects}" + (f" ({self.hint})" if self.hint else "")

    @property
    def hint(self) -> str:
        """What to check although objects were found; empty when nothing is odd."""
        hints = (
            height_doubt(self.segmentation.plane.offset, self.pose.position[2] if self.pose_known else None),
            "" if self.tables is None else self.tables.hint,
            ARM_IN_VIEW if self.arm else "",
        )
        return "; ".join(hint for hint in hints if hint)


@dataclass(frozen=True)
class ObserveConfig:
    """Everything perception is set to.

    Attributes:
        knowledge: classes of objects.
        segmentation: how objects are found.
        measure: how they are measured.
        tracking: when an object is the same as before.
        frame_id: name of the base frame.
        segmenter: what finds the objects; None for our own, as ``segmentation`` says.
    """

    knowledge: KnowledgeBase
    segmentation: SegmentationConfig = field(default_factory=SegmentationConfig)
    measure: MeasureConfig = field(default_factory=MeasureConfig)
    tracking: TrackingConfig = field(default_factory=TrackingConfig)
    frame_id: str = "j2n6s300_link_base"
    segmenter: Segmenter | None = None


def with_tables(observation: Observation) -> Observation:
    """The same, having looked for other tables: some milliseconds, which not every frame needs."""
    found = observation.segmentation
    return replace(observation, tables=tables_beside(observation.frame, found.plane, found.noise, observation.pose))


def observe(
    frame: RgbdFrame,
    role: Role,
    pose: CameraPose | None,
    config: ObserveConfig,
    known: Sequence[SceneObject] = (),
    *,
    last: Plane | None = None,
    arm: Rods | None = None,
) -> Observation:
    """A scene from one (fused) frame.

    Without a pose the scene is in a table frame below the camera, see ``pose_above_plane``. Objects that are among
    ``known`` keep their ids; the others are numbered from left to right. ``last``:
    the table in the last frame of the same camera, which speaks for the plane that is like it. ``arm``: the robot's
    own, in the base frame; what is found to be it is no object.

    Raises:
        NoTableError: no supporting plane in view.
        NoObjectError: nothing on the table.
        SegmenterError: a segmenter that is plugged in failed, or answered no labels.
    """
    try:
        segmentation = table_segmenter(config.segmenter, config.segmentation).find(frame, pose, last)
    except SystemExit as error:  # of somebody else's segmenter, which ends neither node nor the other frames
        raise SegmenterError(f"the segmenter wanted to end the process (SystemExit: {error})") from error
    except NoTableError as error:
        doubt = distance_doubt(frame.depth, frame.camera, pose)
        if not doubt:
            raise
        raise NoTableError(f"{error}; {doubt}") from error
    where = pose or pose_above_plane(segmentation.plane.normal, segmentation.plane.offset)
    measured = measure(frame, segmentation, where, config.knowledge, config.measure)
    own = frozenset[int]()
    if arm is not None and measured:
        own = arm_labels(frame, segmentation.labels, arm, where, known=pose is not None)
        measured = [m for m in measured if m.label not in own]
    if not measured:
        aside = (
            f"; {segmentation.left_out} thing(s) reach out of the workspace and were left out (the arm? move it away, "
            "or check the workspace limits)"
            if segmentation.left_out
            else ""
        )
        aside += f"; {ARM_IN_VIEW}" if own else ""
        hints = (
            height_doubt(segmentation.plane.offset, None if pose is None else float(pose.position[2])),
            tables_beside(frame, segmentation.plane, segmentation.noise, where).hint,
        )
        aside += "".join(f"; {hint}" for hint in hints if hint)
        raise NoObjectError(
            f"the table is in view but nothing stands on it{aside}; put the objects on it and observe again"
        )
    measured = with_deviations(frame, segmentation, where, measured)
    ids = lasting_ids(known, [m.object for m in measured], ID_PREFIX[role], config.tracking)
    scene = Scene(role=role, objects=related(measured, ids), stamp=frame.stamp, frame_id=config.frame_id)
    labels = tuple(m.label for m in measured)
    return Observation(scene, segmentation, labels, frame, where, arm=own, pose_known=pose is not None)
