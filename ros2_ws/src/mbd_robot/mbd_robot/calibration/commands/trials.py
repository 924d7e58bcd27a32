"""How often the error that is stated holds the true one, on synthetic pictures whose truth is known."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

import numpy as np
from mbd_model.command_line.values import at_least_one, zero_or_more

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.solving.calibration import calibrate
from mbd_robot.calibration.solving.certainty import off_by
from mbd_robot.calibration.synthetic import KnownPairs, PairNoise, known_pairs


def arguments(parser: argparse.ArgumentParser) -> None:
    """What it is given."""
    parser.add_argument("--count", type=at_least_one, default=200, help="trials (default 200)")
    parser.add_argument("--pictures", type=at_least_one, default=12, help="of each trial (default 12)")
    parser.add_argument("--mounting", choices=[m.value for m in BoardMounting], default="hand")
    parser.add_argument("--wrong", type=int, default=0, help="pictures with another picture's pose (default 0)")
    parser.add_argument("--pixels", type=zero_or_more, default=0.2, help="[px] noise of corners (default 0.2)")
    parser.add_argument(
        "--place", type=zero_or_more, default=2.0, help="[mm] noise of the tool along an axis (default 2)"
    )
    parser.add_argument(
        "--turn", type=zero_or_more, default=0.23, help="[deg] noise of the tool about an axis (default 0.23)"
    )
    parser.add_argument("--seed", type=int, default=0)


def run(given: argparse.Namespace) -> int:
    """Run them and print what came of it."""
    noise = PairNoise(pixels=given.pixels, place=given.place / 1000.0, turn=float(np.radians(given.turn)))
    errors, bounds, refused, kept, lost = [], [], 0, 0, 0
    for trial in range(given.count):
        rng = np.random.default_rng((given.seed, trial))
        known = known_pairs(rng, given.pictures, BoardMounting(given.mounting), noise)
        wrong = {pair.name for pair in known.given.pairs[: given.wrong]}
        try:
            result = calibrate(swapped(known, given.wrong).given, rng, thorough=False)
        except CalibrationError:
            refused += 1
            continue
        errors.append(off_by(result.fit, known.x, result.points[0]))
        bounds.append(result.bounds[0])
        kept += len(wrong - set(result.wrong))
        lost += len(set(result.wrong) - wrong)
    held = int(np.sum(np.array(errors) <= np.array(bounds)))
    middle = [f"{np.median(v) * 1000.0:.2f}" if v else "-" for v in (errors, bounds)]
    sys.stdout.write(
        f"{given.count} trials of {given.pictures} pictures ({given.wrong} wrong), board on the {given.mounting}\n"
        f"true error within the stated 95 % bound: {held} of {len(errors)}; refused: {refused}\n"
        f"median true error {middle[0]} mm, median bound {middle[1]} mm\n"
        f"wrong pictures kept: {kept}; right ones left out: {lost}\n"
    )
    return 0


def swapped(known: KnownPairs, wrong: int) -> KnownPairs:
    """The first so many pictures with the pose of another one, some places on."""
    pairs = list(known.given.pairs)
    for i in range(wrong):
        other = known.given.pairs[(i + max(wrong, 3)) % len(pairs)]
        pairs[i] = replace(pairs[i], tool=other.tool)
    return replace(known, given=replace(known.given, pairs=pairs))
