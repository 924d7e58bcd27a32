"""Install mbd_perception as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "perception = mbd_perception.ros.node:main",
        "segment = mbd_perception.tools.segment_frames:main",
        "check_segmenter = mbd_perception.tools.check_segmenter:main",
    ],
)
