"""``feature_errors``: how exactly features are measured, set by set, and whether what is stated of it holds.

`ros2 run mbd_experiments feature_errors [--set NAME FRAME…]… [--rooms N]`

A FRAME is a labelled frame folder (color.png, depth.png, meta.json, labels.png). Rendered rooms are others than those
that `fit_deviations` learns from.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from mbd_model.parallel.executor import Executor
from mbd_model.parallel.options import add_executor_options, executor_of
from mbd_perception.features.deviation_weights import WEIGHTS
from mbd_perception.features.deviations import DEVIATIONS
from mbd_perception.synthetic.rooms import Kind

from mbd_experiments.perception_training.deviation_model import coverage
from mbd_experiments.perception_training.feature_errors import FeatureError, folder_errors, room_errors
from mbd_experiments.perception_training.feature_truth import Floats

# Rooms with numbers from here on are not learned from.
APART = 1000
VIEWS = 2
# Unit, factor to it and digits in which a deviation is printed.
SHOWN = dict.fromkeys(DEVIATIONS, ("mm", 1e3, 1)) | {
    "yaw": ("deg", 180 / np.pi, 1),
    "volume": ("%", 1e2, 0),
    "hue": ("deg", 1.0, 1),
    "saturation": ("%", 1e2, 1),
}


def all_room_errors(executor: Executor, first: int, rooms: int) -> list[FeatureError]:
    """The objects of ``rooms`` rooms of every kind, numbered from ``first``, each room seen from two places."""
    places = [(kind, number) for number in range(first, first + rooms) for kind in Kind]
    return [error for found in executor.run_all(_of_room, places, _name) for error in found]


def _of_room(place: tuple[Kind, int]) -> list[FeatureError]:
    return list(room_errors(place[0], [place[1]], VIEWS))


def _name(place: tuple[Kind, int]) -> str:
    return f"room {place[0].name} {place[1]}"


def error_table(sets: dict[str, list[FeatureError]]) -> Iterator[str]:
    """Lines of a table: of each set, the median and the 90 % quantile of each error.

    Each true object counts once, by the segment that covers most of it; the truth is what can be seen of it, except
    for box and size in rooms.
    """
    yield "| set | objects | centroid [mm] | height [mm] | longer side [mm] | volume [%] | hue [deg] |"
    yield "|---|---|---|---|---|---|---|"
    for name, errors in sets.items():
        best = [e for e in errors if e.best]
        off = np.abs(np.array([e.errors for e in best]).reshape(-1, len(DEVIATIONS)))
        columns = [_median_and_90(np.array([e.centroid for e in best]), "centroid_up")]
        columns += [_median_and_90(off[:, DEVIATIONS.index(k)], k) for k in ("height", "long", "volume", "hue")]
        yield f"| {name} | {len(best)} | {' | '.join(columns)} |"


def _median_and_90(error: Floats, name: str) -> str:
    known = error[np.isfinite(error)]
    if not known.size:
        return "-"
    _, factor, digits = SHOWN[name]
    median, high = factor * np.quantile(known, (0.5, 0.9))
    return f"{median:.{digits}f}, {high:.{digits}f}"


def coverage_table(errors: Sequence[FeatureError], weights: Floats) -> Iterator[str]:
    """Lines of a table: of each feature, which share of the errors lies within one and two standard deviations."""
    yield "| standard deviation of | objects | within 1 (0.68) | within 2 (0.95) | typical | rank correlation |"
    yield "|---|---|---|---|---|---|"
    for c in coverage(errors, weights):
        unit, factor, digits = SHOWN[c.name]
        if c.count:
            typical = f"{factor * c.typical:.{digits}f} {unit}"
            yield f"| {c.name} | {c.count} | {c.within_one:.2f} | {c.within_two:.2f} | {typical} | {c.rank:.2f} |"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; 0 when every set could be measured, 2 for a wrong call."""
    parser = CommandParser(prog="feature_errors", description="How exactly features are measured.")
    parser.add_argument(
        "--set",
        dest="sets",
        nargs="+",
        action="append",
        default=[],
        metavar=("NAME", "FRAME"),
        help="a name, then labelled frame folders; can be given several times",
    )
    parser.add_argument("--rooms", type=int, default=2, metavar="N", help="rendered rooms of each kind (default 2)")
    add_executor_options(parser, "rooms")
    options = parser.parse_args(arguments)
    if any(len(named) < 2 for named in options.sets):
        parser.error("--set takes a name and at least one frame folder")
    try:
        sets = {name: [e for f in frames for e in folder_errors(Path(f))] for name, *frames in options.sets}
    except MbdError as error:
        parser.error(str(error))
    if options.rooms > 0:
        sets["rooms"] = all_room_errors(executor_of(options), APART, options.rooms)
    if not any(sets.values()):
        parser.error("nothing to measure: give --set NAME FRAME…, or --rooms above 0")
    sets = {name: errors for name, errors in sets.items() if errors}
    lines = [*error_table(sets)]
    for name, errors in sets.items():
        lines += ["", f"{name}:", "", *coverage_table(errors, WEIGHTS)]
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
