"""This machine's own address, without which a node that joins is deaf for as long as it lives (Fast DDS 2.14)."""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import sys
import time
from typing import NoReturn

from mbd_model.errors import MbdError

PATIENCE = 30.0  # [s]
LINKS, NEW_LINK, LOOPBACK, UP = 1, 16, 1, 1  # of rtnetlink: its group and message, the device's number, IFF_UP
HEADER, LINK = struct.Struct("=LHHLL"), struct.Struct("=BxHiII")  # nlmsghdr and ifinfomsg
MOST = 1 << 16  # [byte] of what is read at a time


class LoopbackWatch:
    """Notices that the loopback device went down, however briefly, from its making on.

    Where the kernel tells nobody of its devices it notices nothing.
    """

    def __init__(self) -> None:
        self._socket: socket.socket | None = None
        with contextlib.suppress(OSError, AttributeError):  # another system than Linux has no such sockets
            self._socket = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW | socket.SOCK_NONBLOCK, 0)
            self._socket.bind((0, LINKS))

    def went_down(self) -> bool:
        """Whether it did; the watch is over then."""
        if self._socket is None:
            return False
        with self._socket as told, contextlib.suppress(OSError):  # at the end: there is nothing left to read
            while True:
                if _is_down(told.recv(MOST)):
                    return True
        return False


def _is_down(data: bytes) -> bool:
    """Whether one of some rtnetlink messages has it that the loopback device is down."""
    while len(data) >= HEADER.size + LINK.size:
        length, kind, *_ = HEADER.unpack_from(data)
        _, _, index, flags, _ = LINK.unpack_from(data, HEADER.size)
        if kind == NEW_LINK and index == LOOPBACK and not flags & UP:
            return True
        data = data[max(length + 3 & ~3, HEADER.size) :]
    return False


def begin_again() -> NoReturn:
    """Start this process's program once more, in its place: same process, same words."""
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])


def wait_for_loopback(patience: float = PATIENCE) -> None:
    """Until this machine's own address is there.

    Args:
        patience: how long to wait [s].

    Raises:
        MbdError: it is still not there after that.
    """
    end = time.monotonic() + patience
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        while True:
            try:
                probe.connect(("127.0.0.1", 9))
            except OSError as error:
                if time.monotonic() >= end:
                    why = f"this machine's own address 127.0.0.1 is not there ({error.strerror})"
                    raise MbdError(f"{why}: bring the loopback device up (ip link set lo up)") from error
                time.sleep(0.05)  # the pace of looking: nothing tells that it came up
            else:
                return
