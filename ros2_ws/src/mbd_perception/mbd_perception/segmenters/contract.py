"""What every segmenter must hold, to be run on one's own: in a test, or by the command ``check_segmenter``."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from mbd_model.camera.intrinsics import Intrinsics

from mbd_perception.frames.frame import RgbdFrame, make_frame
from mbd_perception.segmenters.segmenter import Segmenter, SegmenterError, checked_labels
from mbd_perception.synthetic.render import Box, Cylinder, SyntheticView, looking_at, render

_ODD_SIZE = Intrinsics(fx=263.0, fy=263.0, cx=160.0, cy=121.0, width=321, height=243)
_POSE = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
_SOLIDS = (
    Box((0.6, 0.22, 0.0), (0.08, 0.08, 0.10), (200, 40, 40), 0.3),
    Cylinder((0.7, -0.05, 0.0), 0.04, 0.10, (40, 40, 200)),
    Box((0.55, -0.3, 0.0), (0.10, 0.07, 0.06), (40, 160, 60)),
)


class ContractError(SegmenterError):
    """A segmenter that breaks the contract; the text states every sentence that does not hold."""


def contract_frames() -> dict[str, RgbdFrame]:
    """Frames that a segmenter must answer, by what is special about them."""
    view = _view()
    frame = view.frame
    nan = np.where(np.random.default_rng(1).random(frame.depth.shape) < 0.3, np.nan, frame.depth).astype(np.float32)
    half = frame.depth.copy()
    half[:, : half.shape[1] // 2] = 0
    dark, depth = np.zeros_like(frame.color), frame.depth
    return {
        "three things on a table": frame,
        "321 x 243 pixels": _view(_ODD_SIZE).frame,
        "three in ten pixels NaN": make_frame(frame.color, nan, frame.camera),
        "half without depth": make_frame(frame.color, half, frame.camera),
        "no colour": make_frame(dark, depth, frame.camera),
        "an empty frame": RgbdFrame(dark, np.zeros_like(depth), frame.camera),
    }


def broken_promises(segmenter: Segmenter) -> Iterator[str]:
    """A sentence for each promise that the segmenter breaks; nothing when it keeps them all."""
    for name, frame in contract_frames().items():
        color, depth = frame.color.copy(), frame.depth.copy()
        try:
            labels = checked_labels(segmenter(frame), frame).copy()
            again = segmenter(RgbdFrame(color.copy(), depth.copy(), frame.camera, frame.stamp))
        except (Exception, SystemExit) as error:
            yield f"{name}: {type(error).__name__}: {error}"
            continue
        if not np.array_equal(labels, again):
            yield f"{name}: the same frame gave other labels the second time: seed what is random"
        if not (np.array_equal(color, frame.color) and np.array_equal(depth, frame.depth)):
            yield f"{name}: the frame was changed: work on a copy"
        if name == "an empty frame" and labels.any():
            yield f"{name}: {len(np.unique(labels[labels > 0]))} objects where there is no depth at all"
    yield from _sees(segmenter)


def _sees(segmenter: Segmenter) -> Iterator[str]:
    """Whether the table is background, and things are not, in the easiest frame there is."""
    view = _view()
    try:
        labels = checked_labels(segmenter(view.frame), view.frame)
    except (Exception, SystemExit):
        return  # stated already
    # Counted by rank: a label may be any positive number, of 64 bits even.
    labels = np.searchsorted(np.unique(np.append(labels, labels.dtype.type(0))), labels)
    table = labels[view.labels == 1]
    if np.mean(table == 0) < 0.9:
        yield f"three things on a table: {np.mean(table > 0):.0%} of the table is no background (0)"
    for number in range(2, 2 + len(_SOLIDS)):
        found = np.bincount(labels[view.labels == number])
        if found.argmax() == 0 or found.max() < 0.5 * found.sum():
            yield f"three things on a table: thing {number - 1}, which stands apart, is not one object"


def check_segmenter(factory: Callable[[], Segmenter]) -> None:
    """Pass when the segmenter that ``factory`` makes keeps every promise; raises ContractError stating the others."""
    if broken := tuple(broken_promises(factory())):
        raise ContractError("; ".join(broken))


def _view(camera: Intrinsics | None = None) -> SyntheticView:
    """Three things that stand apart."""
    rng = np.random.default_rng(0)
    return render(_SOLIDS, _POSE, rng) if camera is None else render(_SOLIDS, _POSE, rng, camera=camera)
