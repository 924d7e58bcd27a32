"""``train_rejoin``: fits the model that joins what an occluder cuts in two, and writes its weights.

`ros2 run mbd_experiments train_rejoin [FRAME…] [--rooms N] [--out FILE]`

A FRAME is a labelled frame folder (color.png, depth.png, meta.json, labels.png). Give only frames that perception may
be chosen by (docs/perception.md). Rendered rooms with as much clutter as can be are learned from besides.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import whole_number, zero_or_more
from mbd_model.errors import MbdError
from mbd_perception.segmentation.joining.rejoining import TERMS, model_row
from mbd_perception.synthetic.rooms import Kind
from numpy.typing import NDArray
from scipy.optimize import minimize

from mbd_experiments.perception_training.rejoin_pairs import PiecePair, folder_pairs, room_pairs

KINDS = (Kind.MANY, Kind.COVERED, Kind.STACKED, Kind.GREY)
Vector = NDArray[np.float64]


def fitted(rows: Vector, same: NDArray[np.bool_], ridge: float) -> Vector:
    """(k + 1,) bias and weights of a logistic model; both classes count the same.

    Args:
        rows: (n, k) what the model is given.
        same: (n,) whether the two are one.
        ridge: how much large weights cost.

    Raises:
        MbdError: pairs of one class only.
    """
    if same.all() or not same.any():
        raise MbdError(
            f"all {len(same)} pairs are {'one thing' if len(same) and same.all() else 'two things'}: "
            "give labelled frames in which something stands before a thing and cuts it in two"
        )
    weight = np.where(same, 0.5 / same.sum(), 0.5 / (~same).sum())
    sign = np.where(same, -1.0, 1.0)

    def loss(b: Vector) -> float:
        odds = rows @ b[1:] + b[0]
        return float((weight * np.logaddexp(0.0, sign * odds)).sum() + 0.1 * ridge * (b[1:] ** 2).sum())

    return np.asarray(minimize(loss, np.zeros(rows.shape[1] + 1)).x)


def held_out_odds(pairs: Sequence[PiecePair], ridge: float) -> Vector:
    """(n,) log-odds of each pair by a model that saw nothing of its scene.

    Raises:
        MbdError: what is left without a scene is of one class only.
    """
    rows = np.array([model_row(p.features) for p in pairs])
    same = np.array([p.same for p in pairs])
    scenes = np.array([p.scene for p in pairs])
    odds = np.zeros(len(pairs))
    for scene in np.unique(scenes):
        out = scenes == scene
        b = fitted(rows[~out], same[~out], ridge)
        odds[out] = rows[out] @ b[1:] + b[0]
    return odds


def weights_module(b: Vector) -> str:
    """The text of rejoin_weights.py."""
    lines = [f"{name.upper()} = {value:.2f}" for name, value in zip(("bias", *TERMS), b, strict=True)]
    return (
        '"""Weights of the model in occlusion.py; written by `train_rejoin`, not by hand."""\n\n'
        + "\n".join(lines)
        + "\n"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; 0 when a model could be fitted."""
    parser = CommandParser(prog="train_rejoin", description="Fit the model that rejoins pieces behind occluders.")
    parser.add_argument("frames", nargs="*", type=Path, metavar="FRAME", help="labelled frame folders to learn from")
    parser.add_argument(
        "--rooms", type=whole_number, default=40, metavar="N", help="rendered rooms of each kind (default 40)"
    )
    parser.add_argument("--ridge", type=zero_or_more, default=1e-3, help="how much large weights cost (default 0.001)")
    parser.add_argument("--out", type=Path, help="file for the weights (default: print them)")
    options = parser.parse_args(arguments)
    try:
        pairs = [pair for folder in options.frames for pair in folder_pairs(folder)]
        pairs += room_pairs(KINDS, options.rooms)
        rows, same = np.array([model_row(p.features) for p in pairs]), np.array([p.same for p in pairs], dtype=bool)
        weights = fitted(rows.reshape(-1, len(TERMS)), same, options.ridge)
        held_out = held_out_odds(pairs, options.ridge)
    except MbdError as error:
        parser.error(str(error))
    right = (held_out > 0) == same
    sys.stdout.write(
        f"{len(pairs)} pairs, {int(same.sum())} of them one thing; by models that saw nothing of their scene "
        f"{int(right[same].sum())} of {int(same.sum())} are joined and {int((~right[~same]).sum())} of "
        f"{int((~same).sum())} are joined wrongly\n"
    )
    text = weights_module(weights)
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
