"""The perception node's parameters. What the core has a default for takes it from there."""

from __future__ import annotations

from mbd_model.camera.parameters import CAMERA_ORIENTATION, CAMERA_POSITION
from mbd_model.parameters import ParameterSpec, ParameterTable

from mbd_perception.features.measure import ObserveConfig
from mbd_perception.frames.frame import DEPTH_NOISE
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.segmenters.segmenter import OWN

PERCEPTION = ParameterTable(
    "perception",
    (
        ParameterSpec(
            "input",
            "images",
            "What to subscribe to: images (colour, depth, camera_info: the cheaper) or points (organized PointCloud2).",
            choices=("images", "points"),
        ),
        ParameterSpec(
            "image_transport",
            "auto",
            "How images come: raw, compressed (topics with /compressed and /compressedDepth added, as image_transport "
            "names them) or auto: what is offered, raw first.",
            choices=("auto", "raw", "compressed"),
        ),
        ParameterSpec(
            "base_frame", ObserveConfig.frame_id, "Name of the robot base frame, in which scenes are published."
        ),
        ParameterSpec(
            "camera_pose",
            "parameter",
            "Where the camera's pose comes from: parameter (camera_position, camera_orientation), tf (where tf2_ros is "
            "installed) or table (unknown: scenes are in a table frame below the camera, the workspace does not "
            "apply).",
            choices=("parameter", "tf", "table"),
        ),
        CAMERA_POSITION,
        CAMERA_ORIENTATION,
        ParameterSpec("workspace_x", (0.25, 1.3), "Lowest and highest x of objects in the base frame.", "m"),
        ParameterSpec("workspace_y", (-0.7, 0.7), "Lowest and highest y of objects in the base frame.", "m"),
        ParameterSpec("workspace_z", (-0.05, 0.5), "Lowest and highest z of table and objects in the base frame.", "m"),
        ParameterSpec("frames", 3, "How many frames an observation fuses by their median.", range=(1, 30)),
        ParameterSpec(
            "timeout", 10.0, "How long an observation waits for its frames, wall clock.", "s", range=(0.1, 600.0)
        ),
        ParameterSpec(
            "sync_tolerance",
            0.05,
            "Largest difference of stamps of colour and depth of one frame; beyond 20 ms only if no nearer image "
            "comes.",
            "s",
            range=(0.0, 1.0),
        ),
        ParameterSpec(
            "depth_noise",
            DEPTH_NOISE,
            "Std of inverse depth: depth noise over depth squared, 1.5e-3 for structured light (Khoshelham 2012).",
            "1/m",
            range=(1e-5, 0.1),
        ),
        ParameterSpec(
            "min_height",
            SegmentationConfig.min_height,
            "Lowest height of an object's surface above the table.",
            "m",
            range=(0.001, 0.1),
        ),
        ParameterSpec(
            "min_area", SegmentationConfig.min_area, "Smallest visible surface of an object.", "m^2", range=(1e-6, 0.1)
        ),
        ParameterSpec(
            "keep_ids",
            True,
            "Whether objects keep their ids from one observation of a role to the next (small moves only).",
        ),
        ParameterSpec(
            "segmenter",
            OWN,
            "What finds the objects: own, or package.module:factory of another segmenter (docs/perception.md).",
        ),
        ParameterSpec(
            "arm_description",
            "",
            "Path of the arm's URDF or MJCF, by which the arm in view is told from objects; empty: what comes on "
            "robot_description, if any.",
        ),
        ParameterSpec(
            "joint_state", "j2n6s300_driver/out/joint_state", "Topic of the arm's joints, named as in its URDF."
        ),
        ParameterSpec("knowledge", "", "Path of the knowledge base (YAML); empty: the one of this package."),
        ParameterSpec("state_dir", "", "Folder in which the last scenes are kept over a restart; empty: not kept."),
    ),
)
