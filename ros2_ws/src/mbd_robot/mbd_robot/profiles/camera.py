"""What an RGB-D camera's driver speaks: the schema of a camera's profile (docs/robots/profiles.md)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from mbd_model.errors import MbdError

from mbd_robot.profiles.robot import Reliability

# The suite's own names.
COLOR, DEPTH, INFO = "camera/color/image_raw", "camera/depth/image_raw", "camera/color/camera_info"


class ImageTransport(Enum):
    """How an image travels: as it is, or compressed (topic with `/compressed`, `/compressedDepth`)."""

    RAW = "raw"
    COMPRESSED = "compressed"
    COMPRESSED_DEPTH = "compressedDepth"


@dataclass(frozen=True)
class ColorStream:
    """Colour images.

    Attributes:
        topic: without the transport's ending.
        transport: raw (sensor_msgs/Image) or compressed (sensor_msgs/CompressedImage).
        encoding: that the driver publishes; a stand-in does too.
    """

    topic: str
    transport: ImageTransport = ImageTransport.RAW
    encoding: str = "rgb8"

    def __post_init__(self) -> None:
        """Colour has no depth transport."""
        if self.transport is ImageTransport.COMPRESSED_DEPTH:
            raise MbdError("transport is compressedDepth; expected raw or compressed")


@dataclass(frozen=True)
class DepthStream:
    """Depth images registered to colour: as large, pixel by pixel.

    Attributes:
        topic: without the transport's ending.
        transport: raw (sensor_msgs/Image) or compressedDepth (sensor_msgs/CompressedImage).
        encoding: 16UC1 [mm] or 32FC1 [m].
    """

    topic: str
    transport: ImageTransport = ImageTransport.RAW
    encoding: str = "16UC1"

    def __post_init__(self) -> None:
        """Depth in JPEG would be no depth."""
        if self.transport is ImageTransport.COMPRESSED:
            raise MbdError("transport is compressed; expected raw or compressedDepth: JPEG spoils depth")
        if self.encoding not in ("16UC1", "32FC1"):
            raise MbdError(f"encoding is '{self.encoding}'; expected 16UC1 (millimetres) or 32FC1 (metres)")


@dataclass(frozen=True)
class CameraProfile:
    """One camera.

    Attributes:
        title: for people.
        tested: on what it was run, in a sentence.
        color: colour images.
        depth: depth images, registered to colour.
        camera_info: sensor_msgs/CameraInfo of colour.
        frame: the optical frame that its images name.
        rate: [Hz] of the images.
        reliability: with which they are subscribed to.
        depth_noise: [1/m] std of depth over depth squared; perception's parameter of that name.
        sync_tolerance: [s] largest difference of stamps of colour and depth of one frame.
        start: the driver's command line, for people.
    """

    title: str
    tested: str
    color: ColorStream
    depth: DepthStream
    camera_info: str
    frame: str
    rate: float = 30.0
    reliability: Reliability = Reliability.BEST_EFFORT
    depth_noise: float = 1.5e-3
    sync_tolerance: float = 0.02
    start: str = ""

    @property
    def names_are_the_suites(self) -> bool:
        """Whether the driver's images come as the suite takes them, so that nothing need be passed on."""
        raw = {self.color.transport, self.depth.transport} == {ImageTransport.RAW}
        return raw and (self.color.topic, self.depth.topic, self.camera_info) == (COLOR, DEPTH, INFO)
