"""How a session's nodes exchange their messages: images through shared memory, all else through sockets."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
WITH_IMAGES = "fastdds_profile.xml"
SMALL = "fastdds_small_profile.xml"


def profile_variables(environment: Mapping[str, str], *, images: bool) -> dict[str, str]:
    """What to set for a node so that killing it harms no other.

    Once, on a loaded machine, a cell was found waiting for good in Fast DDS's ``regenerate_port`` for a lock in shared
    memory. That a killed node held it is likely, not proven. Only images are too large for sockets.

    Args:
        environment: variables of the session's nodes.
        images: whether the node gives or takes images or clouds.

    Returns:
        The variable to change; empty when the node takes images, or the user chose a profile of his own.
    """
    chosen = Path(environment.get(VARIABLE, ""))
    if images or chosen.name != WITH_IMAGES:
        return {}
    return {VARIABLE: str(chosen.with_name(SMALL))}
