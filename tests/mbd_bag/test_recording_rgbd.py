"""What a recorder makes of images, clouds, repeated episodes, killing and a full disk."""

from __future__ import annotations

import array
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rclpy
from mbd_bag.errors import BagError
from mbd_bag.images.image_compression import decompress
from mbd_bag.recorder.writing_thread import WritingThread
from mbd_bag.session.session_facts import fingerprint, package_versions, parameter_facts
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.definitions import full_definition
from mbd_bag.storage.message_writer import MessageWriter
from mbd_bag.storage.superseded import is_superseded, supersede
from mbd_model.ros.qos import SENSOR
from mbd_msgs.msg import WizardNote
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rosbags.rosbag2 import Reader
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

COLOR = cv2.resize(np.random.default_rng(0).integers(0, 256, (6, 8, 3), dtype=np.uint8), (64, 48))
DEPTH = np.random.default_rng(1).integers(400, 2000, (48, 64), dtype=np.uint16)


class Camera:
    """A node that publishes RGB-D, numbered in the width of camera_info; and recorders around it."""

    def __init__(self, domain: int, recorders: Any) -> None:
        self._domain, self._recorders = domain, recorders
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = Node("camera", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        kinds = {"color/image_raw": Image, "depth/image_raw": Image, "color/camera_info": CameraInfo}
        kinds["points"] = PointCloud2
        self.out = {name: self.node.create_publisher(kind, f"camera/{name}", SENSOR) for name, kind in kinds.items()}
        self.sent: list[float] = []
        self.node.create_timer(0.02, self._send)
        self.processes: list[Any] = []

    def _send(self) -> None:
        stamp = self.node.get_clock().now().to_msg()
        for name, pixels, encoding in (("color", COLOR, "rgb8"), ("depth", DEPTH, "16UC1")):
            msg = Image(height=48, width=64, encoding=encoding, step=pixels[0].nbytes)
            msg.header.stamp = stamp
            msg.data = array.array("B", pixels.tobytes())
            self.out[f"{name}/image_raw"].publish(msg)
        info, cloud = CameraInfo(width=len(self.sent)), PointCloud2()
        info.header.stamp = cloud.header.stamp = stamp
        self.out["color/camera_info"].publish(info)
        self.out["points"].publish(cloud)
        self.sent.append(time.monotonic())

    def start(self, bag: Path, *parameters: str) -> Any:
        parameters = (f"bag:={bag}", "min_free:=1.0", "stop_free:=0.0", "discovery_period:=0.05", *parameters)
        words = [w for p in parameters for w in ("-p", p)]
        process = self._recorders.start(self._domain, "--ros-args", *words)
        self.processes.append(process)
        return process

    def spin_for(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def spin_until(self, happened: Callable[[], bool], what: str, timeout: float = 60.0) -> None:
        deadline = time.monotonic() + timeout
        while not happened():
            assert time.monotonic() < deadline, f"waited {timeout} s for {what}"
            self.executor.spin_once(timeout_sec=0.05)

    def record(self, bag: Path, topics: Sequence[str], number: int, *parameters: str) -> Bag:
        """Record until there are so many messages of each topic (below /camera)."""
        old = bag.stat().st_ino if bag.exists() else 0
        process = self.start(bag, *parameters)

        def enough() -> bool:
            found = so_far(bag) if bag.exists() and bag.stat().st_ino != old else {}
            return all(found.get(f"/camera/{topic}", 0) >= number for topic in topics)

        self.spin_until(enough, f"{number} messages of {topics}")
        process.send_signal(signal.SIGINT)
        output = process.output()
        assert process.returncode == 0, output
        return Bag(bag)

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def camera(ros_domain: int, recorders: Any) -> Iterator[Camera]:
    made = Camera(ros_domain, recorders)
    yield made
    made.close()


def counts(bag: Bag) -> dict[str, int]:
    return {t.name: t.count for t in bag.topics}


def so_far(path: Path) -> dict[str, int]:
    """Messages by topic that a bag holds so far."""
    try:
        return counts(Bag(path))
    except BagError:
        return {}


def frames(path: Path) -> list[int]:
    """Numbers of the frames that a bag holds so far."""
    try:
        return [int(msg.width) for _, msg in Bag(path).decoded({"/camera/color/camera_info"})]
    except BagError:
        return []


def test_images_are_compressed_and_clouds_left_out_unless_asked_for(camera: Camera, tmp_path: Path):
    compressed = ("color/image_raw/compressed", "depth/image_raw/compressedDepth", "color/camera_info")
    bag = camera.record(tmp_path / "bag", compressed, 21)
    found = counts(bag)
    assert not {"/camera/color/image_raw", "/camera/depth/image_raw", "/camera/points"} & set(found)
    assert found["/camera/color/image_raw/compressed"] > 20
    assert found["/camera/depth/image_raw/compressedDepth"] > 20
    depth = [decompress(m.data) for m in bag.messages({"/camera/depth/image_raw/compressedDepth"})]
    assert all((np.frombuffer(d.data, np.uint16).reshape(DEPTH.shape) == DEPTH).all() for d in depth)
    color = decompress(next(bag.messages({"/camera/color/image_raw/compressed"})).data)
    assert np.abs(np.frombuffer(color.data, np.uint8).reshape(COLOR.shape).astype(int) - COLOR).mean() < 5
    log_times = [m.log_time for m in bag.files[0].messages()]
    assert log_times == sorted(log_times)
    with Reader(tmp_path / "bag") as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == found
    assert bag.facts["fingerprint"] == fingerprint(bag.facts)

    as_it_came = ("color/image_raw", "depth/image_raw", "points")
    raw = counts(camera.record(tmp_path / "raw", as_it_came, 6, "images:=raw", "clouds:=true"))
    assert raw["/camera/color/image_raw"] > 5
    assert raw["/camera/depth/image_raw"] > 5
    assert raw["/camera/points"] > 5
    assert not [name for name in raw if "compressed" in name]


def test_fewer_images_a_second_are_of_the_same_moments(camera: Camera, tmp_path: Path):
    names = ("color/image_raw/compressed", "depth/image_raw/compressedDepth")
    bag = camera.record(tmp_path / "bag", names, 5, "image_rate:=4.0")
    stamps = [
        [d.header.stamp.sec * 10**9 + d.header.stamp.nanosec for _, d in bag.decoded({f"/camera/{name}"})]
        for name in names
    ]
    # One of each quarter of a second. Of a quarter colour and depth have the same moment, but where one was lost on its
    # way and the next took its place.
    quarters = [{stamp * 4 // 10**9: stamp for stamp in of_topic} for of_topic in stamps]
    assert [len(q) for q in quarters] == [len(s) for s in stamps]
    both = set(quarters[0]) & set(quarters[1])
    same = sum(quarters[0][quarter] == quarters[1][quarter] for quarter in both)
    assert same >= 3


@pytest.mark.alone
@pytest.mark.timeout(240)
def test_of_20_killed_recordings_every_one_opens_and_lacks_at_most_its_last_second(camera: Camera, tmp_path: Path):
    lost = []
    # Two at once, as what takes long is to find one another. Each is killed a little later after its first frames.
    for first in range(0, 20, 2):
        numbers = range(first, first + 2)
        folders = [tmp_path / f"bag{number}" for number in numbers]
        processes = [camera.start(folder) for folder in folders]
        # A killed recorder haunts the graph for a while: only what is in the bag shows that the new one is at work.
        camera.spin_until(lambda folders=folders: all(frames(folder) for folder in folders), "frames in the bags")
        killed_at = []
        for process in processes:
            camera.spin_for(0.02 * first)
            process.kill()
            process.wait()
            killed_at.append(time.monotonic())
        for folder, at in zip(folders, killed_at, strict=True):
            read = frames(folder)
            assert read
            assert Bag(folder).problems
            lost.append(at - camera.sent[read[-1]])
    assert len(lost) == 20
    assert max(lost) < 1.0, lost


def test_an_episode_recorded_again_keeps_the_first_try_marked(camera: Camera, tmp_path: Path):
    folder = tmp_path / "bag"
    first = camera.record(folder, ("color/camera_info",), 5)
    before = first.message_count
    again = camera.record(folder, ("color/camera_info",), 5, "redo:=true")
    assert not is_superseded(again.facts)
    kept = Bag(tmp_path / "bag_superseded_1")
    assert is_superseded(kept.facts)
    assert kept.facts["superseded_by"] == "bag"
    assert kept.message_count == before
    with Reader(kept.path) as reader:
        assert reader.message_count == before


def test_a_killed_first_try_is_completed_and_kept_too(tmp_path: Path):
    for expected in ("bag_superseded_1", "bag_superseded_2"):
        with BagWriter(tmp_path / "bag") as bag:
            MessageWriter(bag).write("/wizard/note", WizardNote(text="first"), 1)
            bag.flush()
        file = tmp_path / "bag" / "bag_0.mcap"
        (tmp_path / "bag" / "metadata.yaml").unlink()
        file.write_bytes(file.read_bytes()[:-50])
        assert supersede(tmp_path / "bag").name == expected
        assert Bag(tmp_path / expected).problems == ()
        assert is_superseded(Bag(tmp_path / expected).facts)
    with pytest.raises(BagError, match="no recorded bag"):
        supersede(tmp_path)


def test_a_disk_that_runs_short_is_reported_and_a_full_one_closes_the_bag_complete(tmp_path: Path):
    output: list[str] = []
    writer = BagWriter(tmp_path / "short")
    thread = WritingThread(writer, min_free=1 << 60, space_period=0.0, warn=output.append)
    thread.write("/nobody", 0, b"")
    with pytest.raises(BagError, match="not known"):
        thread.close()
    writer = BagWriter(tmp_path / "full")
    MessageWriter(writer).write("/wizard/note", WizardNote(text="kept"), 1)
    thread = WritingThread(writer, stop_free=1 << 60, space_period=0.0, warn=output.append)
    deadline = time.monotonic() + 10
    while thread.failure is None and time.monotonic() < deadline:
        time.sleep(0.01)
    with pytest.raises(BagError, match=r"MB are free.*resume"):
        thread.close()
    assert Bag(tmp_path / "full").problems == ()
    assert [m.text for _, m in Bag(tmp_path / "full").decoded()] == ["kept"]


def test_the_fingerprint_is_of_the_set_up_and_of_nothing_else():
    facts = {"participant": "p1", "seed": "3"} | package_versions() | parameter_facts("/mapping", {"sigma": 0.34})
    same = facts | {"participant": "p2", "seed": "4", **parameter_facts("/recorder", {"seed": 4})}
    same |= parameter_facts("/interaction", {"session": "p2"})
    assert fingerprint(facts) == fingerprint(dict(reversed(same.items())))
    assert fingerprint(facts) != fingerprint(facts | parameter_facts("/mapping", {"sigma": 0.35}))
    assert fingerprint(facts) != fingerprint(facts | {"version.numpy": "1.0"})
    assert len(fingerprint({})) == 16
    assert full_definition("sensor_msgs/msg/CompressedImage").startswith("#")
