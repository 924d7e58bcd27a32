"""Keys pressed in a terminal, without waiting for Enter."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

HELP = "space pause   s step   + faster   - slower   n next phase   l loop   q quit"


@contextmanager
def pressed_keys() -> Iterator[bool]:
    """Makes `poll` work in the block; gives False when standard input is no terminal, so that there are no keys."""
    if not sys.stdin.isatty():
        yield False
        return
    before = termios.tcgetattr(sys.stdin)
    try:
        tty.setcbreak(sys.stdin)
        yield True
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def poll() -> str:
    """The key that waits, "" when none does; only inside `pressed_keys` on a terminal."""
    ready, _, _ = select.select([sys.stdin], [], [], 0.0)
    return os.read(sys.stdin.fileno(), 1).decode(errors="replace") if ready else ""
