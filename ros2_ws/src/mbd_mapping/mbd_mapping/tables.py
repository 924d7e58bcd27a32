"""The objects of a scene as arrays, which is all the mapping sees of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mbd_model.objects import Relation, SceneObject
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ObjectTable:
    """The compared features of n objects (paper sec. 4.1, Table 1).

    Attributes:
        ids: (n,) their names.
        hue: (n,) [deg], NaN where an object has none.
        volume: (n,) bounding-box volume [m^3], or any unit common to both scenes.
        relations: (n, 4) how many other objects it is LEFT_OF, RIGHT_OF, ABOVE, BELOW.
        affordances: (n,) sets.
        properties: (n,) sets.
        positions: (n, 2) x away from the robot and y to its left [m]; None where nobody says where they stand.
        hue_std: (n,) standard deviation of the measured hue [deg], NaN where nobody knows, 0 for a grey object; None
            when nobody knows any. For what is not known the configuration's noise stands.
        volume_std: (n,) standard deviation of the measured volume, as a share of it; NaN and None likewise.
    """

    ids: tuple[str, ...]
    hue: Floats
    volume: Floats
    relations: Floats
    affordances: tuple[frozenset[str], ...]
    properties: tuple[frozenset[str], ...]
    positions: Floats | None = None
    hue_std: Floats | None = None
    volume_std: Floats | None = None

    def __len__(self) -> int:
        return len(self.ids)

    @staticmethod
    def of(objects: Sequence[SceneObject]) -> ObjectTable:
        """The table of these objects, one row each in their order."""
        relations = np.zeros((len(objects), 4))
        for row, obj in enumerate(objects):
            for kind, _ in obj.relations:
                relations[row, kind - Relation.LEFT_OF] += 1
        known = [o.deviations for o in objects]
        hue_std = [math.nan if d is None else d.hue or 0.0 for d in known]
        volume_std = [math.nan if d is None else d.volume / o.volume for d, o in zip(known, objects, strict=True)]
        measured = any(d is not None for d in known)
        return ObjectTable(
            ids=tuple(o.object_id for o in objects),
            hue=np.array([math.nan if o.hue is None else o.hue for o in objects], dtype=float),
            volume=np.array([o.volume for o in objects], dtype=float),
            relations=relations,
            affordances=tuple(o.affordances for o in objects),
            properties=tuple(o.properties for o in objects),
            positions=np.array([o.centroid[:2] for o in objects], dtype=float).reshape(-1, 2),
            hue_std=np.array(hue_std) if measured else None,
            volume_std=np.array(volume_std) if measured else None,
        )
