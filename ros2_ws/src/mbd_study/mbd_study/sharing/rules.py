"""What a copy for others keeps. Only what is known to be harmless is kept; what is new or unknown is left out."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from mbd_bag.formats.bounded_yaml import bounded_yaml

from mbd_study.sharing.names import NameFinder

PICTURES = frozenset(
    {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/PointCloud2"}
)  # of a camera over the table: arms and hands, and whoever leans over it
KEPT_TYPES = frozenset(
    {
        "geometry_msgs/msg/PoseStamped",
        "rosgraph_msgs/msg/Clock",
        "sensor_msgs/msg/CameraInfo",
        "sensor_msgs/msg/JointState",
        "tf2_msgs/msg/TFMessage",
        *(
            f"mbd_msgs/msg/{name}"
            for name in (
                "Assists",
                "CellTruth",
                "MappingEstimate",
                "Progress",
                "Prompt",
                "Scene",
                "SessionState",
                "Speech",
                "Stop",
                "Task",
                "WizardAnswer",
                "WizardCommand",
                "WizardDemonstration",
                "WizardGripper",
                "WizardHanded",
                "WizardOverwrite",
                "WizardPointed",
                "WizardReply",
                "WizardRevision",
            )
        ),
    }
)
_FACTS = ("task", "seed", "platform", "fingerprint", "slimmed", "plan.condition", "plan.position")
_PERSONAL = frozenset({"session", "participant", "bag", "state_dir", "node_state_dir", "room_dir"})


class SharedPictures(StrEnum):
    """What of pictures and point clouds a copy keeps."""

    NONE = "none"
    TABLE = "table"  # what lies in the table's volume, without the faces that are found
    WHOLE = "whole"  # for who has the consent of everybody that they show


def why_left_out(msgtype: str, pictures: SharedPictures) -> str:
    """Why messages of a type are not copied; "" when they are.

    Args:
        msgtype: ``package/msg/Type``.
        pictures: what is kept of them.
    """
    if msgtype in PICTURES:
        return "pictures may show a person" if pictures is SharedPictures.NONE else ""
    if msgtype == "mbd_msgs/msg/WizardNote":
        return "free text"
    if msgtype in ("rcl_interfaces/msg/Log", "rcl_interfaces/msg/ParameterEvent", "std_msgs/msg/String"):
        return "free text"
    return "" if msgtype in KEPT_TYPES else "not known to be free of personal data"


def shared_facts(facts: Mapping[str, str], names: NameFinder) -> tuple[dict[str, str], tuple[str, ...]]:
    """The facts that a copy keeps, and the keys of those left out.

    Args:
        facts: of the session.
        names: that must not be read in whatever text.
    """
    kept = {
        key: text
        for key, text in facts.items()
        if (key in _FACTS and not names.within(text))
        or key.startswith("version.")
        or (key.startswith("parameter.") and key.rpartition(".")[2] not in _PERSONAL and not _says(text, names))
    }
    return kept, tuple(key for key in facts if key not in kept and key not in ("session", "participant"))


def _says(parameter: str, names: NameFinder) -> bool:
    """Whether a parameter that is a text holds one of these names; a number that looks like one does not."""
    try:
        value = bounded_yaml(parameter)
    except ValueError:
        return True
    return any(isinstance(v, str) and names.within(v) for v in (value if isinstance(value, list) else [value]))
