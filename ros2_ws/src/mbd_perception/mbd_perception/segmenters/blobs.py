"""An example of a segmenter: blobs of what rises above the table. Simple, and a baseline to compare with.

`segment FRAME… --segmenter mbd_perception.segmenters.blobs:blob_segmenter`
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.table.choice import find_table
from mbd_perception.segmentation.table.plane import NoTableError, PlaneConfig


@dataclass(frozen=True)
class BlobSegmenter:
    """Connected components of the pixels above the table, those that touch parted at their waist.

    Attributes:
        plane: how the table is found.
        height: least height above the table [m].
        step: depth may change by this share of itself from pixel to pixel on one object.
        waist: what is nearer to a blob's edge than this share of its innermost pixel joins nothing.
        smallest: least pixels of an object.
    """

    plane: PlaneConfig = field(default_factory=PlaneConfig)
    height: float = 0.012
    step: float = 0.03
    waist: float = 0.4
    smallest: int = 100

    def __call__(self, frame: RgbdFrame) -> NDArray[np.int32]:
        """Labels (height, width): 0 = background, other numbers = objects; zeros where no table is in view."""
        depth = frame.depth
        try:
            table = find_table(depth, frame.camera, self.plane)
        except NoTableError:
            return np.zeros(depth.shape, dtype=np.int32)
        above = (table.plane.height(depth, frame.camera) > self.height) & (depth > 0)
        square = np.ones((3, 3), dtype=np.uint8)
        smooth = cv2.dilate(depth, square) - cv2.erode(depth, square) < self.step * depth
        blob = (above & smooth).astype(np.uint8)
        inside = cv2.distanceTransform(blob, cv2.DIST_L2, 5)
        count, blobs = cv2.connectedComponents(blob, connectivity=4, ltype=cv2.CV_32S)
        innermost = np.zeros(count, dtype=np.float32)
        np.maximum.at(innermost, blobs.ravel(), inside.ravel())
        middle = (inside >= self.waist * innermost[blobs]) & (blob > 0)
        # Every other pixel belongs to the nearest middle.
        _, nearest = cv2.distanceTransformWithLabels((~middle).astype(np.uint8), cv2.DIST_L2, 5)
        labels: NDArray[np.int32] = np.asarray(nearest, dtype=np.int32) * above
        large = np.bincount(labels.ravel()) >= self.smallest
        return labels * large[labels]


def blob_segmenter() -> BlobSegmenter:
    """The factory."""
    return BlobSegmenter()
