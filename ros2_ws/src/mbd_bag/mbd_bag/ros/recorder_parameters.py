"""The recorder's parameters, each declared once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterType
from rclpy.node import Node

from mbd_bag.errors import BagError
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.superseded import supersede

# Hidden topics are actions' own.
DEFAULT_EXCLUDE = [r".*/_[^/]*(/.*)?"]
IMAGES = ("compressed", "raw")


@dataclass(frozen=True)
class RecorderConfig:
    """Parameters of the node; each is described where it is declared."""

    bag: str
    exclude: tuple[str, ...]
    images: str
    clouds: bool
    jpeg_quality: int
    image_rate: float
    session: str
    participant: str
    task: str
    seed: int
    resume: bool
    redo: bool
    compression: str
    min_free: float
    stop_free: float
    discovery_period: float

    def open_bag(self) -> BagWriter:
        """The bag to write; raises BagError when it or a parameter cannot be used."""
        if not self.bag:
            raise BagError("no bag to write: give the parameter bag, e.g. --ros-args -p bag:=bags/sorting_1")
        if self.images not in IMAGES:
            raise BagError(f"parameter images is '{self.images}'; expected one of: {', '.join(IMAGES)}")
        if self.resume and self.redo:
            raise BagError("parameters resume and redo are both true; go on in the bag, or record it anew")
        try:
            compression = Compression(self.compression)
        except ValueError as error:
            raise BagError(f"parameter compression: {error}; expected one of: {', '.join(Compression)}") from error
        folder = Path(self.bag).expanduser().absolute()
        if self.redo and folder.exists():
            supersede(folder)
        return BagWriter(folder, compression=compression, resume=self.resume, min_free=int(self.min_free * 1e6))


def declare(node: Node) -> RecorderConfig:
    """Declare and read every parameter."""

    def value(name: str, default: Any, description: str, low: float | None = None, high: float = 0.0) -> Any:
        descriptor = ParameterDescriptor(description=description, read_only=True)
        if low is not None and isinstance(default, int):
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
        elif low is not None:
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        if isinstance(default, list):
            descriptor.type = ParameterType.PARAMETER_STRING_ARRAY
        return node.declare_parameter(name, default, descriptor).value

    return RecorderConfig(
        bag=value("bag", "", "folder of the bag to write; it must not exist yet"),
        exclude=tuple(value("exclude", DEFAULT_EXCLUDE, "regular expressions of whole topic names not to record")),
        images=value("images", "compressed", "colour as JPEG and depth as PNG (compressed), or as they come (raw)"),
        clouds=value("clouds", False, "record point clouds too; colour, depth and camera_info determine them"),
        jpeg_quality=value("jpeg_quality", 90, "of compressed colour", 1, 100),
        image_rate=value("image_rate", 0.0, "at most so many images a second of each topic [Hz]; 0: all", 0.0, 1000.0),
        session=value("session", "", "name of the session; the bag's when empty"),
        participant=value("participant", "", "who teaches (a pseudonym)"),
        task=value("task", "", "name of the task"),
        seed=value("seed", 0, "seed of the simulated session"),
        resume=value("resume", False, "go on in a finished bag, in its next file"),
        redo=value("redo", False, "record an existing bag anew; the old one is kept as <bag>_superseded_<n>, marked"),
        compression=value("compression", "lz4", "of the bag's chunks: none, lz4 or zstd"),
        min_free=value("min_free", 500.0, "free disk space to insist on at the start; warn below [MB]", 0.0, 1e9),
        stop_free=value("stop_free", 50.0, "free disk space below which the bag is closed [MB]", 0.0, 1e9),
        discovery_period=value("discovery_period", 0.2, "between looks for new topics [s]", 0.01, 10.0),
    )
