"""A calibration in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.solving.calibration import HandEyeCalibration
from mbd_robot.calibration.solving.certainty import SEED, bound_across, open_direction
from mbd_robot.calibration.solving.left_out import REFINED, LeftOutErrors, interval
from mbd_robot.calibration.solving.spread import one_axis, spread_words

MANY_WRONG = 0.2  # share of pictures left out from which something is wrong with all
SYSTEMATIC = (
    "Not in these numbers: what all poses have in common, as a wrong scale of the board or a base frame that is not "
    "where the tool's poses say. Touch the table and a mark, and run `calibrate check`."
)


def report(result: HandEyeCalibration) -> Iterator[str]:
    """Lines for people."""
    problem, fit = result.problem, result.fit
    given = problem.given
    moved = "board on the hand" if result.mounting is BoardMounting.HAND else "camera on the hand, board on the table"
    seen = len(problem.pairs) + len(result.wrong)
    yield (
        f"{seen + len(given.blind)} pictures, {moved}: the board is in {seen}, "
        f"{len(problem.pairs)} agree with each other"
    )
    if given.blind:
        yield f"  no board found: {_some(given.blind)}"
    for name, why in result.wrong.items():
        yield f"  left out: {name}: {why}"
    if len(result.wrong) > MANY_WRONG * seen:
        yield "  That are many: did the tool stand still for each picture, and board and camera hold?"
    yield f"lens: f = {given.lens.pinhole.fx:.1f} px, {given.lens.origin}"
    yield (
        f"a corner is found to {problem.pixel_noise:.2f} px; the tool's pose is off by {fit.place_noise * 1000:.1f} mm "
        f"and {np.degrees(fit.turn_noise):.2f} deg along and about each axis (standard deviations)"
    )
    if result.methods:
        yield "each picture foretold by the others, root mean square (95 % interval)"
        yield from (f"  {_errors(m)}" for m in result.methods)
    x, y, z = fit.x[:3, 3]
    frame = "base" if result.mounting is BoardMounting.HAND else "tool"
    quaternion = ", ".join(f"{v:.5f}" for v in result.quaternion)
    yield f"camera2{frame}: ({x:.4f}, {y:.4f}, {z:.4f}) m, quaternion ({quaternion})"
    yield statement(result)
    for words in (spread_words(problem), f"worth a picture: {result.next_pose}" if result.next_pose else ""):
        if words:
            yield words
    yield SYSTEMATIC


def statement(result: HandEyeCalibration) -> str:
    """How far off it may be, in one sentence."""
    if one_axis(result.problem):
        axis = open_direction(result.problem, result.fit)
        across = bound_across(result.fit, result.points[0], axis) * 1000.0
        return (
            "Along the one axis that the tool was turned about the camera's place is open, and nothing here says where "
            f"it is; across it a point is put within {across:.1f} mm of where it is, with 95 % probability."
        )
    away = float(np.linalg.norm(result.points[0]))
    middle, worst = result.bounds[0] * 1000.0, result.bounds.max() * 1000.0
    where = "where the camera looks" if result.mounting is BoardMounting.HAND else "at the board"
    edges = f", within {worst:.1f} mm everywhere on the table it sees" if len(result.bounds) > 1 else ""
    return (
        f"With 95 % probability a point {where} ({away:.2f} m away) is put within {middle:.1f} mm of where it "
        f"is{edges}; the camera itself within {result.camera_bound * 1000.0:.1f} mm."
    )


def left_out_statement(result: HandEyeCalibration) -> str:
    """The refined solution's left-out error; "" where it was not asked for."""
    return next((_errors(m) for m in result.methods if m.method == REFINED), "")


def _errors(errors: LeftOutErrors) -> str:
    if not np.isfinite(errors.pixels).all():
        return f"{errors.method:11} has no solution without some picture"
    rng = np.random.default_rng(SEED)
    pixels, millimetres = interval(errors.pixels, rng), interval(errors.millimetres, rng)
    return (
        f"{errors.method:11} {errors.pixel_error:6.2f} px ({pixels[0]:.2f} to {pixels[1]:.2f})   "
        f"{errors.millimetre_error:6.2f} mm ({millimetres[0]:.2f} to {millimetres[1]:.2f})"
    )


def _some(names: tuple[str, ...]) -> str:
    return ", ".join(names[:10]) + (f" and {len(names) - 10} more" if len(names) > 10 else "")
