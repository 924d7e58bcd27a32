"""Random scenes of several kinds for the families."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from mbd_mapping.config import MappingConfig
from mbd_mapping.similarity import Comparison
from mbd_mapping.synthetic import random_problem, random_scene, random_table
from mbd_mapping.tables import Floats, ObjectTable
from mbd_model.geometry.spatial import spatial_relations
from mbd_model.objects import Role, Scene, SceneObject

from mbd_experiments.teacher_families.lesson import Scenes

HUE_ERROR, EDGE_ERROR, PLACE_ERROR = 5.0, 0.04, 0.01  # [deg], share, [m]: standard deviations of measuring
SIZES = (5, 6, 7)
NEUTRAL = MappingConfig()  # what a teacher compares by has no parameter but sigma


def size_of(rng: np.random.Generator, sizes: Sequence[int] = SIZES) -> int:
    """How many objects a lesson has."""
    return int(rng.choice(np.array(sizes)))


def compared(source: ObjectTable, target: ObjectTable) -> Scenes:
    """Scenes measured exactly."""
    return Scenes(source, target, source, target, Comparison.of(source, target, NEUTRAL))


def plain(rng: np.random.Generator, sizes: Sequence[int] = SIZES) -> Scenes:
    """The problems of experiment 1."""
    source, target = random_problem(rng, size_of(rng, sizes))
    return compared(ObjectTable.of(source.objects), ObjectTable.of(target.objects))


def heavy_tailed(rng: np.random.Generator) -> Scenes:
    """Volumes log-normal over several powers of ten."""
    scenes = random_problem(rng, size_of(rng))
    volumes = {o.hue: 1e-3 * math.exp(rng.normal(0.0, 1.5)) for scene in scenes for o in scene.objects}
    tables = [ObjectTable.of([replace(o, volume=float(volumes[o.hue])) for o in s.objects]) for s in scenes]
    return compared(*tables)


def few_values(rng: np.random.Generator) -> Scenes:
    """Hues and sizes of three values only, so that many objects tie."""
    size = size_of(rng)
    tables = []
    for prefix in "st":
        places = np.column_stack([rng.uniform(0.3, 1.2, size), rng.uniform(-0.5, 0.5, size)])
        tables.append(replace(random_table(rng, size, prefix, 3), positions=places))
    return compared(*tables)


def unequal(rng: np.random.Generator) -> Scenes:
    """Distractors in the target scene, or objects missing from it."""
    n = size_of(rng)
    m = int(rng.choice([n - 1, n + 1, n + 2]))
    source, target = random_problem(rng, max(n, m))
    smaller = Scene(Role.TARGET, target.objects[:m]) if m < n else target
    kept = source.objects[:n]
    return compared(_of(kept), _of(smaller.objects))


def unequal_unlike(rng: np.random.Generator) -> Scenes:
    """The same with targets none of which is a source object seen again."""
    n = size_of(rng)
    m = int(rng.choice([n - 1, n + 1, n + 2]))
    source, target = random_scene(rng, Role.SOURCE, n, "s"), random_scene(rng, Role.TARGET, m, "t")
    return compared(ObjectTable.of(source.objects), ObjectTable.of(target.objects))


def through_a_camera(rng: np.random.Generator) -> Scenes:
    """The problems of experiment 1, measured with a camera's errors."""
    scenes = random_problem(rng, size_of(rng))
    true = [ObjectTable.of(s.objects) for s in scenes]
    seen = [ObjectTable.of(measured(rng, s).objects) for s in scenes]
    return Scenes(true[0], true[1], seen[0], seen[1], Comparison.of(true[0], true[1], NEUTRAL))


def measured(rng: np.random.Generator, scene: Scene) -> Scene:
    """The scene as a camera with errors sees it."""
    objects = [
        replace(
            o,
            centroid=_three(np.array(o.centroid) + rng.normal(0.0, PLACE_ERROR, 3)),
            size=_three(np.array(o.size) * np.exp(rng.normal(0.0, EDGE_ERROR, 3))),
            hue=float(((o.hue or 0.0) + rng.normal(0.0, HUE_ERROR)) % 360.0),
            volume=math.nan,
        )
        for o in scene.objects
    ]
    relations = spatial_relations(objects)
    return replace(scene, objects=tuple(replace(o, relations=r) for o, r in zip(objects, relations, strict=True)))


def _three(values: Floats) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


def _of(objects: Sequence[SceneObject]) -> ObjectTable:
    kept = [replace(o, relations=()) for o in objects]
    relations = spatial_relations(kept)
    return ObjectTable.of([replace(o, relations=r) for o, r in zip(kept, relations, strict=True)])
