"""Where an installed package keeps its files: the one module outside ``ros/`` that asks the ament index."""

from __future__ import annotations

from pathlib import Path

from mbd_model.errors import MbdError


def share_folder(package: str) -> Path:
    """The share folder of an installed package; raises MbdError when it is not in the overlay."""
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        return Path(get_package_share_directory(package))
    except PackageNotFoundError as error:
        raise MbdError(
            f"package '{package}' is not installed; source the workspace that has it (source env.sh)"
        ) from error


def config_folder(package: str) -> Path:
    """The folder of an installed package's configuration files; raises MbdError when it is not in the overlay."""
    return share_folder(package) / "config"
