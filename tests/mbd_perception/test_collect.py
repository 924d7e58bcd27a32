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


def test_clocks() -> None:
    """The node's clock decides when it is the camera's; otherwise the newest frame does."""
    assert earliest_stamp(now=100.0, newest=99.9) == 100.0
    assert earliest_stamp(now=100.0, newest=None) == 100.0
    assert earliest_stamp(now=1.7e9, newest=12.0) == 12.0
