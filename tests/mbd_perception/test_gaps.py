"""Single missing pixels are closed, and nothing else changes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_perception.segmentation.gaps import with_gaps_closed
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.segmentation.workspace import Workspace
from mbd_perception.synthetic.rooms import Kind, random_room

NOISE = 2e-3
SLANT = 4e-3  # of inverse depth a row [1/m]


def plane(seed: int, share: float) -> tuple[np.ndarray, np.ndarray]:
    """(true depth of a slanted plane, the same with pixels missing)."""
    rng = np.random.default_rng(seed)
    depth = (1.0 / (0.8 + SLANT * np.arange(60)[:, None] + np.zeros(80))).astype(np.float32)
    return depth, np.where(rng.random(depth.shape) < share, 0, depth).astype(np.float32)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.floats(0.1, 0.35))
def test_plane(seed: int, share: float) -> None:
    """On a plane nearly all gaps are closed, half to a millimetre and each to two rows; the rest stays as it was."""
    truth, holed = plane(seed, share)
    closed = with_gaps_closed(holed, NOISE)
    seen = holed > 0
    assert np.array_equal(closed[seen], holed[seen])
    filled = (closed > 0) & ~seen
    assert filled.sum() > 0.9 * (~seen).sum()
    assert np.median(np.abs(closed - truth)[filled]) < 0.001
    # Closed from neighbours in two rounds, a gap is at most as deep as the plane is two rows away.
    assert np.abs(1.0 / closed[filled] - 1.0 / truth[filled]).max() < 2.001 * SLANT


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_silhouette(seed: int) -> None:
    """No depth is invented between a thing and what lies far behind it."""
    _, holed = plane(seed, 0.25)
    holed[:, 40:] *= 1.5
    closed = with_gaps_closed(holed, NOISE)
    near, far = holed[:, :40].max(axis=1), holed[:, 40:]
    least = np.where(far > 0, far, np.inf).min(axis=1)
    between = (closed > 1.05 * near[:, None]) & (closed < 0.95 * least[:, None])
    assert not between[closed > 0].any()


def test_complete() -> None:
    """A picture with hardly a gap is returned as it is."""
    truth, _ = plane(0, 0.0)
    assert with_gaps_closed(truth, NOISE) is truth


def test_workspace() -> None:
    """Where the camera stands known and a quarter of the pixels missing, things in the workspace are still found."""
    room = random_room(Kind.HOLES, np.random.default_rng(5))
    config = SegmentationConfig(workspace=Workspace((0.25, 1.3), (-0.7, 0.7), (-0.05, 0.5)))
    found = segment(room.view.frame, room.view.pose, config)
    assert found.count == len(np.unique(room.truth)) - 1
    assert found.left_out == 0
