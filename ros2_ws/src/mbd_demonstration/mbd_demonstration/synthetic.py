"""Generated demonstrations with known steps: a hand-guided tool, a gripper, and what recording them does to both.

Everything is drawn from the ``rng`` given: the same generator state gives the same demonstration.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene, SceneObject
from mbd_model.task import StepKind
from numpy.typing import NDArray

from mbd_demonstration.finger_joint import Polarity
from mbd_demonstration.gripper import GripperAction, GripperEvent

Point = tuple[float, float, float]
SPACING = 0.14  # [m] between the places objects stand at: a hand's fingers fit between the largest
TRAVEL_HEIGHT = 0.35  # [m] above the robot's base: over every stack


@dataclasses.dataclass(frozen=True)
class Move:
    """Pick ``object_id`` and place it onto another object, or (``onto`` empty) on the table at ``place`` (x, y) [m]."""

    object_id: str
    onto: str = ""
    place: tuple[float, float] = (0.0, 0.0)


@dataclasses.dataclass(frozen=True)
class Sensing:
    """How the demonstration is sensed.

    Attributes:
        rate: [Hz] of tool poses and of joint states.
        position_std: noise of each coordinate of the tool [m].
        joint_std: noise of the finger joint, share of its travel.
        dropout: share of samples lost.
        glitch: share of finger samples that read a wild value.
        shuffle: [s] by which stamps of neighbours arrive out of order.
        polarity: what a larger joint position means.
        travel: joint positions between open and closed [joint unit].
        half_closings: closings to half way, and back, on the way between objects.
        half_rest: [s] each of those rests half way.
        ramp: [s] the fingers take to close or open.
        shallowest: share of its travel to which the hand closes on the widest objects.
        drift: share of the travel by which the joint's zero wanders over the recording.
        quantum: share of the travel that the joint is read in steps of; 0: exactly.
    """

    rate: float = 30.0
    position_std: float = 0.001
    joint_std: float = 0.005
    dropout: float = 0.0
    glitch: float = 0.0
    shuffle: float = 0.0
    polarity: Polarity = Polarity.LARGER_CLOSED
    travel: float = 1.3
    half_closings: int = 0
    half_rest: float = 0.0
    ramp: float = 0.5
    shallowest: float = 0.8
    drift: float = 0.0
    quantum: float = 0.0


@dataclasses.dataclass(frozen=True)
class Demonstration:
    """A recording as it arrived, and what it truly shows.

    Attributes:
        scene: the source scene.
        stamps, positions, quaternions: tool samples in order of arrival: (n,) [s], (n, 3) [m], (n, 4) x, y, z, w.
        joint: (n,) finger joint positions of the same stamps.
        events: true gripper events: a closing as the fingers come to rest on the object, an opening as they leave it.
        steps: true (kind, primary object) of each step.
        after: the objects where the demonstration truly left them.
    """

    scene: Scene
    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    quaternions: NDArray[np.float64]
    joint: NDArray[np.float64]
    events: tuple[GripperEvent, ...]
    steps: tuple[tuple[StepKind, str], ...]
    after: tuple[SceneObject, ...]


def random_scene(rng: np.random.Generator, n: int) -> Scene:
    """``n`` boxes of 4 to 8 cm (at most 12) on a grid of places in front of the robot.

    Raises:
        MbdError: more objects than places.
    """
    if not 1 <= n <= 12:
        raise MbdError(f"{n} objects asked for; there are 12 places on the table, and at least one is needed")
    objects = []
    for k, place in enumerate(rng.permutation(20)[:n]):
        width, depth, height = rng.uniform((0.04, 0.04, 0.04), (0.08, 0.08, 0.12))
        x, y = _grid(int(place))
        objects.append(
            SceneObject(
                f"s{k + 1}",
                (x, y, float(height) / 2),
                (float(width), float(depth), float(height)),
                yaw=float(rng.uniform(-math.pi / 4, math.pi / 4)),
            )
        )
    return Scene(Role.SOURCE, tuple(objects))


def random_moves(rng: np.random.Generator, scene: Scene, n: int) -> tuple[Move, ...]:
    """``n`` moves of objects nothing rests on, onto such objects or to free places; stacks are at most three high."""
    below: dict[str, str] = {}
    free = [p for p in map(_grid, range(20)) if all(math.dist(p, o.centroid[:2]) > 0.01 for o in scene.objects)]
    moves = []
    for _ in range(n):
        clear = [i for i in scene.ids if i not in below.values()]
        picked = str(rng.choice(clear))
        receivers = [i for i in clear if i != picked and _level(i, below) < 2]
        below.pop(picked, None)
        if receivers and (not free or rng.random() < 0.6):
            below[picked] = str(rng.choice(receivers))
            moves.append(Move(picked, onto=below[picked]))
        else:
            moves.append(Move(picked, place=free.pop(int(rng.integers(len(free))))))
    return tuple(moves)


def demonstrate(
    scene: Scene, moves: tuple[Move, ...], recorder: Sensing, rng: np.random.Generator, begin: float = 0.0
) -> Demonstration:
    """A teacher guides the tool through the moves from ``begin`` [s] on, and a recorder listens."""
    objects = {o.object_id: o for o in scene.objects}
    knots: list[tuple[float, Point]] = [(begin, (0.3, 0.0, TRAVEL_HEIGHT))]
    events: list[GripperEvent] = []
    steps: list[tuple[StepKind, str]] = []
    dwell = recorder.ramp + 4.0 / recorder.rate + 0.3

    def go(point: Point, speed: float = 0.25) -> None:
        at, here = knots[-1]
        knots.append((at + max(math.dist(here, point) / speed, 2.0 / recorder.rate, 0.3), point))

    def act(point: Point, action: GripperAction) -> None:
        go((point[0], point[1], TRAVEL_HEIGHT))
        go(point)
        at = knots[-1][0]
        after = recorder.ramp / 2 if action is GripperAction.CLOSE else -recorder.ramp / 2
        events.append(GripperEvent(at + dwell / 2 + after, action))
        knots.append((at + dwell, point))
        go((point[0], point[1], TRAVEL_HEIGHT))

    for move in moves:
        held = objects[move.object_id]
        x, y, z = held.centroid
        grasp = held.size[2] / 2 - 0.01  # the tool point just below the top, where fingers hold a thing
        act((x, y, z + grasp), GripperAction.CLOSE)
        steps.append((StepKind.PICK, move.object_id))
        if move.onto:
            lower = objects[move.onto]
            x, y = lower.centroid[0] + rng.uniform(-0.01, 0.01), lower.centroid[1] + rng.uniform(-0.01, 0.01)
            z = lower.centroid[2] + lower.size[2] / 2 + held.size[2] / 2 + 0.003
        else:
            (x, y), z = move.place, held.size[2] / 2
        objects[move.object_id] = dataclasses.replace(held, centroid=(float(x), float(y), float(z)))
        act((float(x), float(y), float(z) + grasp), GripperAction.OPEN)
        steps.append((StepKind.PLACE, move.onto or move.object_id))
    knots.append((knots[-1][0] + 1.0, knots[-1][1]))
    stamps, positions, joint = _record(knots, tuple(events), recorder, rng)
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (stamps.size, 1))  # the hand points down
    after = tuple(objects.values())
    return Demonstration(scene, stamps, positions, quaternions, joint, tuple(events), tuple(steps), after)


def _record(
    knots: list[tuple[float, Point]], events: tuple[GripperEvent, ...], recorder: Sensing, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """What arrives of a path through ``knots`` (time [s], point [m]): stamps, positions, finger joint."""
    t = np.arange(knots[0][0], knots[-1][0], 1.0 / recorder.rate)
    times = np.array([at for at, _ in knots])
    points = np.array([point for _, point in knots])
    leg = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(knots) - 2)
    share = (t - times[leg]) / (times[leg + 1] - times[leg])
    smooth = share**3 * (10 - 15 * share + 6 * share**2)  # least jerk: how a hand moves between points
    positions = points[leg] + smooth[:, None] * (points[leg + 1] - points[leg])
    positions += rng.normal(0.0, recorder.position_std, positions.shape)
    closure = _closure(t, events, recorder, rng)
    joint = recorder.travel * (closure if recorder.polarity is Polarity.LARGER_CLOSED else 1.0 - closure)
    kept = rng.random(t.size) >= recorder.dropout
    arrival = np.argsort((t + rng.uniform(0.0, recorder.shuffle, t.size))[kept], kind="stable")
    return t[kept][arrival], positions[kept][arrival], joint[kept][arrival]


def _closure(
    t: NDArray[np.float64], events: tuple[GripperEvent, ...], recorder: Sensing, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Sensed closure (n,), 0 open: each closing stops at its object's width."""
    at, level = [t[0]], [0.0]
    for event in events:
        after = rng.uniform(recorder.shallowest, 1.0) if event.action is GripperAction.CLOSE else 0.0
        begin = event.stamp - (recorder.ramp if event.action is GripperAction.CLOSE else 0.0)
        at += [begin, begin + recorder.ramp]
        level += [level[-1], after]
    closure: NDArray[np.float64] = np.interp(t, at, level)
    opened = [k for k, e in enumerate(events) if e.action is GripperAction.OPEN]
    for k in opened[: recorder.half_closings]:
        begin = events[k].stamp + 1.5 * recorder.ramp
        end = events[k + 1].stamp - 1.5 * recorder.ramp if k + 1 < len(events) else math.inf
        rest = max(min(recorder.half_rest, end - begin - 2 * recorder.ramp), 0.0)
        half = begin + np.array([0.0, recorder.ramp, recorder.ramp + rest, 2 * recorder.ramp + rest])
        closure = np.maximum(closure, np.interp(t, half, [0.0, 0.5, 0.5, 0.0], left=0.0, right=0.0))
    closure = closure + recorder.drift * (t - t[0]) / (t[-1] - t[0]) + rng.normal(0.0, recorder.joint_std, t.size)
    if recorder.quantum:
        closure = np.round(closure / recorder.quantum) * recorder.quantum
    wild = rng.random(t.size) < recorder.glitch
    wild[1:] &= ~wild[:-1]  # single samples: two in a row would be a signal
    return np.where(wild, rng.uniform(-1.0, 2.0, t.size), closure)


def _grid(place: int) -> tuple[float, float]:
    return 0.35 + SPACING * (place // 5), SPACING * (place % 5 - 2)


def _level(object_id: str, below: dict[str, str]) -> int:
    return 1 + _level(below[object_id], below) if object_id in below else 0
