"""Labels of any segmenter, with the table they stand on: what the features are measured from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mbd_model.camera.pose import CameraPose

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.segment import Segmentation, SegmentationConfig, segment
from mbd_perception.segmentation.table.choice import find_table
from mbd_perception.segmentation.table.noise import settled
from mbd_perception.segmentation.table.plane import NoTableError, Plane
from mbd_perception.segmenters.segmenter import Segmenter, SegmenterError, TableSegmenter, checked_labels


@dataclass(frozen=True)
class OwnSegmenter:
    """The segmenter of this package, described in docs/perception.md.

    Attributes:
        config: its thresholds.
    """

    config: SegmentationConfig

    def __call__(self, frame: RgbdFrame) -> np.ndarray:
        """Labels (height, width) of a frame; zeros where no table is in view."""
        try:
            return self.find(frame, None).labels
        except NoTableError:
            return np.zeros(frame.depth.shape, dtype=np.int32)

    def find(self, frame: RgbdFrame, pose: CameraPose | None, last: Plane | None = None) -> Segmentation:
        """Table, labels and heights; see ``TableSegmenter``."""
        return segment(frame, pose, self.config, last)


def own_segmenter() -> OwnSegmenter:
    """Our own with its default thresholds."""
    return OwnSegmenter(SegmentationConfig())


@dataclass(frozen=True)
class WithTable:
    """A segmenter that knows of no table, on the table that we find.

    Of its objects those count that stand on the table: no smaller, no lower and no farther out of the workspace than
    the configuration says. What it makes of table, floor and walls (as one that segments everything does) is so left
    out.

    Attributes:
        segmenter: from a frame to labels.
        config: how the table is found, and which objects count.
    """

    segmenter: Segmenter
    config: SegmentationConfig

    def find(self, frame: RgbdFrame, pose: CameraPose | None, last: Plane | None = None) -> Segmentation:
        """Table, labels and heights; see ``TableSegmenter``.

        Raises:
            NoTableError: no supporting plane in view.
            SegmenterError: the segmenter failed, with its own exception as the cause, or answered no labels.
        """
        config = self.config
        inside = None if pose is None else config.workspace.contains(frame.depth, frame, pose)
        near_table = frame.depth if inside is None else np.where(inside, frame.depth, np.float32(0))
        up = None if pose is None else pose.up_in_camera
        table = find_table(near_table, frame.camera, config.plane, up, last=last)
        plane, noise = settled(near_table, frame.camera, table.plane, table.noise)
        heights = plane.height(frame.depth, frame.camera)
        try:
            answer: object = self.segmenter(frame)
        except Exception as error:
            raise SegmenterError(f"the segmenter failed ({type(error).__name__}: {error})") from error
        given = np.where(frame.depth > 0, checked_labels(answer, frame), 0)
        values, numbered = np.unique(given, return_inverse=True)
        if values[0] != 0:
            values, numbered = np.concatenate([[0], values]), numbered + 1
        numbered = numbered.reshape(given.shape)
        keep = np.zeros(len(values), dtype=bool)
        left_out = 0
        for number in range(1, len(values)):
            mine = numbered == number
            z = frame.depth[mine]
            area = float((z * z).sum()) / (frame.camera.fx * frame.camera.fy)
            lowest = max(config.min_height, config.height_sigmas * noise * plane.offset * float(np.median(z)))
            if len(z) < config.min_pixels or area < config.min_area or float(np.median(heights[mine])) < lowest:
                continue
            reaching = inside is not None and float(np.mean(~inside[mine])) > config.max_outside
            left_out += reaching
            keep[number] = not reaching
        numbers = np.where(keep, np.cumsum(keep), 0).astype(np.int32)
        return Segmentation(plane, numbers[numbered], int(keep.sum()), heights, left_out, noise)


def table_segmenter(segmenter: Segmenter | None, config: SegmentationConfig) -> TableSegmenter:
    """What an observation uses: ours when ``segmenter`` is None, else that one, on our table where it finds none."""
    if segmenter is None:
        return OwnSegmenter(config)
    return segmenter if isinstance(segmenter, TableSegmenter) else WithTable(segmenter, config)
