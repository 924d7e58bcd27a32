"""The camera's pictures for the pages: the newest, and the one each scene was observed in, as JPEG."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass, field

import cv2
import numpy as np
from mbd_model.objects import Role
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
LIVE = "live"
MEMORY = 24  # frames in which a scene's picture is looked for
NEAREST = 1.0  # [s] a frame further from a scene does not show it
QUALITY = 82  # of JPEG, of 100


@dataclass
class PictureStore:
    """Pictures by name: "live", "source", "target". Filled by the ROS thread, read by the web server's.

    A picture is encoded when somebody asks for it, and once.
    """

    _lock: threading.Lock = field(default_factory=threading.Lock)
    _recent: deque[tuple[float, Picture]] = field(default_factory=lambda: deque(maxlen=MEMORY))
    _shown: dict[str, tuple[int, Picture]] = field(default_factory=dict)
    _encoded: dict[str, tuple[int, bytes]] = field(default_factory=dict)
    _versions: int = 0
    _newest: float | None = None
    _newest_stamp: float = 0.0

    @property
    def newest(self) -> float | None:
        """When the last frame came [s, monotonic clock]; None before the first."""
        return self._newest

    @property
    def newest_stamp(self) -> float:
        """When the last frame was taken [s, session clock]; 0 before the first."""
        return self._newest_stamp

    def add(self, stamp: float, picture: Picture) -> None:
        """A new frame, (height, width, 3) RGB, stamped [s]."""
        self._newest, self._newest_stamp = time.monotonic(), stamp
        with self._lock:
            self._recent.append((stamp, picture))
            self._show(LIVE, picture)

    def keep(self, role: Role, stamp: float) -> Picture | None:
        """Keep the frame that a scene stamped so [s] was observed in; forget the one before when there is none.

        Returns:
            That frame, None when none was near.
        """
        with self._lock:
            near = min(self._recent, key=lambda pair: abs(pair[0] - stamp), default=None)
            if near is None or abs(near[0] - stamp) > NEAREST:
                self._shown.pop(role, None)
                return None
            self._show(role, near[1])
            return near[1]

    def show(self, role: Role, picture: Picture) -> None:
        """Show a frame, (height, width, 3) RGB, as the one a scene was observed in."""
        with self._lock:
            self._show(role, picture)

    def version(self, name: str) -> int:
        """Grows with each other picture of that name; 0 while there is none."""
        with self._lock:
            return self._shown.get(name, (0, None))[0]

    def jpeg(self, name: str) -> tuple[int, bytes] | None:
        """Version and JPEG of that name's picture, None while there is none."""
        with self._lock:
            if name not in self._shown:
                return None
            version, picture = self._shown[name]
            done = self._encoded.get(name)
        if done is not None and done[0] == version:
            return done
        ok, data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if not ok:
            return None
        encoded = (version, data.tobytes())
        with self._lock:
            self._encoded[name] = encoded
        return encoded

    def _show(self, name: str, picture: Picture) -> None:
        self._versions += 1
        self._shown[name] = (self._versions, picture)
