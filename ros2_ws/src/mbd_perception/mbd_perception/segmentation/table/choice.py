"""Which of the planes in view is the table.

Candidates are scored, none is cut off: a table is large and far above what lies below it, a lid is small and hardly
above the table. Between two level planes the odds of these two stories decide, with what stands on each.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from numpy.typing import NDArray

from mbd_perception.frames.frame import FloatImage
from mbd_perception.frames.units import HORIZON, units_hint
from mbd_perception.segmentation.table.orientation import quarter_turns, turned_normal
from mbd_perception.segmentation.table.plane import NoTableError, Plane, PlaneCandidate, PlaneConfig, Vector
from mbd_perception.segmentation.table.plane_search import STRIDE, find_planes, inverse_error, seen_area
from mbd_perception.segmentation.table.walls import walls_behind

# An upright camera rolls by less than 20 degrees; one that sees a table from the side looks down by less than 70.
ROLL, FACING = 0.34, 0.34


@dataclass(frozen=True)
class ChoiceConfig:
    """Log-odds of what a level plane can be. Sizes are log-normal: median and std of the logarithm.

    Attributes:
        table_area, lid_area: of what is seen of a table, and of the lids of things on it [m^2].
        table_drop, lid_drop: height above the next level plane below [m].
        standing: added for a plane on which things stand, against one that is empty.
        least_standing: visible surface of things [m^2] from which on a plane is not empty.
        turned: against a camera rolled by a quarter turn or two.
        wall: smallest score by area of a plane seen from the side that makes what faces the camera a wall.
        same_as_last: added for the table of the last frame.
        bent_offset, bent_angle: planes as near as that are one that is bent [m, rad].
        last_offset, last_angle: within which it is the same [m, rad].
    """

    table_area: tuple[float, float] = (0.6, 0.9)
    lid_area: tuple[float, float] = (0.02, 0.9)
    table_drop: tuple[float, float] = (0.6, 0.5)
    lid_drop: tuple[float, float] = (0.12, 0.6)
    standing: float = 4.0
    least_standing: float = 0.002
    turned: float = -3.0
    wall: float = -2.0
    same_as_last: float = 3.0
    bent_offset: float = 0.025
    bent_angle: float = 0.1
    last_offset: float = 0.02
    last_angle: float = 0.05


@dataclass(frozen=True)
class FoundTable:
    """The table of a depth image.

    Attributes:
        plane: it.
        noise: std of inverse depth [1/m] with which it was found.
        walls: upright planes behind which nothing of the table is seen.
    """

    plane: Plane
    noise: float
    walls: tuple[Plane, ...] = ()


def find_table(
    depth: FloatImage,
    camera: Intrinsics,
    config: PlaneConfig,
    up: Vector | None = None,
    *,
    last: Plane | None = None,
    choice: ChoiceConfig | None = None,
) -> FoundTable:
    """The plane objects stand on, and how well it is seen.

    With ``up`` known it is within ``max_tilt`` of level. Otherwise the camera is rather upright, looking ahead or down,
    than rolled by a quarter turn or two; a wall that faces it is distinguished from a table below it by what else there
    is: with a table in view from the side, what faces the camera is a wall.

    Args:
        depth: (height, width) float32 [m], 0 = none.
        camera: its camera.
        config: how planes are looked for.
        up: (3,) unit vector against gravity in the optical frame; None when not known.
        last: the table of the last frame of the same camera; None when there is none.
        choice: how candidates are scored.

    Raises:
        NoTableError: no such plane; the text states what was seen instead.
    """
    every = found = find_planes(depth, camera, config, up)
    noise = found[0].noise if found else config.noise
    chooser = _Choice(depth, camera, replace(config, noise=noise), choice or ChoiceConfig(), last)
    if up is None:
        found = chooser.level_for_one_roll(found)
    if found:
        best = chooser.table_of(found)
        if best.plane.offset > HORIZON:
            raise NoTableError(
                f"no table in view: the flat surface seen is {best.plane.offset:.0f} m away; "
                f"{units_hint(best.plane.offset)}"
            )
        if up is None or best.plane.tilt(up) <= config.max_tilt:
            return FoundTable(best.plane, noise, walls_behind(every, best.plane, depth, camera, noise))
        raise NoTableError(_tilted(best.plane, up))
    others = find_planes(depth, camera, config, None)
    if others and up is not None:
        raise NoTableError(_tilted(others[0].plane, up))
    raise NoTableError(
        "no table in view: no flat surface fills enough of the picture; point the camera at the table, "
        "clear away what covers it, and check the workspace limits"
    )


def supporting_plane(depth: FloatImage, camera: Intrinsics, config: PlaneConfig, up: Vector | None = None) -> Plane:
    """The plane of ``find_table``, which see."""
    return find_table(depth, camera, config, up).plane


class _Choice:
    """The candidates of one depth image, to be compared."""

    def __init__(
        self, depth: FloatImage, camera: Intrinsics, config: PlaneConfig, choice: ChoiceConfig, last: Plane | None
    ) -> None:
        self._depth, self._camera, self._config, self._choice, self._last = depth, camera, config, choice, last

    def level_for_one_roll(self, found: list[PlaneCandidate]) -> list[PlaneCandidate]:
        """The planes that are level for the likeliest of the four ways the camera can be mounted.

        A wall is level for a camera that looks down, mounted another way, and is as large as any table: what stands on
        the planes decides then.
        """
        rolls = [(turns, level) for turns in range(4) if (level := self._level_for(found, turns))]
        if len(rolls) < 2:
            return rolls[0][1] if rolls else []
        errors = [inverse_error(self._depth, self._camera, c.plane) for c in found]
        flat = np.any([np.abs(e) < 6 * self._config.noise for e in errors], axis=0)
        laden = {id(c): self._laden(e, flat, c) for e, c in zip(errors, found, strict=True)}

        def score(roll: tuple[int, list[PlaneCandidate]]) -> float:
            best = max(self._by_area(c) + self._by_last(c) + self._choice.standing * laden[id(c)] for c in roll[1])
            return best + (self._choice.turned if roll[0] else 0.0)

        return max(rolls, key=score)[1]

    def _level_for(self, found: list[PlaneCandidate], turns: int) -> list[PlaneCandidate]:
        """The planes that may be level when the picture is turned counter-clockwise ``turns`` times."""
        level = []
        for c in found:
            normal = turned_normal(c.plane.normal, turns)
            upright = abs(normal[0]) < ROLL and normal[1] < ROLL
            if upright and (turns == 0 or quarter_turns(c.plane.normal) == turns):
                level.append(c)
        from_the_side = [c for c in level if turned_normal(c.plane.normal, turns)[1] < -FACING]
        if from_the_side and max(self._by_area(c) for c in from_the_side) >= self._choice.wall:
            return from_the_side
        return level

    def table_of(self, found: list[PlaneCandidate]) -> PlaneCandidate:
        """The table among level planes: from the nearest down, as long as what was taken for it is rather a lid."""
        if len(found) == 1:
            return found[0]
        near_first = sorted(self._bent_as_one(found), key=lambda c: c.plane.offset)
        errors = [inverse_error(self._depth, self._camera, c.plane) for c in near_first]
        flat = np.any([np.abs(e) < 6 * self._config.noise for e in errors], axis=0)
        laden = [self._laden(e, flat, c) for e, c in zip(errors, near_first, strict=True)]
        best = 0
        for lower in range(1, len(near_first)):
            upper, below = near_first[best], near_first[lower]
            drop = max(below.plane.offset - upper.plane.offset, 1e-3)
            lid = _log_normal(drop, self._choice.lid_drop) + _log_normal(upper.patch, self._choice.lid_area)
            table = _log_normal(drop, self._choice.table_drop) + _log_normal(upper.patch, self._choice.table_area)
            odds = lid - table + self._choice.standing * (float(laden[lower]) - float(laden[best]))
            # The lower one has to be a table in its own right: the seat of a chair is none for what stands above it.
            odds += min(self._by_area(below) - self._choice.wall, 0.0)
            odds += self._by_last(below) - self._by_last(upper)
            if odds > 0:
                best = lower
        return near_first[best]

    def _bent_as_one(self, found: list[PlaneCandidate]) -> list[PlaneCandidate]:
        """Candidates without the ones that are parts of a better supported one, which a lens or a sensor bends.

        What is left has the area of all its parts.
        """
        kept: list[PlaneCandidate] = []
        parts: list[list[PlaneCandidate]] = []
        for candidate in found:
            for number, other in enumerate(kept):
                apart = abs(candidate.plane.offset - other.plane.offset)
                if (
                    apart < self._choice.bent_offset
                    and candidate.plane.tilt(other.plane.normal) < self._choice.bent_angle
                ):
                    parts[number].append(candidate)
                    break
            else:
                kept.append(candidate)
                parts.append([candidate])
        merged = []
        for candidate, pieces in zip(kept, parts, strict=True):
            if len(pieces) == 1:
                merged.append(candidate)
                continue
            area, patch = seen_area(self._depth, self._camera, [p.plane for p in pieces], self._config)
            merged.append(replace(candidate, area=area, patch=patch))
        return merged

    def _laden(self, error: FloatImage, flat: NDArray[np.bool_], candidate: PlaneCandidate) -> bool:
        """Whether things stand on a plane: what is no plane, rises less than 0.4 m, within what is seen of it."""
        small = self._depth[::STRIDE, ::STRIDE]
        height = error * small * np.float32(candidate.plane.offset)
        rising = (
            (height > max(0.01, 6 * self._config.noise * candidate.plane.offset)) & (height < 0.4) & ~flat & (small > 0)
        )
        level = (np.abs(error) < 4 * self._config.noise) & (small > 0)
        v, u = np.nonzero(level)
        if len(v) < 3:
            return False
        hull = cv2.convexHull(np.stack([u, v], axis=1).astype(np.int32))
        within = np.zeros(level.shape, dtype=np.uint8)
        cv2.fillConvexPoly(within, hull, 1)
        pixel = small[rising & (within > 0)] ** 2
        return float(pixel.sum()) * STRIDE**2 / (self._camera.fx * self._camera.fy) >= self._choice.least_standing

    def _by_area(self, candidate: PlaneCandidate) -> float:
        """Log-likelihood of a table's area, 0 from the median on: no table is too large."""
        median, spread = self._choice.table_area
        return -0.5 * min(log(max(candidate.area, 1e-4) / median) / spread, 0.0) ** 2

    def _by_last(self, candidate: PlaneCandidate) -> float:
        """What the table of the last frame says for a candidate."""
        if self._last is None:
            return 0.0
        near = abs(candidate.plane.offset - self._last.offset) < self._choice.last_offset
        return (
            self._choice.same_as_last
            if near and candidate.plane.tilt(self._last.normal) < self._choice.last_angle
            else 0.0
        )


def _log_normal(value: float, shape: tuple[float, float]) -> float:
    """Log-density of log(value); beyond 3 std it falls no further, for there are other stories."""
    median, spread = shape
    return -0.5 * min(abs(log(max(value, 1e-4) / median) / spread), 4.0) ** 2 - log(spread)


def _tilted(plane: Plane, up: Vector) -> str:
    """What to report when the only plane is not level."""
    return (
        f"no table in view: the largest flat surface is tilted {np.degrees(plane.tilt(up)):.0f} degrees against "
        "level; check the camera's pose (camera_position, camera_orientation) and that it sees the table"
    )
