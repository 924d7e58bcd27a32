"""The two case studies of the paper (sec. 5.1) as object tables: dish sorting and assembly.

The paper gives classes, affordances (Table 2) and what was predicted, not the measured features: places, hues and sizes
here are ours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mbd_mapping.config import FeatureSpace, MappingConfig
from mbd_mapping.inference import infer
from mbd_model.assists import Assist
from mbd_model.estimate import MappingEstimate
from mbd_model.geometry.spatial import spatial_relations
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind, Task, TaskStep

KNOWLEDGE = {
    "cup": (frozenset({"fillable", "pourable"}), frozenset({"empty", "full", "upright"})),
    "bowl": (frozenset({"fillable", "stackable"}), frozenset({"empty", "full", "upright"})),
    "utensil": (frozenset({"scoopable", "pourable"}), frozenset({"empty", "full", "upright"})),
    "block": (frozenset({"stackable"}), frozenset[str]()),
}

# id: (class, x [m], y [m], edge lengths w, d, h [cm], hue [deg])
ObjectNumbers = tuple[str, float, float, tuple[float, float, float], float]
DISHES_SOURCE: dict[str, ObjectNumbers] = {
    "spoon": ("utensil", 0.55, 0.35, (3.0, 18.0, 2.0), 210.0),
    "ladle": ("utensil", 0.80, 0.35, (7.0, 26.0, 5.0), 30.0),
    "mug": ("cup", 0.60, 0.10, (8.0, 8.0, 10.0), 0.0),
    "glass": ("cup", 0.85, 0.05, (6.5, 6.5, 12.0), 190.0),
    "cereal_bowl": ("bowl", 0.55, -0.15, (15.0, 15.0, 6.0), 50.0),
    "salad_bowl": ("bowl", 0.85, -0.20, (24.0, 24.0, 10.0), 120.0),
    "dip_bowl": ("bowl", 0.70, -0.40, (9.0, 9.0, 4.0), 280.0),
}
DISHES_TARGET: dict[str, ObjectNumbers] = {
    "fork": ("utensil", 0.85, -0.35, (2.5, 19.0, 2.0), 100.0),
    "spatula": ("utensil", 0.60, -0.38, (8.0, 30.0, 2.5), 355.0),
    "tumbler": ("cup", 0.80, 0.30, (7.0, 7.0, 13.0), 260.0),
    "teacup": ("cup", 0.60, 0.38, (9.0, 9.0, 6.5), 60.0),
    "soup_bowl": ("bowl", 0.55, 0.10, (16.0, 16.0, 5.5), 15.0),
    "mixing_bowl": ("bowl", 0.85, 0.00, (26.0, 26.0, 12.0), 215.0),
    "rice_bowl": ("bowl", 0.65, -0.12, (11.0, 11.0, 6.0), 165.0),
}
# Of each hue a large and a small block; by hue alone large and small would be exchanged, the target's blocks are larger
# throughout, and the scale is not quite the same for all: it takes hue for the colour and an assist for the size.
ASSEMBLY_SOURCE: dict[str, ObjectNumbers] = {
    "red_large": ("block", 0.55, 0.30, (6.0, 6.0, 6.0), 2.0),
    "green_large": ("block", 0.60, 0.02, (6.1, 6.0, 6.0), 118.0),
    "blue_large": ("block", 0.58, -0.28, (6.2, 6.0, 6.0), 236.0),
    "red_small": ("block", 0.80, 0.28, (4.0, 4.0, 4.0), 8.0),
    "green_small": ("block", 0.85, -0.02, (4.1, 4.0, 4.0), 124.0),
    "blue_small": ("block", 0.82, -0.31, (4.2, 4.0, 4.0), 242.0),
}
ASSEMBLY_TARGET: dict[str, ObjectNumbers] = {
    "red_big": ("block", 0.84, -0.30, (7.8, 7.5, 7.3), 9.0),
    "green_big": ("block", 0.57, 0.01, (7.3, 7.4, 7.2), 125.0),
    "blue_big": ("block", 0.83, 0.30, (7.6, 7.7, 7.5), 243.0),
    "red_little": ("block", 0.58, -0.29, (5.1, 5.0, 5.3), 1.0),
    "green_little": ("block", 0.60, 0.29, (5.2, 5.3, 5.4), 117.0),
    "blue_little": ("block", 0.81, 0.03, (4.8, 4.9, 5.0), 235.0),
}


@dataclass(frozen=True)
class CaseStudy:
    """One case study.

    Attributes:
        name: what the paper calls it.
        task: the demonstrated task over the source objects.
        target: the target scene.
        solution: acceptable target ids of each source id.
        order: source ids in the order the teacher assists.
    """

    name: str
    task: Task
    target: Scene
    solution: Mapping[str, frozenset[str]]
    order: tuple[str, ...]

    def solved_by(self, mapping: Mapping[str, str]) -> bool:
        """True when every object goes where it may."""
        return all(mapping.get(source) in targets for source, targets in self.solution.items())

    def assists(self, count: int) -> tuple[Assist, ...]:
        """The first ``count`` assists: each names the first acceptable target not named yet."""
        named: list[Assist] = []
        for source in self.order[:count]:
            taken = {a.target_id for a in named}
            target = next(t for t in self.target.ids if t in self.solution[source] and t not in taken)
            named.append(Assist(source, target, self.task.used_objects.index(source)))
        return tuple(named)


@dataclass(frozen=True)
class Predicted:
    """What is predicted after some assists: a line of Table 3.

    Attributes:
        estimate: the complete result.
        predictions: every tied mapping.
        correct: how many of them are right.
    """

    estimate: MappingEstimate
    predictions: int
    correct: int


def _scene(role: Role, table: Mapping[str, ObjectNumbers]) -> Scene:
    objects = []
    for name, (kind, x, y, edges, hue) in table.items():
        affordances, properties = KNOWLEDGE[kind]
        width, depth, height = (edge / 100.0 for edge in edges)
        objects.append(
            SceneObject(
                name,
                (x, y, height / 2.0),
                (width, depth, height),
                hue=hue,
                object_class=kind,
                affordances=affordances,
                properties=properties,
            )
        )
    relations = spatial_relations(objects)
    return Scene(role, tuple(replace(o, relations=r) for o, r in zip(objects, relations, strict=True)))


def _task(source: Scene) -> Task:
    return Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(source.ids)))


def dish_sorting() -> CaseStudy:
    """Two utensils, two cups and three bowls, sorted by what they afford: 2! 2! 3! right mappings."""
    source, target = _scene(Role.SOURCE, DISHES_SOURCE), _scene(Role.TARGET, DISHES_TARGET)
    by_class = {kind: frozenset(o.object_id for o in target.objects if o.object_class == kind) for kind in KNOWLEDGE}
    solution = {o.object_id: by_class[o.object_class] for o in source.objects}
    order = ("cereal_bowl", "salad_bowl", "dip_bowl", "mug", "glass", "spoon", "ladle")
    return CaseStudy("dish sorting", _task(source), target, solution, order)


def assembly() -> CaseStudy:
    """Six blocks that go by hue and relative size: one right mapping."""
    source, target = _scene(Role.SOURCE, ASSEMBLY_SOURCE), _scene(Role.TARGET, ASSEMBLY_TARGET)
    solution = {s: frozenset({t}) for s, t in zip(source.ids, target.ids, strict=True)}
    return CaseStudy("assembly", _task(source), target, solution, source.ids)


def predictions(study: CaseStudy, strategy: str) -> list[Predicted]:
    """What the strategy predicts after 0, 1, ... assists."""
    config = MappingConfig(strategy=strategy, feature_space=FeatureSpace.ALL, max_alternatives=100)
    lines = []
    for count in range(len(study.order) + 1):
        estimate = infer(study.task, study.target, study.assists(count), config)
        tied = [estimate.mapping, *estimate.alternatives][: estimate.ties]
        lines.append(Predicted(estimate, estimate.ties, sum(study.solved_by(m.as_dict) for m in tied)))
    return lines


def case_studies() -> Sequence[CaseStudy]:
    """Both of them."""
    return dish_sorting(), assembly()
