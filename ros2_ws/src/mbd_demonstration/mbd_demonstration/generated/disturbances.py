"""What robots, their clocks and people make of a demonstration: each changes what arrives of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from mbd_demonstration.generated.arrivals import DATE, Arrivals, JointStream

Disturbance = Callable[[Arrivals, np.random.Generator], Arrivals]


def _with_fingers(came: Arrivals, change: Callable[[np.ndarray], np.ndarray]) -> Arrivals:
    stream = came.joints[0]
    positions = stream.positions.copy()
    positions[:, -3:] = change(positions[:, -3:])
    return dataclasses.replace(came, joints=(dataclasses.replace(stream, positions=positions), *came.joints[1:]))


def stuck_finger(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """One finger of three stays where it is."""
    level = rng.uniform(0.0, 1.3)
    return _with_fingers(came, lambda f: np.column_stack([f[:, 0], np.full(len(f), level), f[:, 2]]))


def lost_finger(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """One finger of three is NaN from some time on."""
    lost = np.arange(len(came.joints[0].stamps)) >= rng.integers(0, len(came.joints[0].stamps))
    return _with_fingers(came, lambda f: np.column_stack([f[:, 0], np.where(lost, np.nan, f[:, 1]), f[:, 2]]))


def mimic_joint(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """One finger moves the other way, and half as far."""
    return _with_fingers(came, lambda f: np.column_stack([f[:, 0], -0.5 * f[:, 1], f[:, 2]]))


def split_joint_states(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """Arm and hand are published apart, the hand's names with a prefix, at another rate."""
    s = came.joints[0]
    arm = JointStream(s.names[:-3], s.stamps, s.arrivals, s.positions[:, :-3])
    every = slice(None, None, 2)
    names = tuple(f"j2n6s300_{name}" for name in s.names[-3:])
    hand = JointStream(names, s.stamps[every] + 0.004, s.arrivals[every] + 0.004, s.positions[every, -3:])
    return dataclasses.replace(came, joints=(arm, hand))


def other_arm(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """A second arm of seven joints with a hand of two fingers rests on the same topic."""
    s = came.joints[0]
    names = (*(f"left_panda_joint{k}" for k in range(7)), "left_panda_finger_joint1", "left_panda_finger_joint2")
    positions = rng.normal(0.0, 0.0005, (s.stamps.size, 9)) + 0.04
    return dataclasses.replace(came, joints=(s, JointStream(names, s.stamps + 0.003, s.arrivals + 0.003, positions)))


def _restamped(came: Arrivals, after: float, change: Callable[[np.ndarray], np.ndarray]) -> Arrivals:
    """Stamps of what arrives after a time [s] changed, the tool's and the hand's."""

    def restamped(stamps: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.where(at >= after, change(stamps), stamps)

    joints = tuple(dataclasses.replace(s, stamps=restamped(s.stamps, s.arrivals)) for s in came.joints)
    return dataclasses.replace(came, stamps=restamped(came.stamps, came.arrivals), joints=joints)


def boot_time_after_a_restart(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """The driver starts again and stamps since boot."""
    after = rng.uniform(0.2, 0.8) * came.arrivals[-1]
    return _restamped(came, after, lambda stamps: stamps - DATE + 55.0)


def simulated_time_jumps_back(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """The simulation is set back by seconds, for words too."""
    after, by = rng.uniform(0.2, 0.8) * came.arrivals[-1], rng.uniform(5.0, 60.0)
    words = tuple(
        dataclasses.replace(word, stamp=word.stamp - by) if at >= after else word
        for word, at in zip(came.words, came.said, strict=True)
    )
    return dataclasses.replace(_restamped(came, after, lambda stamps: stamps - by), words=words)


def zero_stamps(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """One sample in ten has no stamp."""

    def some(stamps: np.ndarray) -> np.ndarray:
        return np.where(rng.random(stamps.size) < 0.1, 0.0, stamps)

    return _restamped(came, 0.0, some)


def held_values(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """For two seconds the driver repeats the last pose of the tool."""
    begin = rng.uniform(0.1, 0.8) * came.arrivals[-1]
    held = (came.arrivals >= begin) & (came.arrivals < begin + 2.0)
    positions = came.positions.copy()
    positions[held] = positions[int(np.flatnonzero(held)[0])]
    return dataclasses.replace(came, positions=positions)


def skewed_gripper(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """The gripper's clock is seconds off the tool's."""
    by = float(rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 5.0))
    joints = tuple(dataclasses.replace(s, stamps=s.stamps + by) for s in came.joints)
    return dataclasses.replace(came, joints=joints)


def words_late_or_early(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """Each word up to two seconds late or early, in their order."""
    stamps = np.array([w.stamp for w in came.words])
    said = np.maximum.accumulate(stamps + rng.uniform(-2.0, 2.0, stamps.size))
    words = tuple(dataclasses.replace(w, stamp=float(at)) for w, at in zip(came.words, said, strict=True))
    return dataclasses.replace(came, words=words, said=said - DATE)


def words_without_fingers(came: Arrivals, rng: np.random.Generator) -> Arrivals:
    """The same, on a robot that sends no joint states."""
    return dataclasses.replace(words_late_or_early(came, rng), joints=())


DISTURBANCES: tuple[Disturbance, ...] = (
    stuck_finger,
    lost_finger,
    mimic_joint,
    split_joint_states,
    other_arm,
    boot_time_after_a_restart,
    simulated_time_jumps_back,
    zero_stamps,
    held_values,
    skewed_gripper,
    words_late_or_early,
    words_without_fingers,
)
