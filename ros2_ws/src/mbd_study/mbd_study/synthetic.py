"""Session bags with known truth, made without a simulation: cups sorted into bowls by hue.

What each node would have published, from a seed: scenes with noise, a task of alternating picks and places, assists in
task order, and the mapping's own estimates. The colour pictures show discs where the objects stand.
"""

from __future__ import annotations

import array
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_model import conversions
from mbd_model.assists import Assist, AssistKind
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.session import Phase, Prompt, PromptKind, SessionState
from mbd_model.spatial import spatial_relations
from mbd_model.task import StepKind, Task, TaskStep
from mbd_msgs.msg import AcceptableTargets, CellTruth, ObjectTruth
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image

from mbd_study.bag_writer import BagWriter
from mbd_study.message_writer import SENSOR, MessageWriter
from mbd_study.projection import CameraView
from mbd_study.session_facts import package_versions, parameter_facts

HUES = {"red": 2.0, "green": 122.0, "blue": 222.0}
# Straight above the table's middle, the top of the picture away from the robot.
CAMERA_POSITION = (0.45, 0.0, 0.95)
CAMERA_ORIENTATION = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
CAMERA = CameraView.from_parameters((540.0, 540.0, 319.5, 239.5), (640, 480), CAMERA_POSITION, CAMERA_ORIENTATION)
IMAGE_TOPIC = "/camera/color/image_raw"


@dataclass(frozen=True)
class SyntheticSession:
    """What is true of a session written by `write_session`.

    Attributes:
        task: demonstrated, with its source scene.
        target: scene.
        assists: all given, oldest first.
        num_estimates: in the bag.
        solution: right target ids by source id.
    """

    task: Task
    target: Scene
    assists: tuple[Assist, ...]
    num_estimates: int
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
        # The order in which perception lists objects says nothing about what they are.
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


def truth_message(shown: Scene, answers: dict[str, frozenset[str]], seed: int) -> CellTruth:
    """The cell's truth of a scene: the same objects under names of their own, ``true_<id>``."""
    return CellTruth(
        header=conversions.header(shown.stamp - 0.5, shown.frame_id),
        task="sorting",
        role=conversions.ROLE_TO_CODE[shown.role],
        seed=seed,
        objects=[
            ObjectTruth(
                name=f"true_{o.object_id}",
                pose=Pose(position=Point(x=o.centroid[0], y=o.centroid[1], z=o.centroid[2])),
                size=Vector3(x=o.size[1], y=o.size[0], z=o.size[2]),
                has_hue=True,
                hue=o.hue,
            )
            for o in shown.objects
        ],
        solution=[
            AcceptableTargets(source_name=f"true_{s}", target_names=sorted(f"true_{t}" for t in targets))
            for s, targets in answers.items()
        ],
    )


def solution(source: Scene, target: Scene) -> dict[str, frozenset[str]]:
    """Targets of the same colour, by source id."""
    return {
        s.object_id: frozenset(t.object_id for t in target.objects if t.color_name == s.color_name)
        for s in source.objects
    }


def camera_messages(shown: Scene) -> tuple[CameraInfo, Image]:
    """What the camera published when the scene was observed."""
    header = conversions.header(shown.stamp, "camera_color_optical_frame")
    fx, fy, cx, cy = CAMERA.intrinsics
    width, height = CAMERA.size
    info = CameraInfo(header=header, width=width, height=height)
    info.k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    image = Image(header=header, width=width, height=height, encoding="rgb8", step=3 * width)
    image.data = array.array("B", picture(shown).tobytes())
    return info, image


def write_session(
    folder: Path, rng: np.random.Generator, *, config: MappingConfig | None = None, num_assists: int = 3, seed: int = 0
) -> SyntheticSession:
    """Write one whole session to a new bag.

    Args:
        folder: the bag.
        rng: of the scenes.
        config: of the mapping.
        num_assists: given in task order, 0..6.
        seed: noted in the bag.
    """
    config = config or MappingConfig()
    source, target = scene(Role.SOURCE, 11.0, rng), scene(Role.TARGET, 40.0, rng)
    shown_task = task(source, 30.0)
    answers = solution(source, target)
    with BagWriter(folder) as bag:
        parameters = {"sigma": config.sigma, "threshold": config.threshold, "strategy": config.strategy}
        camera = {"camera_position": list(CAMERA_POSITION), "camera_orientation": list(CAMERA_ORIENTATION)}
        bag.add_facts({"session": folder.name, "task": "sorting", "seed": str(seed), **package_versions()})
        bag.add_facts(parameter_facts("/mapping", parameters) | parameter_facts("/perception", camera))
        say = _Narrator(MessageWriter(bag), folder.name)
        for shown, phase, topic in (
            (source, Phase.OBSERVE_SOURCE, "/perception/source_scene"),
            (target, Phase.OBSERVE_TARGET, "/perception/target_scene"),
        ):
            say.at(shown.stamp - 0.5, "/cell/truth", truth_message(shown, answers, seed))
            say.phase(shown.stamp - 0.4, phase)
            for message, name in zip(camera_messages(shown), ("/camera/color/camera_info", IMAGE_TOPIC), strict=True):
                say.at(shown.stamp, name, message, stream=True)
            say.at(shown.stamp + 0.1, topic, conversions.scene_to_msg(shown))
            if shown is source:
                say.phase(shown.stamp + 0.2, Phase.DEMONSTRATE)
                say.at(shown_task.stamp, "/demonstration/task", conversions.task_to_msg(shown_task))
        say.phase(target.stamp + 0.2, Phase.ASSIST)
        given = _ask(say, shown_task, target, answers, config=config, num_assists=num_assists)
        say.phase(60.0, Phase.DONE)
    return SyntheticSession(shown_task, target, given, num_assists + 1, answers)


class _Narrator:
    """Writes messages at times in seconds."""

    def __init__(self, writer: MessageWriter, session: str) -> None:
        self._writer = writer
        self.session = session

    def at(self, seconds: float, topic: str, message: Any, *, stream: bool = False) -> None:
        log_time = round(seconds * 1e9)
        if stream:
            self._writer.write(topic, message, log_time, SENSOR)
        else:
            self._writer.write(topic, message, log_time)

    def phase(self, seconds: float, phase: Phase) -> None:
        self.at(seconds, "/interaction/state", conversions.state_to_msg(SessionState(self.session, phase), seconds))


def _ask(
    say: _Narrator,
    shown: Task,
    target: Scene,
    answers: dict[str, frozenset[str]],
    *,
    config: MappingConfig,
    num_assists: int,
) -> tuple[Assist, ...]:
    """The dialogue: an estimate, then for each object in task order a question, an assist and an estimate."""
    given: tuple[Assist, ...] = ()
    stamps = tuple(conversions.time_to_msg(t) for t in (shown.stamp, target.stamp))
    for count, wanted in enumerate((None, *shown.used_objects[:num_assists])):
        seconds = target.stamp + 0.3 + 2.0 * count
        if wanted is not None:
            step = next(s for s in shown.steps if s.primary_object == wanted)
            pick = step.kind is StepKind.PICK
            text = "What do I use now?" if pick else "Where do I go next?"
            kind = PromptKind.WHAT_DO_I_USE if pick else PromptKind.WHERE_DO_I_GO
            asked = Prompt(kind, text, step.index, wanted)
            say.at(seconds, "/interaction/prompt", conversions.prompt_to_msg(asked, seconds))
            free = _free_targets(answers[wanted], given)
            how = AssistKind.HANDED if pick else AssistKind.POINTED
            given = (*given, Assist(wanted, free[0], step.index, how, seconds + 1.0))
        assists_stamp = conversions.time_to_msg(seconds + 1.0)
        say.at(seconds + 1.0, "/interaction/assists", conversions.assists_to_msg(given, seconds + 1.0, say.session))
        estimate = conversions.estimate_to_msg(
            infer(shown, target, given, config),
            session=say.session,
            threshold=config.threshold,
            stamps=(stamps[0], stamps[1], assists_stamp),
        )
        say.at(seconds + 1.1, "/mapping/estimate", estimate)
    return given


def _free_targets(targets: frozenset[str], given: Sequence[Assist]) -> list[str]:
    return sorted(targets - {a.target_id for a in given})
