"""A profile by its name, or by the path of a user's own file."""

from __future__ import annotations

from pathlib import Path

from mbd_model.parameters import nearest
from mbd_model.share_folder import config_folder

from mbd_robot.profiles.camera import CameraProfile
from mbd_robot.profiles.reading import ProfileError, read_profile
from mbd_robot.profiles.robot import RobotProfile

ROBOT_ENDING, CAMERA_ENDING = ".robot.yaml", ".camera.yaml"
# Of our own profiles and models, beside this package's other configuration.
PACKAGE = "mbd_robot"


def robot_names() -> tuple[str, ...]:
    """Robots that come with this package, by name."""
    return _names(ROBOT_ENDING)


def camera_names() -> tuple[str, ...]:
    """Cameras that come with this package, by name."""
    return _names(CAMERA_ENDING)


def robot_profile(name: str) -> RobotProfile:
    """The robot of that name, or of that file; raises ProfileError when there is none or it cannot be used."""
    return read_profile(RobotProfile, profile_file(name, ROBOT_ENDING, "robot"))


def camera_profile(name: str) -> CameraProfile:
    """The camera of that name, or of that file; raises ProfileError when there is none or it cannot be used."""
    return read_profile(CameraProfile, profile_file(name, CAMERA_ENDING, "camera"))


def profile_file(name: str, ending: str, what: str) -> Path:
    """Where a profile is kept.

    Args:
        name: of a profile of ours, or the path of a file, which has a slash or ends in .yaml.
        ending: of our files' names.
        what: robot or camera, for the text of an error.

    Raises:
        ProfileError: no such name; states the nearest.
    """
    if "/" in name or name.endswith((".yaml", ".yml")):
        return Path(name).expanduser().resolve()
    names = _names(ending)
    if name not in names:
        near = nearest(name, names)
        advice = f"did you mean '{near}'?" if near else f"there are: {', '.join(names)}"
        raise ProfileError(f"no {what} '{name}'; {advice} (or give the path of a file of your own)")
    return config_folder(PACKAGE) / f"{name}{ending}"


def _names(ending: str) -> tuple[str, ...]:
    return tuple(sorted(file.name.removesuffix(ending) for file in config_folder(PACKAGE).glob(f"*{ending}")))
