"""How well a segmentation agrees with ground truth: weighted overlap, over- and under-segmentation, object count.

Weighted overlap as in Silberman et al. 2012 (WOv: each true object's best IoU, weighted by its size); over- and
under-segmentation as in Richtsfeld et al. 2012 (share of an object's pixels outside its main segment; share of foreign
pixels in an object's main segment).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Score:
    """Agreement of one label picture with the truth.

    Attributes:
        weighted_overlap: 0..1, 1 is perfect.
        over_segmentation, under_segmentation: 0..1, 0 is perfect.
        found, expected: number of segments and of true objects.
        false_objects: segments most of whose pixels lie on no true object.
    """

    weighted_overlap: float
    over_segmentation: float
    under_segmentation: float
    found: int
    expected: int
    false_objects: int

    @property
    def right_count(self) -> bool:
        """Whether as many objects were found as there are."""
        return self.found == self.expected


def score(labels: NDArray[np.integer], truth: NDArray[np.integer], valid: NDArray[np.bool_]) -> Score:
    """Compare label pictures.

    Args:
        labels: (height, width) segments, 0 = none.
        truth: (height, width) true objects, 0 = none.
        valid: (height, width) pixels that have depth; only those count.
    """
    segment = np.where(valid, labels, 0).ravel()
    real = np.where(valid, truth, 0).ravel()
    _, segment = np.unique(np.concatenate([[0], segment]), return_inverse=True)
    _, real = np.unique(np.concatenate([[0], real]), return_inverse=True)
    segment, real = segment[1:], real[1:]
    segments, objects = int(segment.max(initial=0)), int(real.max(initial=0))
    table = np.bincount(real * (segments + 1) + segment, minlength=(segments + 1) * (objects + 1))
    table = table.reshape(objects + 1, segments + 1).astype(np.float64)
    inside, total_segment, total_object = table[1:, 1:], table[:, 1:].sum(axis=0), table[1:].sum(axis=1)
    if objects == 0 or segments == 0:
        return Score(float(objects == segments), float(objects > 0), 0.0, segments, objects, segments)
    overlap = inside / np.maximum(total_object[:, None] + total_segment[None] - inside, 1)
    weight = total_object / total_object.sum()
    main = inside.argmax(axis=1)
    hit = inside[np.arange(objects), main]
    return Score(
        weighted_overlap=float(weight @ overlap.max(axis=1)),
        over_segmentation=float(1 - hit.sum() / total_object.sum()),
        under_segmentation=float((total_segment[main] - hit).sum() / total_object.sum()),
        found=segments,
        expected=objects,
        false_objects=int((table[0, 1:] > 0.5 * total_segment).sum()),
    )
