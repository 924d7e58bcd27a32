"""A random demonstration of everything a teacher does with the mixed scene."""

from __future__ import annotations

import math

import numpy as np

from mbd_demonstration.generated.teacher import SPACING, ActingTeacher, ShownActs, mixed_scene

NAMES = ("wide", "narrow", "block", "pen", "card", "above")


def random_acts(rng: np.random.Generator) -> ShownActs:
    """Three to five carries, some of them interrupted, with fingers that move on the way and pushes between."""
    scene = mixed_scene(rng)
    teacher = ActingTeacher(scene, rng, ramp=float(rng.uniform(0.4, 1.5)))
    grid = [(0.35 + SPACING * (k // 4), SPACING * (k % 4 - 1.5)) for k in rng.permutation(12)]
    free = [p for p in grid if all(math.dist(p, o.centroid[:2]) > 0.01 for o in scene.objects)]
    names = [str(name) for name in rng.permutation(NAMES)][: int(rng.integers(3, 6))]
    for name, place in zip(names, free, strict=False):
        if rng.random() < 0.2:
            teacher.fidget(float(rng.uniform(0.2, 0.55)))
        if rng.random() < 0.15 and name not in ("wide", "block"):
            teacher.push(str(rng.choice(["wide", "block"])))
        if rng.random() < 0.15:
            teacher.sag_and_grasp_again(name)
        else:
            teacher.take(name)
        if rng.random() < 0.1:
            teacher.hand_over(name)
        withdraw = bool(rng.random() < 0.3)
        how = rng.random()
        block = teacher.objects["block"].centroid
        if how < 0.35 and name not in ("wide", "pen") and "wide" not in teacher.under():
            teacher.release(name, onto="wide", withdraw=withdraw)
        elif how < 0.6 and name == "pen" and block[2] < 0.03:
            teacher.release(name, place=(block[0], block[1] + 0.0225 + 0.006 + 0.002), withdraw=withdraw)
        else:
            teacher.release(name, place=place, withdraw=withdraw)
    if rng.random() < 0.3 and "below" in teacher.under():
        teacher.carry("below", place=free[-1])
    return teacher.done()
