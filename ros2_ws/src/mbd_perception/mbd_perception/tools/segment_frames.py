"""``segment``: label pictures, object lists and overlays of frames kept in files.

`ros2 run mbd_perception segment FRAME... --out DIR [--pose …] [--noise …] [--region …]`

A frame is a folder (color.png, depth.png, meta.json) or a cloud (.pcd, .ply).
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from mbd_model.camera.pose import CameraPose, pose_from_quaternion
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from mbd_model.objects import FeatureDeviations, Role, SceneObject
from mbd_model.share_folder import config_folder
from rich.progress import track

from mbd_perception.features.knowledge import KnowledgeBase, load_knowledge
from mbd_perception.features.measure import NoObjectError, Observation, ObserveConfig, observe, with_tables
from mbd_perception.frames.cloud_files import load_cloud
from mbd_perception.frames.evidence import keep_evidence
from mbd_perception.frames.files import load_frame
from mbd_perception.frames.frame import DEPTH_NOISE
from mbd_perception.overlay import draw_overlay
from mbd_perception.segmentation.components import JumpConfig
from mbd_perception.segmentation.segment import SegmentationConfig
from mbd_perception.segmentation.table.plane import PlaneConfig
from mbd_perception.segmentation.workspace import Workspace
from mbd_perception.segmenters.segmenter import OWN, SegmenterError, load_segmenter
from mbd_perception.tools.stage_pictures import draw_stages

RESULTS = ("labels.png", "objects.json", "overlay.png", "stages.png")
_TABLE_FRAME = "table: z up from the table's surface, x away from the camera, y left, origin below the camera"


def object_record(obj: SceneObject, label: int, observation: Observation) -> dict[str, Any]:
    """One object as objects.json holds it; its centroid also in the camera's optical frame [m]."""
    x, y, z = obj.centroid
    in_camera = (np.array([x, y, z]) - observation.pose.position) @ observation.pose.rotation
    return {
        "id": obj.object_id,
        "label": label,
        "pixels": int((observation.segmentation.labels == label).sum()),
        "centroid_m": [round(v, 4) for v in obj.centroid],
        "centroid_cam_m": [round(float(v), 4) for v in in_camera],
        "size_m": {name: round(v, 4) for name, v in zip(("width", "depth", "height"), obj.size, strict=True)},
        "yaw_deg": round(float(np.degrees(obj.yaw)), 1),
        "volume_m3": round(obj.volume, 7),
        "hue_deg": None if obj.hue is None else round(obj.hue, 1),
        "saturation": round(obj.saturation, 3),
        "color": obj.color_name,
        "class": obj.object_class,
        "class_score": round(obj.class_score, 3),
        "affordances": sorted(obj.affordances),
        "properties": sorted(obj.properties),
        "relations": [[relation.name, other] for relation, other in obj.relations],
        "std": None if obj.deviations is None else deviation_record(obj.deviations),
    }


def deviation_record(std: FeatureDeviations) -> dict[str, Any]:
    """Standard deviations as objects.json holds them, in the names and units of the features they belong to."""
    return {
        "centroid_m": [round(v, 4) for v in std.centroid],
        "box_center_m": [round(v, 4) for v in std.box_center],
        "size_m": {name: round(v, 4) for name, v in zip(("width", "depth", "height"), std.size, strict=True)},
        "yaw_deg": round(float(np.degrees(std.yaw)), 1),
        "volume_m3": round(std.volume, 7),
        "hue_deg": None if std.hue is None else round(std.hue, 1),
        "saturation": round(std.saturation, 3),
    }


def segment_folder(
    folder: Path, out: Path, config: ObserveConfig, pose: CameraPose | None = None, stages: bool = False
) -> tuple[int, str]:
    """Segment one frame folder into ``out``; the number of objects, and what to check (empty when nothing is odd).

    Writes labels.png (0 = no object, 1.. as in objects.json; 16 bits beyond 255), objects.json, overlay.png, and, with
    ``stages``, stages.png: how it was done.

    Raises:
        MbdError: the frame cannot be read, or no table is in view. Of an earlier run nothing is left in ``out`` then.
    """
    for name in RESULTS:
        (out / name).unlink(missing_ok=True)
    frame = load_cloud(folder) if folder.suffix.lower() in (".pcd", ".ply") else load_frame(folder)
    out.mkdir(parents=True, exist_ok=True)
    try:
        observation = with_tables(observe(frame, Role.SOURCE, pose, config))
    except NoObjectError as nothing:
        cv2.imwrite(str(out / "labels.png"), np.zeros(frame.depth.shape, dtype=np.uint8))
        cv2.imwrite(str(out / "overlay.png"), np.ascontiguousarray(frame.color[..., ::-1]))
        (out / "objects.json").write_text(json.dumps({"table": None, "objects": []}) + "\n", encoding="utf-8")
        return 0, str(nothing)
    labels = observation.segmentation.labels
    plane = observation.segmentation.plane
    document = {
        "table": {
            "normal_cam": [round(float(v), 5) for v in plane.normal],
            "camera_height_m": round(plane.offset, 4),
            "depth_noise_per_m": round(observation.segmentation.noise, 5),
        },
        "other_tables": [
            {"higher_m": round(t.higher, 3), "area_m2": round(t.area, 3), "center_m": [round(v, 3) for v in t.center]}
            for t in (observation.tables.others if observation.tables else ())
        ],
        "hint": observation.hint,
        "frame": _TABLE_FRAME if pose is None else config.frame_id,
        "objects": [
            object_record(o, label, observation)
            for o, label in zip(observation.scene.objects, observation.labels, strict=True)
        ],
    }
    cv2.imwrite(str(out / "labels.png"), labels.astype(np.uint8 if labels.max() < 256 else np.uint16))
    cv2.imwrite(str(out / "overlay.png"), np.ascontiguousarray(draw_overlay(observation)[..., ::-1]))
    if stages:
        cv2.imwrite(str(out / "stages.png"), np.ascontiguousarray(draw_stages(observation)[..., ::-1]))
    (out / "objects.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return len(observation.scene.objects), observation.hint


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; 0 when every frame could be segmented, 1 when some could not, 2 for a wrong call."""
    parser = CommandParser(
        prog="segment",
        description="Find the objects on a table in frames kept in files (color.png, depth.png, meta.json).",
    )
    parser.add_argument("frames", nargs="+", type=Path, metavar="FRAME", help="folder of one frame, .pcd or .ply")
    parser.add_argument("--out", required=True, type=Path, metavar="DIR", help="a folder per frame is made in it")
    parser.add_argument("--knowledge", type=Path, metavar="YAML", help="knowledge base (default: that of this package)")
    parser.add_argument(
        "--pose",
        nargs=7,
        type=float,
        metavar=("X", "Y", "Z", "QX", "QY", "QZ", "QW"),
        help="of the optical frame in the base frame [m, quaternion] (default: worked out from the table)",
    )
    parser.add_argument(
        "--noise",
        type=float,
        default=DEPTH_NOISE,
        metavar="PER_M",
        help=f"std of inverse depth to start from: depth noise over depth squared (default {DEPTH_NOISE:g})",
    )
    parser.add_argument(
        "--region",
        nargs=6,
        type=float,
        metavar=("X1", "X2", "Y1", "Y2", "Z1", "Z2"),
        help="where table and objects are [m, base frame]; needs --pose",
    )
    parser.add_argument(
        "--segmenter",
        default=OWN,
        metavar="MODULE:FACTORY",
        help="package.module:factory of another segmenter (docs/perception.md; default: our own)",
    )
    parser.add_argument("--stages", action="store_true", help="also draw every stage of the segmentation")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    names = [f.stem if f.is_file() else f.resolve().name for f in options.frames]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        parser.error(f"several frames are called {', '.join(twice)}: their results would overwrite each other")
    failed = []
    if options.stages and options.segmenter != OWN:
        parser.error("--stages draws how our own segmenter works: leave it out with --segmenter")
    if options.region and not options.pose:
        parser.error("--region is in the base frame: give --pose too")
    if not 1e-5 <= options.noise <= 0.1:
        parser.error(f"--noise {options.noise:g} is not within 1e-5 and 0.1 1/m; a Kinect has 1.5e-3")
    try:
        config = _config(load_knowledge(options.knowledge or _own_knowledge()), options.noise, options.region)
        if options.segmenter != OWN:
            config = replace(config, segmenter=load_segmenter(options.segmenter))
        pose = pose_from_quaternion(options.pose[:3], options.pose[3:]) if options.pose else None
    except MbdError as error:
        parser.error(str(error))
    if reason := _not_writable(options.out):
        parser.error(f"--out {options.out} cannot be written to ({reason}): give another folder")
    for folder, name in track(list(zip(options.frames, names, strict=True)), "segmenting", disable=len(names) < 2):
        try:
            count, hint = segment_folder(folder, options.out / name, config, pose, options.stages)
            sys.stdout.write(f"{name}: {count} objects -> {options.out / name}{f' ({hint})' if hint else ''}\n")
        except KeyboardInterrupt:
            sys.stderr.write(f"{name}: interrupted; the frames before it are done\n")
            return 130
        except Exception as error:  # the frames after it are segmented all the same
            failed.append(name)
            sys.stderr.write(f"{name}: {_reason(error, folder, options.out / name)}\n")
    if failed:
        sys.stderr.write(f"{len(failed)} of {len(names)} frames failed: {', '.join(failed)}\n")
    return 1 if failed else 0


def _not_writable(folder: Path) -> str:
    """Why nothing can be written to a folder, which is made where it is missing; empty when it can be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return error.strerror or str(error)


def _reason(error: Exception, frame: Path, out: Path) -> str:
    """Why a frame could not be segmented; what nobody expected is kept below ``out``."""
    if isinstance(error, OSError):
        return f"{error.filename or out} cannot be read or written ({error.strerror or error})"
    if isinstance(error, MbdError) and not isinstance(error, SegmenterError):
        return str(error)
    kept = keep_evidence(out / "failed_frames", error, None)
    ours = f"{type(error).__name__}: {error}; please report it with"
    return f"{f'{error}; more in' if isinstance(error, SegmenterError) else ours} {kept or frame}"


def _config(knowledge: KnowledgeBase, noise: float, region: Sequence[float] | None) -> ObserveConfig:
    """What perception is set to; raises MbdError for a region that is empty."""
    workspace = Workspace(*zip(region[::2], region[1::2], strict=True)) if region else Workspace()
    segmentation = SegmentationConfig(plane=PlaneConfig(noise=noise), jump=JumpConfig(noise=noise), workspace=workspace)
    return ObserveConfig(knowledge=knowledge, segmentation=segmentation)


def _own_knowledge() -> Path:
    """The knowledge base of this package, installed or in the source tree."""
    beside = Path(__file__).resolve().parents[1] / "config" / "knowledge.yaml"
    if beside.is_file():
        return beside
    return config_folder("mbd_perception") / "knowledge.yaml"


if __name__ == "__main__":
    raise SystemExit(main())
