"""What a node gets of a demonstration: tool poses, joint states and words, each with its stamp and its arrival."""

from __future__ import annotations

import dataclasses

import numpy as np
from mbd_model.objects import Scene
from numpy.typing import NDArray

from mbd_demonstration.generated.teacher import ShownActs
from mbd_demonstration.gripper import GripperEvent
from mbd_demonstration.recording import Recording

Floats = NDArray[np.float64]
DATE = 1.7e9  # [s] about when it is


@dataclasses.dataclass(frozen=True)
class JointStream:
    """Joint states of one publisher.

    Attributes:
        names: as in its messages.
        stamps, arrivals: (n,) [s]; what arrives is by a clock that never jumps.
        positions: (n, len(names)).
    """

    names: tuple[str, ...]
    stamps: Floats
    arrivals: Floats
    positions: Floats


@dataclasses.dataclass(frozen=True)
class Arrivals:
    """All that arrives.

    Attributes:
        scene: the source scene.
        stamps, arrivals: (n,) [s] of tool poses, in order of arrival.
        positions: (n, 3) [m, robot base frame].
        joints: joint states, by publisher.
        words: what was said.
        said: (k,) [s] when each arrived.
    """

    scene: Scene
    stamps: Floats
    arrivals: Floats
    positions: Floats
    joints: tuple[JointStream, ...]
    words: tuple[GripperEvent, ...]
    said: Floats

    def recording(self) -> Recording:
        """As the node collects it."""
        made = Recording(self.scene, float(self.stamps[0]), wanted=("finger_1", "finger_2", "finger_3"))
        words = list(zip(self.said, self.words, strict=True))
        for stamp, arrival, position in zip(self.stamps, self.arrivals, self.positions, strict=True):
            while words and words[0][0] <= arrival:
                made.add_event(words.pop(0)[1])
            x, y, z = position
            made.add_pose(stamp, self.scene.frame_id, (x, y, z), (1.0, 0.0, 0.0, 0.0), arrival)
        for stream in self.joints:
            for stamp, arrival, positions in zip(stream.stamps, stream.arrivals, stream.positions, strict=True):
                made.add_joints(stamp, stream.names, positions.tolist(), arrival)
        for _, word in words:
            made.add_event(word)
        return made


def arrivals(shown: ShownActs, rng: np.random.Generator, *, rate: float = 30.0, joints: int = 6) -> Arrivals:
    """What an undisturbed robot with three fingers sends of it, at ``rate`` [Hz], with the noise robots have.

    ``joints``: how many its arm has.
    """
    t = np.arange(0.0, shown.knots[-1, 0], 1.0 / rate)
    positions = np.stack([np.interp(t, shown.knots[:, 0], shown.knots[:, k]) for k in (1, 2, 3)], axis=1)
    positions += rng.normal(0.0, 0.0007, positions.shape)
    closure = np.interp(t, shown.fingers[:, 0], shown.fingers[:, 1])
    fingers = 1.3 * closure[:, None] + rng.normal(0.0, 0.004, (t.size, 3))
    arm = 0.3 * np.sin(t[:, None] * np.linspace(0.3, 0.7, joints)) + rng.normal(0.0, 0.001, (t.size, joints))
    names = (*(f"joint_{k + 1}" for k in range(joints)), "finger_1", "finger_2", "finger_3")
    stream = JointStream(names, t + DATE, t, np.column_stack([arm, fingers]))
    words = tuple(dataclasses.replace(e, stamp=e.stamp + DATE) for e in shown.events)
    said = np.array([e.stamp for e in shown.events])
    return Arrivals(shown.scene, t + DATE, t, positions, (stream,), words, said)
