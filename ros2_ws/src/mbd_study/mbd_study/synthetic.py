"""Sessions with known truth, made without a simulation: cups sorted into bowls by hue.

What each node would have published, from a seed: scenes with noise, a task of alternating picks and places, assists in
task order, and the mapping's own estimates. The colour pictures show discs where the objects stand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from mbd_bag.session.recorded_session import Recorded, RecordedSession, TrueObject, Truth
from mbd_bag.session.session_facts import package_versions, parameter_facts
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_model.assists import Assist, AssistKind
from mbd_model.camera.view import CameraView
from mbd_model.estimate import EstimateInputs
from mbd_model.geometry.spatial import spatial_relations
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.task import StepKind, Task, TaskStep
from mbd_model.times import to_nanoseconds, to_seconds
from numpy.typing import NDArray

HUES = {"red": 2.0, "green": 122.0, "blue": 222.0}
# Straight above the table's middle, the top of the picture away from the robot.
CAMERA_POSITION = (0.45, 0.0, 0.95)
CAMERA_ORIENTATION = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
CAMERA = CameraView.from_parameters((540.0, 540.0, 319.5, 239.5), (640, 480), CAMERA_POSITION, CAMERA_ORIENTATION)


@dataclass(frozen=True)
class SyntheticSession:
    """A session and what is true of it.

    Attributes:
        recorded: what its bag would hold.
        pictures: (480, 640, 3) RGB of both observations.
        solution: right target ids by source id.
    """

    recorded: RecordedSession
    pictures: tuple[Recorded[NDArray[np.uint8]], ...]
    solution: dict[str, frozenset[str]]


def scene(role: Role, stamp: float, rng: np.random.Generator) -> Scene:
    """Six objects, two of each colour, on a jittered 3 x 2 grid: source cups, target bowls."""
    places = [(x, y) for x in (0.36, 0.54) for y in (0.22, 0.0, -0.22)]
    order = rng.permutation(6)
    prefix = role.value[0]
    objects = []
    for number, (color, large) in enumerate((c, big) for big in (False, True) for c in HUES):
        x, y = np.array(places[order[number]]) + rng.uniform(-0.03, 0.03, 2)
        side = (0.06 if role is Role.SOURCE else 0.11) + 0.02 * large + rng.uniform(-0.002, 0.002)
        hue = HUES[color] + (6.0 if role is Role.TARGET else 0.0) + rng.uniform(-2.0, 2.0)
        objects.append(
            SceneObject(
                object_id=f"{prefix}{number + 1}",
                centroid=(float(x), float(y), 0.5 * side),
                size=(side, side, 1.1 * side if role is Role.SOURCE else 0.5 * side),
                hue=hue % 360.0,
                saturation=0.8,
                color_name=color,
                object_class="cup" if role is Role.SOURCE else "bowl",
                class_score=0.9,
                affordances=frozenset({"pourable", "stackable"}),
                properties=frozenset({"upright"}),
            )
        )
    if role is Role.TARGET:
        # The order in which perception lists objects states nothing about what they are.
        objects = [replace(objects[k], object_id=f"t{i + 1}") for i, k in enumerate(rng.permutation(6))]
    relations = spatial_relations(objects)
    return Scene(role, tuple(replace(o, relations=r) for o, r in zip(objects, relations, strict=True)), stamp)


def task(source: Scene, stamp: float) -> Task:
    """Each small cup into the large cup of its colour: pick, place, pick, place, ..."""
    steps: list[TaskStep] = []
    for number, small in enumerate(source.objects[:3]):
        large = source.objects[3 + number]
        for kind, thing in ((StepKind.PICK, small), (StepKind.PLACE, large)):
            index = len(steps)
            steps.append(
                TaskStep(
                    index,
                    kind,
                    thing.object_id,
                    distance=0.05,
                    start=source.stamp + 2.0 * index,
                    end=source.stamp + 2.0 * index + 1.5,
                    tool_position=thing.centroid,
                )
            )
    return Task(source, tuple(steps), stamp=stamp)


def picture(shown: Scene) -> NDArray[np.uint8]:
    """(480, 640, 3) RGB: a wooden table with a disc for each object."""
    image = np.full((480, 640, 3), (188, 168, 140), np.uint8)
    image[::24] -= 10
    for thing in shown.objects:
        (u, v), (u2, _) = CAMERA.project(np.array([thing.centroid, np.add(thing.centroid, (0, -thing.size[0] / 2, 0))]))
        hsv = np.array([[[int((thing.hue or 0.0) / 2), 200, 210]]], np.uint8)
        color = tuple(int(c) for c in cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0])
        cv2.circle(image, (int(u), int(v)), max(3, int(abs(u2 - u))), color, -1, cv2.LINE_AA)
        cv2.circle(image, (int(u), int(v)), max(2, int(0.7 * abs(u2 - u))), tuple(int(0.8 * c) for c in color), -1)
    return image


def solution(source: Scene, target: Scene) -> dict[str, frozenset[str]]:
    """Targets of the same colour, by source id."""
    return {
        s.object_id: frozenset(t.object_id for t in target.objects if t.color_name == s.color_name)
        for s in source.objects
    }


def truth(shown: Scene, answers: dict[str, frozenset[str]], seed: int = 0) -> Truth:
    """The cell's truth of a scene: the same objects under names of their own, ``true_<id>``."""
    return Truth(
        task="sorting",
        role=shown.role,
        seed=seed,
        objects=tuple(TrueObject(f"true_{o.object_id}", o.centroid, o.size, o.hue) for o in shown.objects),
        solution={f"true_{s}": frozenset(f"true_{t}" for t in targets) for s, targets in answers.items()},
    )


def session(
    name: str, rng: np.random.Generator, *, config: MappingConfig | None = None, num_assists: int = 3
) -> SyntheticSession:
    """One complete session of a minute.

    Args:
        name: of the session.
        rng: of the scenes.
        config: of the mapping.
        num_assists: given in task order, 0..6.
    """
    config = config or MappingConfig()
    source, target = scene(Role.SOURCE, 11.0, rng), scene(Role.TARGET, 40.0, rng)
    shown = task(source, 30.0)
    answers = solution(source, target)
    parameters = {"sigma": config.sigma, "threshold": config.stop_at, "strategy": config.strategy}
    camera = {"camera_position": list(CAMERA_POSITION), "camera_orientation": list(CAMERA_ORIENTATION)}
    phases = {
        10.6: Phase.OBSERVE_SOURCE,
        11.2: Phase.DEMONSTRATE,
        39.6: Phase.OBSERVE_TARGET,
        40.2: Phase.ASSIST,
        60.0: Phase.DONE,
    }
    recorded = RecordedSession(
        name=name,
        facts={"session": name, "task": "sorting", "seed": "0"}
        | package_versions()
        | parameter_facts("/mapping", parameters)
        | parameter_facts("/perception", camera),
        source_scenes=(_recorded(source, source.stamp, 0.1),),
        target_scenes=(_recorded(target, target.stamp, 0.1),),
        tasks=(_recorded(shown, shown.stamp),),
        states=tuple(_recorded(SessionState(name, phase), seconds) for seconds, phase in phases.items()),
        truths=tuple(_recorded(truth(s, answers), s.stamp - 0.5) for s in (source, target)),
        **_dialogue(shown, target, answers, config=config, num_assists=num_assists),
    )
    return SyntheticSession(recorded, tuple(_recorded(picture(s), s.stamp) for s in (source, target)), answers)


def _recorded(value: Any, seconds: float, delay: float = 0.0) -> Recorded[Any]:
    return Recorded(value, to_nanoseconds(seconds), to_nanoseconds(seconds + delay))


def _dialogue(
    shown: Task, target: Scene, answers: dict[str, frozenset[str]], *, config: MappingConfig, num_assists: int
) -> dict[str, Any]:
    """Prompts, assists and estimates: first with no assist, then after one for each object in task order."""
    given: tuple[Assist, ...] = ()
    prompts, assists, estimates = [], [_recorded(given, target.stamp + 1.0)], []
    for count, wanted in enumerate((None, *shown.used_objects[:num_assists])):
        seconds = target.stamp + 0.3 + 2.0 * count
        if wanted is not None:
            step = next(s for s in shown.steps if s.primary_object == wanted)
            prompts.append(_recorded(_question(step), seconds))
            free = sorted(answers[wanted] - {a.target_id for a in given})
            how = AssistKind.HANDED if step.kind is StepKind.PICK else AssistKind.POINTED
            given = (*given, Assist(wanted, free[0], step.index, how, seconds + 1.0))
            assists.append(_recorded(given, seconds + 1.0))
        estimate = infer(shown, target, given, config)
        inputs = EstimateInputs(
            task_stamp=to_nanoseconds(shown.stamp),
            scene_stamp=to_nanoseconds(target.stamp),
            assists_stamp=assists[-1].stamp,
            threshold=config.stop_at,
            confident=bool(estimate.mapping.pairs) and estimate.ties <= 1 and estimate.confidence >= config.stop_at,
        )
        estimates.append((_recorded(estimate, to_seconds(assists[-1].stamp), 0.4), inputs))
    return {"prompts": tuple(prompts), "assists": tuple(assists), "estimates": tuple(estimates)}


def _question(step: TaskStep) -> Prompt:
    if step.kind is StepKind.PICK:
        return Prompt(PromptKind.WHAT_DO_I_USE, "What do I use now?", step.index, step.primary_object)
    return Prompt(PromptKind.WHERE_DO_I_GO, "Where do I go next?", step.index, step.primary_object)
