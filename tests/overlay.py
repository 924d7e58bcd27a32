"""The tests need the complete overlay; `colcon test` offers those of a package only what the package depends on.

They use more than their package: a recorder of ``mbd_bag`` is tested with the synthetic session of ``mbd_study``, a
node with a private domain of ``mbd_bringup``. package.xml cannot declare it, for it would be a circle.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

# Every package of ours depends on the first, and the second on every other.
LOWEST, HIGHEST = "mbd_msgs", "mbd_bringup"


def prefix_of(package: str) -> Path | None:
    """The folder of AMENT_PREFIX_PATH that the package is installed in, or None."""
    for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if entry and (Path(entry) / "share" / package / "package.xml").exists():
            return Path(entry)
    return None


def complete() -> None:
    """Take over what the overlay's own setup file sets, unless all of it is there already.

    Raises:
        SystemExit: the overlay is not built, or not all of it.
    """
    lowest = prefix_of(LOWEST)
    if lowest and prefix_of(HIGHEST):
        return
    setup = lowest.parent / "local_setup.bash" if lowest else None
    if setup is None or not setup.exists() or not (setup.parent / HIGHEST).is_dir():
        raise SystemExit(
            f"the tests need every package of this workspace, and {HIGHEST} is not built here:"
            " run `make build` (or `colcon build` without --packages-select) first"
        )
    script = 'source "$0" >&2 && env -0'
    done = subprocess.run(["bash", "-c", script, setup], capture_output=True, text=True, check=True)
    os.environ.update(entry.split("=", 1) for entry in done.stdout.split("\0") if entry)
    known = set(sys.path)
    sys.path += [p for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p and p not in known]
    importlib.invalidate_caches()
