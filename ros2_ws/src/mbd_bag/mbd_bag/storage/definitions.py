"""Message definitions as a bag embeds them (MCAP's ``ros2msg`` schemas), from the installed .msg files.

The text of a type is its own .msg file, then each type it uses (directly or not) once, after a line of 80 ``=`` and a
line ``MSG: package/Type``: what rosbag2 writes, so that any reader can decode the bag without our packages.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.share_folder import share_folder

from mbd_bag.errors import BagError

SEPARATOR = "=" * 80
_NUMBERS = {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)} | {"float32", "float64"}
_BASE_TYPES = _NUMBERS | {"bool", "byte", "char", "string", "wstring"}
_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]\w*")

ShareDirectory = Callable[[str], Path]


def installed_share(package: str) -> Path:
    """The share directory of an installed package; raises BagError when it is not installed."""
    try:
        return share_folder(package)
    except MbdError as error:
        raise BagError(
            f"package '{package}' is not installed, so its message definitions cannot be embedded; "
            f"source the workspace that has it (source env.sh)"
        ) from error


def _file(msgtype: str, suffix: str, share: ShareDirectory) -> Path:
    try:
        package, kind, name = msgtype.split("/")
    except ValueError as error:
        raise BagError(f"'{msgtype}' is no message type; expected package/msg/Type") from error
    path = share(package) / kind / f"{name}{suffix}"
    if not path.is_file():
        raise BagError(f"no {path.name} of type '{msgtype}' is installed; build the package that defines it")
    return path


def used_types(text: str, package: str) -> list[str]:
    """Full names of the message types that fields of this .msg text have, in order, each once.

    Args:
        text: one .msg file.
        package: the package it belongs to, for names without one.
    """
    found: dict[str, None] = {}
    for line in text.splitlines():
        match = _FIELD.match(line.split("#", 1)[0])
        if match is None or match[1] in _BASE_TYPES:
            continue
        parts = match[1].split("/")
        owner = parts[0] if len(parts) > 1 else ("std_msgs" if parts[0] == "Header" else package)
        found[f"{owner}/msg/{parts[-1]}"] = None
    return list(found)


def full_definition(msgtype: str, share: ShareDirectory = installed_share) -> str:
    """The text of a type with everything it uses; raises BagError when a part is not installed.

    Args:
        msgtype: ``package/msg/Type``.
        share: gives a package's share directory.
    """
    texts: dict[str, str] = {}
    waiting = [msgtype]
    while waiting:
        current = waiting.pop(0)
        if current in texts:
            continue
        texts[current] = _file(current, ".msg", share).read_text(encoding="utf-8").rstrip("\n")
        waiting += used_types(texts[current], current.split("/", maxsplit=1)[0])
    own, *others = texts.items()
    parts = [own[1]]
    for name, text in others:
        package, _, short = name.split("/")
        parts.append(f"{SEPARATOR}\nMSG: {package}/{short}\n{text}")
    return "\n".join(parts) + "\n"


def type_hash(msgtype: str, share: ShareDirectory = installed_share) -> str:
    """The type's REP-2011 hash (``RIHS01_...``); raises BagError when its .json states none."""
    path = _file(msgtype, ".json", share)
    description = json.loads(path.read_text(encoding="utf-8"))
    for entry in description.get("type_hashes", []):
        if entry.get("type_name") == msgtype:
            return str(entry["hash_string"])
    raise BagError(f"{path.name} has no hash of '{msgtype}'; rebuild the package that defines it")
