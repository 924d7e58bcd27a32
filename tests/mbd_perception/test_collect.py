"""Which frames an observation uses."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from mbd_perception.frames.collect import FrameCollector, PairBuffer, earliest_stamp


@given(st.lists(st.integers(0, 40), unique=True), st.lists(st.integers(0, 40), unique=True))
def test_pairs(colors: list[int], depths: list[int]) -> None:
    """A pair is always of one time, no image is used twice, and in order no pair is missed."""
    events = sorted([(s, "color") for s in colors] + [(s, "depth") for s in depths])
    buffer: PairBuffer[int, int] = PairBuffer(tolerance=0.2)
    pairs = []
    for stamp, kind in events:
        pair = buffer.add_color(stamp, stamp) if kind == "color" else buffer.add_depth(stamp, stamp)
        if pair is not None:
            pairs.append(pair)
    assert pairs == [(s, s) for s in sorted(set(colors) & set(depths))]


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 1000))))
def test_never_grows(events: list[tuple[bool, int]]) -> None:
    """However streams run apart, at most ``size`` images wait on each side."""
    buffer: PairBuffer[int, int] = PairBuffer(tolerance=0.1, size=3)
    for is_color, stamp in events:
        _ = buffer.add_color(stamp, stamp) if is_color else buffer.add_depth(stamp, stamp)
        assert max(buffer.waiting) <= 3


@given(st.lists(st.floats(0, 10)), st.floats(0, 10), st.integers(1, 5))
def test_only_later_frames(stamps: list[float], after: float, wanted: int) -> None:
    """Only frames stamped after the request count, the first ``wanted`` of them."""
    collector: FrameCollector[float] = FrameCollector(after, wanted)
    complete = [collector.offer(s, s) for s in stamps]
    later = [s for s in stamps if s > after]
    assert collector.frames == later[:wanted]
    assert any(complete) == (len(later) >= wanted)


@given(st.lists(st.integers(1, 40), min_size=4, max_size=20), st.integers(20, 50), st.integers(-50, 50), st.data())
def test_apart(gaps: list[int], tolerance: int, shift: int, data: st.DataObject) -> None:
    """Streams [ms] that run apart by a constant: every pair is within tolerance, and its two are nearest to each other.

    Whichever image of a moment comes first.
    """
    colors = [sum(gaps[: i + 1]) + 60 * i for i in range(len(gaps))]
    depths = [c + shift for c in colors]
    moments = list(zip(colors, depths, strict=True))
    events = [[(c, "color"), (d, "depth")] for c, d in moments]
    buffer: PairBuffer[int, int] = PairBuffer(tolerance=tolerance / 1000)
    pairs = []
    for moment in events:
        for stamp, kind in data.draw(st.permutations(moment)):
            add = buffer.add_color if kind == "color" else buffer.add_depth
            pair = add(stamp / 1000, stamp)
            if pair is not None:
                pairs.append(pair)
    for color, depth in pairs:
        assert abs(color - depth) <= tolerance
    if abs(shift) <= min(tolerance, 30):  # less than half the time between two moments: no doubt which belong together
        assert pairs in (moments, moments[:-1])  # the last may wait for what comes next


def test_nearer_comes_late() -> None:
    """After a lost colour image, depth is not paired with the next one for good: the nearer depth is waited for."""
    buffer: PairBuffer[str, str] = PairBuffer(tolerance=0.05)
    assert buffer.add_depth(0.033, "d1") is None
    assert buffer.add_color(0.066, "c2") is None
    assert buffer.add_depth(0.066, "d2") == ("c2", "d2")
    assert buffer.waiting == (0, 0)


def test_other_kind() -> None:
    """When the camera changes, what came before is dropped, and the frames wanted are of one kind."""
    collector: FrameCollector[str] = FrameCollector(0.0, 2)
    assert not collector.offer(1.0, "small", kind=320)
    assert not collector.offer(2.0, "large", kind=640)
    assert collector.offer(3.0, "large too", kind=640)
    assert collector.frames == ["large", "large too"]


def test_clock_set_back() -> None:
    """One stamp from the far future does not hold up an observation: what follows it is later by its own clock."""
    collector: FrameCollector[str] = FrameCollector(2.0e9, 1)
    assert not collector.offer(100.0, "first")
    assert collector.offer(100.1, "second")


def test_clocks() -> None:
    """The node's clock decides when it is the camera's; otherwise the newest frame does."""
    assert earliest_stamp(now=100.0, newest=99.9) == 100.0
    assert earliest_stamp(now=100.0, newest=None) == 100.0
    assert earliest_stamp(now=1.7e9, newest=12.0) == 12.0
