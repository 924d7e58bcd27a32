"""The pictures of one bag as a copy for others has them: of the table alone, without the faces that are found.

Two looks at the bag come first: at its distances, which state what of each moment lies in the table's volume, and at
its colours, for faces. A face that is found is covered in every picture and cloud of the second before and after, since
the next picture may show it as well where it is not found.
"""

from __future__ import annotations

import bisect
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from mbd_bag.errors import BagError
from mbd_bag.formats.contents import BagMessage
from mbd_bag.recorder.thinning import header_stamp
from mbd_bag.storage.bag import Bag
from mbd_model.errors import MbdError
from mbd_perception.segmentation.components import Mask

from mbd_study.sharing.pictures.clouds import cover_cloud
from mbd_study.sharing.pictures.encodings import Picture, covered, grey, is_depth, metres, read_picture
from mbd_study.sharing.pictures.faces import FaceBox, FaceFinder
from mbd_study.sharing.pictures.volume import TableVolume, volume_of

IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
CLOUD = "sensor_msgs/msg/PointCloud2"
SAME_MOMENT = 40_000_000  # [ns] between a picture and the distances that state what it shows
AROUND_FACE = 1_000_000_000  # [ns] before and after a face during which its place is covered


@dataclass
class CoverCounts:
    """What was done with the pictures of a bag.

    Attributes:
        pictures: that were kept, covered.
        by_direction: those of them without distances of their moment.
        with_faces: pictures in which faces were found.
        faces: that were found in them.
        left_out: number of messages by topic and why.
    """

    pictures: int = 0
    by_direction: int = 0
    with_faces: int = 0
    faces: int = 0
    left_out: Counter[tuple[str, str]] = field(default_factory=Counter)


class PictureCover:
    """Covers the pictures and clouds of a bag, one after the other.

    Args:
        bag: whose pictures are covered.
        topics: that hold them.
        finder: of faces.

    Attributes:
        counts: what was done so far.
        why_none: why no picture of this bag can be covered, "" when they can.
    """

    def __init__(self, bag: Bag, topics: frozenset[str], finder: FaceFinder) -> None:
        self.counts, self.why_none = CoverCounts(), ""
        self._masks: dict[int, bytes] = {}
        self._faces: dict[int, list[FaceBox]] = {}
        self._volume: TableVolume | None = None
        images = {t.name for t in bag.topics if t.name in topics and t.msgtype in IMAGES}
        try:
            self._volume = volume_of(bag)
        except MbdError as error:
            self.why_none = f"pictures cannot be covered: {error}"
            return
        for _, stamp, picture in self._readable(bag, images, distances=True):
            self._masks[stamp] = _packed(self._volume.seen(metres(picture)))
        self._moments = sorted(self._masks)
        self._look_for_faces(bag, images, finder)
        self._sightings = sorted(stamp for stamp, faces in self._faces.items() if faces)

    def covered(self, bag: Bag, message: BagMessage) -> bytes | None:
        """The message to keep in place of one of these topics; None, and counted, when it is left out."""
        try:
            if message.msgtype == CLOUD:
                return self._covered_cloud(bag, message)
            picture = self._checked(read_picture(message.data, message.msgtype))
            keep, exact = self._keep(header_stamp(message.data))
            data = covered(picture, keep)
        except BagError as error:
            self.counts.left_out[message.topic, str(error)] += 1
            return None
        self.counts.pictures += 1
        self.counts.by_direction += not exact
        return data

    def _covered_cloud(self, bag: Bag, message: BagMessage) -> bytes:
        cloud = bag.decoder.decode(message)
        cover_cloud(cloud, self._known_volume(), list(self._near(header_stamp(message.data))))
        self.counts.pictures += 1
        return bag.decoder.encode(cloud, message.msgtype)

    def _known_volume(self) -> TableVolume:
        if self._volume is None:
            raise BagError(self.why_none)
        return self._volume

    def _checked(self, picture: Picture) -> Picture:
        """The picture, when it is one of the camera whose pose is known; raises BagError."""
        volume = self._known_volume()
        if picture.frame_id != volume.camera_frame:
            raise BagError(f"it is of the frame '{picture.frame_id}', a camera of which nobody says where it stood")
        return picture

    def _readable(self, bag: Bag, topics: set[str], *, distances: bool) -> Iterator[tuple[str, int, Picture]]:
        """Topic, stamp and picture of those that can be covered."""
        for message in bag.messages(topics) if topics else ():
            try:
                picture = self._checked(read_picture(message.data, message.msgtype))
                if is_depth(picture) != distances:
                    continue
                camera = self._known_volume().camera
                if (metres(picture) if distances else grey(picture)).shape != (camera.height, camera.width):
                    continue
            except BagError:
                continue  # said when it is left out
            yield message.topic, header_stamp(message.data), picture

    def _look_for_faces(self, bag: Bag, topics: set[str], finder: FaceFinder) -> None:
        least = self._known_volume().face_pixels
        for _, stamp, picture in self._readable(bag, topics, distances=False):
            if stamp in self._faces:
                continue  # the same picture, perhaps with outlines drawn into it
            # A face at the volume's edge is found by what surrounds it, too: nothing is covered yet.
            keep, _ = self._mask(stamp)
            found = [face for face in finder.find(grey(picture), least) if keep[face.part].any()]
            self._faces[stamp] = found
            self.counts.with_faces += bool(found)
            self.counts.faces += len(found)

    def _mask(self, stamp: int) -> tuple[Mask, bool]:
        """What belongs to the table at a moment, and whether distances say so."""
        volume = self._known_volume()
        place = bisect.bisect_left(self._moments, stamp)
        near = min(self._moments[max(place - 1, 0) : place + 1], key=lambda moment: abs(moment - stamp), default=None)
        if near is None or abs(near - stamp) > SAME_MOMENT:
            return volume.seen_without_depth, False
        return _unpacked(self._masks[near], volume.seen_without_depth.shape), True

    def _keep(self, stamp: int) -> tuple[Mask, bool]:
        """`_mask`, without faces."""
        mask, exact = self._mask(stamp)
        mask = mask.copy()
        for face in self._near(stamp):
            mask[face.part] = False
        return mask, exact

    def _near(self, stamp: int) -> Iterator[FaceBox]:
        """The faces that were found around a moment."""
        first = bisect.bisect_left(self._sightings, stamp - AROUND_FACE)
        for moment in self._sightings[first:]:
            if moment > stamp + AROUND_FACE:
                return
            yield from self._faces[moment]


def reasons(counts: Mapping[tuple[str, str], int]) -> dict[str, tuple[str, int]]:
    """(why, number of messages) by topic, of several reasons all."""
    by_topic: dict[str, tuple[str, int]] = {}
    for (topic, why), count in counts.items():
        before = by_topic.get(topic)
        by_topic[topic] = (why, count) if before is None else (f"{before[0]}; {why}", before[1] + count)
    return by_topic


def _packed(mask: Mask) -> bytes:
    """A mask in about a kilobyte: a bag holds thousands."""
    return zlib.compress(np.packbits(mask).tobytes(), 1)


def _unpacked(packed: bytes, shape: tuple[int, ...]) -> Mask:
    bits = np.unpackbits(np.frombuffer(zlib.decompress(packed), np.uint8), count=int(np.prod(shape)))
    return bits.reshape(shape).astype(bool)
