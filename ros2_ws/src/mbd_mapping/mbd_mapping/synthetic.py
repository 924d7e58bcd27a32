"""Random object tables with the structure that makes mapping hard: ties, missing hues, unequal scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mbd_model.geometry.spatial import spatial_relations
from mbd_model.objects import Role, Scene, SceneObject

from mbd_mapping.tables import ObjectTable

AFFORDANCES = ("fillable", "pourable", "stackable", "scoopable", "openable", "edible", "graspable", "hangable")
PROPERTIES = ("upright", "empty", "full", "open", "closed", "clean", "wet", "fragile")
EDGE = (0.06, 0.10)  # [m] of a bounding box: what the Jaco's hand holds; 0.2 to 1 litre, as the study's cups


def random_table(rng: np.random.Generator, size: int, prefix: str, variety: int = 0) -> ObjectTable:
    """A table of ``size`` objects.

    Args:
        rng: source of randomness.
        size: how many objects.
        prefix: their ids are prefix0, prefix1, ...
        variety: 0 draws hues and volumes from a continuum; k > 0 from k values, so that objects tie.
    """
    if variety:
        hue = rng.integers(0, variety, size).astype(np.float64) * (360.0 / variety)
        volume = 1e-4 * (1.0 + rng.integers(0, variety, size).astype(np.float64))
        hue[rng.random(size) < 0.1] = np.nan
    else:
        hue, volume = rng.uniform(0.0, 360.0, size), rng.uniform(1e-4, 1e-3, size)
    relations = rng.integers(0, max(2, min(size, variety or size)), (size, 4)).astype(float)
    return ObjectTable(
        ids=tuple(f"{prefix}{k}" for k in range(size)),
        hue=hue,
        volume=volume,
        relations=relations,
        affordances=tuple(_subset(rng, AFFORDANCES) for _ in range(size)),
        properties=tuple(_subset(rng, PROPERTIES) for _ in range(size)),
    )


def random_scene(
    rng: np.random.Generator, role: Role, size: int, prefix: str, edge: tuple[float, float] = EDGE
) -> Scene:
    """A scene of ``size`` random objects on a table [m], named prefix0, prefix1, ..., with edges in this range [m]."""
    objects = []
    for k in range(size):
        x, y = rng.uniform(0.3, 1.2), rng.uniform(-0.5, 0.5)
        width, depth, height = (float(v) for v in rng.uniform(*edge, 3))
        objects.append(
            SceneObject(
                f"{prefix}{k}",
                (float(x), float(y), height / 2),
                (width, depth, height),
                hue=float(rng.uniform(0.0, 360.0)),
                affordances=_subset(rng, AFFORDANCES),
                properties=_subset(rng, PROPERTIES),
            )
        )
    relations = spatial_relations(objects)
    return Scene(role, tuple(replace(o, relations=r) for o, r in zip(objects, relations, strict=True)))


def _subset(rng: np.random.Generator, names: tuple[str, ...]) -> frozenset[str]:
    """At least one of the names, each with probability 0.4."""
    chosen: frozenset[str] = frozenset()
    while not chosen:
        chosen = frozenset(name for name in names if rng.random() < 0.4)
    return chosen


def random_problem(rng: np.random.Generator, size: int, edge: tuple[float, float] = EDGE) -> tuple[Scene, Scene]:
    """Source and target scene of experiment 1 (paper sec. 5).

    Each source object is reused in the target with probability 0.5: it keeps size, hue and affordances and gets a new
    place and new properties. The others are new objects.
    """
    source = random_scene(rng, Role.SOURCE, size, "s", edge)
    fresh = random_scene(rng, Role.TARGET, size, "t", edge)
    objects = []
    for new, old in zip(fresh.objects, source.objects, strict=True):
        kept = old if rng.random() < 0.5 else new
        objects.append(
            replace(new, size=kept.size, volume=kept.volume, hue=kept.hue, affordances=kept.affordances, relations=())
        )
    order = rng.permutation(size)
    shuffled = [replace(objects[k], object_id=f"t{place}") for place, k in enumerate(order)]
    relations = spatial_relations(shuffled)
    return source, Scene(Role.TARGET, tuple(replace(o, relations=r) for o, r in zip(shuffled, relations, strict=True)))
