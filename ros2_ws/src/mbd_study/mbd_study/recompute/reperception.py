"""A session's scenes once more, from its recorded RGB-D: the first stage of a computation from clouds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.images.image_compression import depth_pixels
from mbd_bag.recorder.thinning import header_stamp
from mbd_bag.session.recorded_session import Recorded, RecordedSession
from mbd_bag.session.scene_images import color_pixels, image_topic, raw_image, topic_ending
from mbd_bag.session.session_facts import recorded_parameters
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.definitions import installed_share
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError
from mbd_model.objects import Role, Scene
from mbd_model.times import to_seconds
from mbd_perception.config import known_pose, observe_config
from mbd_perception.features.knowledge import KnowledgeBase, load_knowledge
from mbd_perception.features.measure import ObserveConfig, observe
from mbd_perception.frames.frame import RgbdFrame, fuse, make_frame
from mbd_perception.parameters import PERCEPTION

from mbd_study.recompute.given_parameters import require_parameters
from mbd_study.recompute.same_objects import named_as
from mbd_study.recompute.stages import StageCheck, scene_differences, with_source, with_value

_LOOK_BACK = 20_000_000_000  # [ns] of log time in which an observation's frames lie before its scene
SAME_MOMENT = 20_000_000  # [ns] between colour and depth of one frame, and what a stamp in seconds loses


@lru_cache(maxsize=8)
def _knowledge(name: str) -> KnowledgeBase:
    """The knowledge base of a recorded parameter; a bag knows no folder of the machine, only the file's name."""
    path = installed_share("mbd_perception") / "config" / (Path(name).name or "knowledge.yaml")
    if not path.exists():
        raise BagError(f"the session used the knowledge base '{name}', which is not installed in {path.parent.name}")
    return load_knowledge(path)


def recorded_config(facts: Mapping[str, str]) -> tuple[ObserveConfig, CameraPose | None, int]:
    """Perception's config, the camera's pose (None: from the table) and the number of frames, as recorded.

    Raises:
        MbdError: a recorded parameter is out of its range.
    """
    values = PERCEPTION.values(recorded_parameters(facts, PERCEPTION))
    return observe_config(values, _knowledge(values["knowledge"])), known_pose(values), values["frames"]


def recorded_frames(bag: Bag, stamp: int, log_time: int, count: int) -> list[RgbdFrame]:
    """The last frames of RGB-D up to a scene's stamp, oldest first.

    Args:
        bag: with colour, depth and camera_info, raw or compressed.
        stamp: of the scene: that of its last frame [ns].
        log_time: of the scene [ns].
        count: how many frames were fused.

    Raises:
        BagError: the bag has no such frame.
    """
    topics = [image_topic(bag, f"camera/{kind}/image_raw") for kind in ("color", "depth")]
    about = topic_ending(bag, "camera/color/camera_info", "sensor_msgs/msg/CameraInfo")
    color_topic, depth_topic = topics
    if color_topic is None or depth_topic is None or about is None:
        raise BagError(f"{bag.path} has no RGB-D (colour, depth, camera_info): computing from clouds is impossible")
    _, info = next(bag.decoded({about}))
    camera = Intrinsics(info.k[0], info.k[4], info.k[2], info.k[5], int(info.width), int(info.height))
    found: dict[str, dict[int, Any]] = {color_topic: {}, depth_topic: {}}
    for message in bag.messages(set(found), log_time - _LOOK_BACK, log_time + 1_000_000_000):
        at = header_stamp(message.data)
        if at <= stamp + SAME_MOMENT:
            found[message.topic][at] = message
    frames = []
    for at in sorted(found[depth_topic], reverse=True):
        near = _nearest(found[color_topic], at)
        if near is None:
            continue
        color = color_pixels(raw_image(found[color_topic][near]), color_topic)
        depth = depth_pixels(raw_image(found[depth_topic][at]))
        frames.append(make_frame(color, depth, camera, to_seconds(at)))
        if len(frames) == count:
            break
    if not frames:
        raise BagError(
            f"{bag.path} has no frame of RGB-D in the {to_seconds(_LOOK_BACK):.0f} s before a scene was seen"
        )
    return frames[::-1]


def _nearest(stamps: Iterable[int], wanted: int) -> int | None:
    """The stamp of the same moment, None when there is none."""
    near = min(stamps, key=lambda stamp: abs(stamp - wanted), default=None)
    return near if near is not None and abs(near - wanted) <= SAME_MOMENT else None


def with_computed_scenes(bag: Bag, session: RecordedSession) -> tuple[RecordedSession, list[StageCheck]]:
    """The session with its scenes computed again from RGB-D, and how they compare with the recorded ones.

    Raises:
        MbdError: the recorded parameters cannot be used.
    """
    require_parameters(session, PERCEPTION)
    config, pose, count = recorded_config(session.facts)
    checks = []
    for role, field in ((Role.SOURCE, "source_scenes"), (Role.TARGET, "target_scenes")):
        entries: tuple[Recorded[Scene], ...] = getattr(session, field)
        for entry in entries:
            try:
                frames = recorded_frames(bag, entry.stamp, entry.log_time, count)
                seen = replace(observe(fuse(frames), role, pose, config).scene, stamp=entry.value.stamp)
            except MbdError as error:
                checks.append(StageCheck(f"{role} scene", entry.log_time, (), str(error)))
                continue
            scene = named_as(entry.value, seen)
            checks.append(StageCheck(f"{role} scene", entry.log_time, scene_differences(entry.value, scene)))
            if role is Role.SOURCE:
                session = replace(session, source_scenes=with_value(session.source_scenes, entry, scene))
                session = with_source(session, entry.value, scene)
            else:
                session = replace(session, target_scenes=with_value(session.target_scenes, entry, scene))
    return session, checks
