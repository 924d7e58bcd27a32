"""A recorder waits for its threads as long as they get on, and no longer."""

from __future__ import annotations

import threading

import pytest
from mbd_bag.errors import BagError
from mbd_bag.recorder.thread_end import wait_for_end


def test_a_thread_that_does_nothing_is_given_up_with_what_is_left_undone():
    never = threading.Event()
    thread = threading.Thread(target=never.wait, name="bag writer", daemon=True)
    thread.start()
    with pytest.raises(BagError, match=r"bag writer has done nothing for 0\.1 s and 7 of its jobs are left"):
        wait_for_end(thread, lambda: 7, stalled=0.1)
    never.set()


def test_a_thread_that_gets_on_is_waited_for_however_long_it_takes():
    step, left = threading.Event(), [20]

    def work() -> None:
        while left[0]:
            step.wait(0.05)  # longer in all than the patience
            left[0] -= 1

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    wait_for_end(thread, lambda: left[0], stalled=0.4)
    assert not thread.is_alive() and left == [0]
