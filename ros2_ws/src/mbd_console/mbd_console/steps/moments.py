"""Small pictures of a demonstration while it is given, so that each step can be shown as it happened."""

from __future__ import annotations

import threading
from bisect import bisect_left
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

import cv2

from mbd_console.palette import safe
from mbd_console.pictures import Picture
from mbd_console.words.texts import PageTexts

PERIOD = 0.25  # [s] between two that are kept
KEPT = 2400  # pictures, of ten minutes
WIDTH = 320  # pixels
QUALITY = 75  # of JPEG, of 100
NEAREST = 1.0  # [s] a picture further from a moment does not show it


@dataclass
class MomentPictures:
    """JPEG pictures by time. Filled by the ROS thread, read by the web server's; about 15 kB each.

    Those of the steps of a task are kept whatever comes later.
    """

    _lock: threading.Lock = field(default_factory=threading.Lock)
    _recent: deque[tuple[float, bytes]] = field(default_factory=lambda: deque(maxlen=KEPT))
    _of_steps: dict[float, bytes] = field(default_factory=dict)

    def add(self, stamp: float, picture: Picture) -> None:
        """A frame of the demonstration, (height, width, 3) RGB, stamped [s]; most are left out."""
        with self._lock:
            last = self._recent[-1][0] if self._recent else None
        if last is not None and 0.0 <= stamp - last < PERIOD:
            return
        height, width = picture.shape[:2]
        size = (min(WIDTH, width), max(1, round(height * min(WIDTH, width) / width)))
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        ok, data = cv2.imencode(".jpg", small[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if not ok:
            return
        with self._lock:
            if last is not None and stamp < last:
                self._recent.clear()  # the clock was set back: what was before is of another time
            self._recent.append((stamp, data.tobytes()))

    def keep(self, moments: Iterable[float]) -> None:
        """Keep the pictures of these moments [s], and of those only."""
        wanted = {at: self.jpeg(at) for at in moments}
        with self._lock:
            self._of_steps = {at: data for at, data in wanted.items() if data is not None}

    def jpeg(self, at: float) -> bytes | None:
        """The picture nearest to a moment [s], None when none was taken near it."""
        with self._lock:
            if at in self._of_steps:
                return self._of_steps[at]
            stamps = [stamp for stamp, _ in self._recent]
            place = bisect_left(stamps, at)
            near = [self._recent[k] for k in (place - 1, place) if 0 <= k < len(stamps)]
        found = min(near, key=lambda pair: abs(pair[0] - at), default=None)
        return found[1] if found is not None and abs(found[0] - at) <= NEAREST else None


def no_picture(texts: PageTexts) -> str:
    """What is shown in place of a picture that there is none of, as SVG."""
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="320" height="240">'
        '<rect width="320" height="240" fill="#d9d5cc"/>'
        '<text x="160" y="125" text-anchor="middle" font-family="sans-serif" font-size="15" fill="#4d545b">'
        f"{safe(texts('no_moment'))}</text></svg>"
    )
