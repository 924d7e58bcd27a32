"""What a segmenter is: a frame in, labels out. And how one is named: ``package.module:factory``."""

from __future__ import annotations

import importlib
from typing import Any, Protocol, runtime_checkable

import numpy as np
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from numpy.typing import NDArray

from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.segmentation.segment import Segmentation
from mbd_perception.segmentation.table.plane import Plane

# Names our own, which finds the table as well and uses the node's thresholds.
OWN = "own"


class SegmenterError(MbdError):
    """A segmenter that cannot be loaded, that failed on a frame, or whose answer is no label picture."""


class Segmenter(Protocol):
    """All that a research group has to write."""

    def __call__(self, frame: RgbdFrame) -> NDArray[np.integer[Any]]:
        """Which object each pixel belongs to.

        Args:
            frame: (height, width, 3) uint8 RGB and (height, width) float32 depth [m], 0 = none. Not to be changed.

        Returns:
            (height, width) integers: 0 = background (table, wall, arm), any other positive number = one object. The
            same frame gives the same labels; a frame in which nothing is seen gives zeros.
        """
        ...


@runtime_checkable
class TableSegmenter(Protocol):
    """A segmenter that finds the table as well, and may use what is known beside the frame."""

    def find(self, frame: RgbdFrame, pose: CameraPose | None, last: Plane | None = None) -> Segmentation:
        """Table, labels and heights.

        Args:
            frame: what the camera saw.
            pose: camera2base; None when not known.
            last: the table in the last frame of the same camera; None when there is none.

        Raises:
            NoTableError: no supporting plane in view.
        """
        ...


def load_segmenter(name: str) -> Segmenter:
    """The segmenter that a factory makes.

    Args:
        name: ``package.module:factory``; the factory is called without arguments.

    Raises:
        SegmenterError: no such module or factory, a factory that fails, or one that makes nothing that can be called.
    """
    expected = "expected package.module:factory, where factory() makes a callable from a frame to labels"
    module_name, colon, factory_name = name.partition(":")
    if not (module_name and colon and factory_name):
        raise SegmenterError(f"segmenter '{name}' is no name of a segmenter: {expected}, or '{OWN}'")
    try:
        module = importlib.import_module(module_name)
    except (Exception, SystemExit) as error:  # a module of somebody else may raise anything while it loads
        raise SegmenterError(
            f"segmenter '{name}': module {module_name} cannot be imported ({type(error).__name__}: {error}); "
            "check its name, and that its folder is on PYTHONPATH"
        ) from error
    factory = getattr(module, factory_name, None)
    if not callable(factory):
        known = sorted(key for key, value in vars(module).items() if callable(value) and not key.startswith("_"))
        raise SegmenterError(
            f"segmenter '{name}': {module_name} has no function {factory_name}; it has {', '.join(known) or 'none'}"
        )
    try:
        made = factory()
    except (Exception, SystemExit) as error:
        raise SegmenterError(f"segmenter '{name}': its factory failed ({type(error).__name__}: {error})") from error
    if not callable(made):
        raise SegmenterError(f"segmenter '{name}': its factory made a {type(made).__name__}; {expected}")
    return made  # type: ignore[no-any-return]  # only what it answers shows what it is, see ``checked_labels``


def checked_labels(answer: object, frame: RgbdFrame) -> NDArray[np.integer[Any]]:
    """The answer to a frame as a label picture; raises SegmenterError when it is none."""
    shape = frame.depth.shape
    if not isinstance(answer, np.ndarray):
        raise SegmenterError(f"the segmenter answered a {type(answer).__name__}: expected a {shape} array of integers")
    if answer.shape != shape:
        raise SegmenterError(f"the segmenter answered labels of shape {answer.shape}: expected {shape}, as the frame")
    if not np.issubdtype(answer.dtype, np.integer):
        raise SegmenterError(f"the segmenter answered labels of type {answer.dtype}: expected integers, 0 = background")
    if answer.size and answer.min() < 0:
        raise SegmenterError(f"the segmenter answered the label {answer.min()}: expected 0 = background, else above 0")
    return answer
