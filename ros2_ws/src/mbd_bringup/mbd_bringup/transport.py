"""How the nodes of a session exchange messages: by sockets; images that nobody sends again by shared memory."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
SHARED_MEMORY = "fastdds_profile.xml"
SOCKETS, OWN_SOCKETS = "fastdds_small_profile.xml", "fastdds_local_profile.xml"
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def profile_variables(environment: Mapping[str, str], *, shared_memory: bool) -> dict[str, str]:
    """What to set for a node so that killing it harms no other.

    A process killed between taking a message out of shared memory and having read it leaves a mark there, and the next
    one that writes to it spins for good while it holds its own locks (Fast DDS issue 6485, all of Jazzy's versions): a
    cell stood so for ever after perception was killed. Sockets know no such mark. They lose fragments of a burst as
    large as an image on a busy machine, so that only reliable topics get their images through.

    A discovery range of LOCALHOST adds shared memory again, whatever a profile says (rmw_fastrtps 8.4): in its place
    the profile keeps to this machine's own address.

    Args:
        environment: variables of the session's nodes.
        shared_memory: whether the node gives or takes images by best effort: those of a real camera's driver.

    Returns:
        The variables to change; empty when it shares memory, or the user chose a profile of his own.
    """
    chosen = Path(environment.get(VARIABLE, ""))
    if shared_memory or chosen.name != SHARED_MEMORY:
        return {}
    if environment.get(RANGE) == "LOCALHOST":
        return {VARIABLE: str(chosen.with_name(OWN_SOCKETS)), RANGE: "SUBNET"}
    return {VARIABLE: str(chosen.with_name(SOCKETS))}
