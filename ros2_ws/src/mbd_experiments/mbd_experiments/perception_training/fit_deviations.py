"""``fit_deviations``: fits how exactly each feature of an object is measured, and writes the weights.

`ros2 run mbd_experiments fit_deviations [FRAME…] [--rooms N] [--apart M] [--out FILE]`

A FRAME is a labelled frame folder. Give only frames that perception may be chosen by (docs/perception.md). Rendered
rooms of every kind, each seen from two places, are learned from besides; others are kept apart, and reported on.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import wrap

import numpy as np
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import zero_or_more
from mbd_model.errors import MbdError
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_perception.features.deviations import DEVIATIONS
from mbd_perception.features.evidence_of_error import EVIDENCE

from mbd_experiments.perception_training.deviation_model import fitted_weights
from mbd_experiments.perception_training.feature_errors import FeatureError, folder_errors
from mbd_experiments.perception_training.feature_errors_command import APART, all_room_errors, coverage_table
from mbd_experiments.perception_training.feature_truth import Floats


def without_extent(error: FeatureError) -> FeatureError:
    """The same without the errors of sides and volume: the truth of a real frame does not know what is hidden."""
    hidden = np.isin(DEVIATIONS, ("long", "short", "volume"))
    return replace(error, errors=np.where(hidden, np.nan, error.errors))


def weights_module(weights: Floats) -> str:
    """The text of deviation_weights.py."""
    names = ("least", "largest", *DEVIATIONS)
    lines = [
        '"""Weights of the model in deviations.py; written by `fit_deviations`, not by hand."""',
        "",
        "import numpy as np",
        "",
        *wrap(f"A bias, then: {', '.join(EVIDENCE)}.", 100, initial_indent="# ", subsequent_indent="# "),
        "WEIGHTS = np.array(",
        "    [",
    ]
    for name, row in zip(names, weights, strict=True):
        lines.append(f"        # {name}")
        numbers = ", ".join(f"{value:.4g}" for value in row)
        lines += wrap(f"[{numbers}],", 100, initial_indent=" " * 8, subsequent_indent=" " * 9)
    return "\n".join([*lines, "    ]", ")  # fmt: skip", ""])


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; 0 when a model could be fitted, 2 for a wrong call."""
    parser = CommandParser(prog="fit_deviations", description="Fit the standard deviations of features.")
    parser.add_argument("frames", nargs="*", type=Path, metavar="FRAME", help="labelled frame folders to learn from")
    parser.add_argument("--rooms", type=int, default=14, metavar="N", help="rooms of each kind to learn from (14)")
    parser.add_argument("--apart", type=int, default=6, metavar="M", help="rooms of each kind to report on (6)")
    parser.add_argument(
        "--frame-weight", type=int, default=10, metavar="W", help="how many objects one of a frame counts for (10)"
    )
    parser.add_argument("--ridge", type=zero_or_more, default=1e-3, help="how much large weights cost (default 0.001)")
    parser.add_argument("--out", type=Path, help="file for the weights (default: print them)")
    add_executor_options(parser, "rooms")
    options = parser.parse_args(arguments)
    if not (0 <= options.rooms <= APART and options.apart >= 0 and options.frame_weight >= 1):
        parser.error(f"expected --rooms of 0 to {APART}, --apart of 0 or more, --frame-weight of 1 or more")
    try:
        real = [without_extent(error) for folder in options.frames for error in folder_errors(folder)]
        rooms = all_room_errors(executor_of(options), 0, options.rooms)
        fitted = fitted_weights(options.frame_weight * real + rooms, options.ridge)
        weights = np.array([[float(f"{v:.4g}") for v in row] for row in fitted])
        apart = all_room_errors(executor_of(options), APART, options.apart)
    except MbdError as error:
        parser.error(str(error))
    lines: list[str] = []
    for name, errors in (("frames", real), ("rooms", rooms)):
        if errors:
            lines += ["", f"learned from {len(errors)} objects of {name}:", "", *coverage_table(errors, weights)]
    if apart:
        lines += ["", f"{len(apart)} objects of rooms kept apart:", "", *coverage_table(apart, weights)]
    sys.stdout.write("\n".join(lines) + "\n")
    text = weights_module(weights)
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
