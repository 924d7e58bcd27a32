"""How well a picture is foretold by the others: the error that nobody could fit away, of every method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mbd_robot.calibration.solving.bundle import reprojection_errors
from mbd_robot.calibration.solving.hand_eye import Array, andreff, daniilidis, horaud, park, tsai
from mbd_robot.calibration.solving.problem import HandEyeProblem
from mbd_robot.calibration.solving.refinement import HandEyeFit, refine
from mbd_robot.calibration.solving.robot_world import li, shah
from mbd_robot.calibration.transforms import Transforms, inverse

CLOSED_FORMS: dict[str, Callable[[Transforms, Transforms], Transforms]] = {
    "tsai": tsai, "park": park, "horaud": horaud, "andreff": andreff, "daniilidis": daniilidis, "shah": shah, "li": li,
}  # fmt: skip
REFINED = "refined"
RESAMPLES = 1000


@dataclass(frozen=True)
class LeftOutErrors:
    """Of one method, of every picture foretold by the others.

    Attributes:
        method: its name.
        pixels: (n,) root mean square distance of the picture's corners from where they were foretold [px].
        millimetres: (n,) distance of the board's middle from where it was foretold [mm].
    """

    method: str
    pixels: Array
    millimetres: Array

    @property
    def pixel_error(self) -> float:
        """Root mean square of all pictures [px]."""
        return rms(self.pixels)

    @property
    def millimetre_error(self) -> float:
        """Root mean square of all pictures [mm]."""
        return rms(self.millimetres)


def left_out_errors(problem: HandEyeProblem, fit: HandEyeFit) -> list[LeftOutErrors]:
    """Of each closed form and of the refined solution, the best first.

    Args:
        problem: pictures without wrong ones.
        fit: the refined solution, from which those without one picture begin.
    """
    count = len(problem.pairs)
    methods = {name: _closed(solve) for name, solve in CLOSED_FORMS.items()}

    def refined(others: HandEyeProblem) -> tuple[Transforms, Transforms]:
        again = refine(others, fit.x, fit.y)
        return again.x, again.y

    methods[REFINED] = refined
    table = []
    for name, solve in methods.items():
        pixels, millimetres = np.full(count, np.inf), np.full(count, np.inf)
        for i in range(count):
            try:
                x, y = solve(problem.subset(np.arange(count) != i))
            except (np.linalg.LinAlgError, ValueError):
                continue
            pixels[i], millimetres[i] = _foretold(problem.subset(np.array([i])), x, y)
        table.append(LeftOutErrors(name, pixels, millimetres))
    return sorted(table, key=lambda errors: errors.pixel_error)


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def interval(values: Array, rng: np.random.Generator) -> tuple[float, float]:
    """The 95 % interval of the root mean square of values, by drawing pictures again."""
    drawn = rng.choice(values, (RESAMPLES, len(values)))
    low, high = np.quantile(np.sqrt(np.mean(np.square(drawn), axis=1)), (0.025, 0.975))
    return float(low), float(high)


def _closed(
    solve: Callable[[Transforms, Transforms], Transforms],
) -> Callable[[HandEyeProblem], tuple[Transforms, Transforms]]:
    def solved(problem: HandEyeProblem) -> tuple[Transforms, Transforms]:
        x = solve(problem.arm, problem.board)
        return x, problem.board_pose(x)

    return solved


def _foretold(one: HandEyeProblem, x: Transforms, y: Transforms) -> tuple[float, float]:
    error = reprojection_errors(one, x, y)[0]
    centre = one.given.board.centre
    there, here = (inverse(x) @ inverse(one.arm) @ y)[0], one.board[0]
    distance = (there[:3, :3] - here[:3, :3]) @ centre + there[:3, 3] - here[:3, 3]
    squared = np.where(np.isfinite(error), error, 1e4) ** 2
    return float(np.sqrt(squared.sum(axis=1).mean())), float(np.linalg.norm(distance)) * 1000.0
