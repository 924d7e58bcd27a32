"""A playback gives every message once, in order, at its time by the rate; paused, stepped, jumped and looped."""

from __future__ import annotations

from collections.abc import Iterator

from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.formats.contents import BagMessage
from mbd_bag.replay.playback import Playback

SECOND = 1_000_000_000
TIMES = st.lists(st.integers(0, 20 * SECOND), min_size=1, max_size=40).map(sorted)
RATES = st.floats(0.1, 50.0)


def playback(times: list[int], **options: object) -> Playback:
    messages = [BagMessage("/even" if k % 2 == 0 else "/odd", "", t, t, str(k).encode()) for k, t in enumerate(times)]

    def source(start: int) -> Iterator[BagMessage]:
        return (m for m in messages if m.log_time >= start)

    return Playback(source, times[0], times[-1], **options)


@given(TIMES, RATES, st.lists(st.floats(0.001, 5.0), min_size=1, max_size=10))
def test_every_message_comes_once_in_order_and_never_before_its_time(times: list[int], rate: float, waits: list[float]):
    playing = playback(times, rate=rate)
    now, received = 100.0, []
    received += playing.due(now)
    while not playing.finished:
        now += waits[len(received) % len(waits)]
        new = playing.due(now)
        received += new
        assert all(m.log_time - times[0] <= (now - 100.0) * rate * 1e9 + 1e3 for m in new)
    assert [m.data for m in received] == [str(k).encode() for k in range(len(times))]
    assert playing.rounds == 1
    assert playing.due(now + 1000.0) == []


@given(TIMES, st.floats(0.0, 100.0))
def test_paused_nothing_comes_and_no_time_is_caught_up_with(times: list[int], wait: float):
    playing = playback(times)
    playing.due(0.0)
    playing.paused = True
    reached = playing.position
    assert playing.due(wait) == []
    playing.paused = False
    playing.due(wait)
    assert playing.position == reached


@given(TIMES)
def test_steps_give_everything_each_up_to_the_next_one_of_the_kind(times: list[int]):
    playing = playback(times, is_step=lambda m: m.topic == "/odd")
    received: list[BagMessage] = []
    while not playing.finished:
        new = playing.step()
        assert [m.topic for m in new[:-1]] == ["/even"] * (len(new) - 1)
        assert playing.position == new[-1].log_time
        received += new
    assert len(received) == len(times)
    assert playing.step() == []


@given(TIMES, st.integers(2, 4))
def test_looping_states_the_same_again_and_again(times: list[int], rounds: int):
    playing = playback(times, loop=True)
    received: list[list[bytes]] = [[]]
    now = 0.0
    while playing.rounds < rounds:
        before = playing.rounds
        received[-1] += [m.data for m in playing.due(now)]
        if playing.rounds > before:
            received.append([])
        now += 1.0
    assert received[:rounds] == [[str(k).encode() for k in range(len(times))]] * rounds


@given(TIMES, st.data())
def test_after_a_jump_it_goes_on_from_there(times: list[int], data: st.DataObject):
    playing = playback(times)
    at = data.draw(st.integers(times[0], times[-1]))
    playing.jump(at)
    playing.due(0.0)
    received = playing.due(21.0) if not playing.finished else []
    assert [m.log_time for m in received] in ([t for t in times if t >= at], [t for t in times if t > at])


@given(TIMES, st.data())
def test_with_a_limit_nothing_beyond_it_comes_until_it_is_lifted(times: list[int], data: st.DataObject):
    playing = playback(times)
    limit = data.draw(st.integers(times[0], times[-1]))
    playing.due(0.0)
    received = playing.due(100.0, limit)
    assert all(m.log_time <= limit for m in received)
    assert playing.position <= max(limit, times[0])
