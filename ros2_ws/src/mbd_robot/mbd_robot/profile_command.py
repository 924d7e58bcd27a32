"""Robots and cameras that the suite knows, as a table; or one of them, as it was understood."""

from __future__ import annotations

import dataclasses
import enum
import sys
from collections.abc import Iterator, Sequence

from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError

from mbd_robot.profiles.find import camera_names, camera_profile, robot_names, robot_profile


def main(words: Sequence[str] | None = None) -> None:
    """Entry point: exit code 1 for a profile that cannot be used."""
    parser = CommandParser(prog="profile", description=__doc__)
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--robot", help="name of a robot, or path of a file: print what it says, or what is wrong")
    kind.add_argument("--camera", help="the same of a camera")
    arguments = parser.parse_args(words)
    try:
        if arguments.robot:
            lines = list(entries(robot_profile(arguments.robot)))
        elif arguments.camera:
            lines = list(entries(camera_profile(arguments.camera)))
        else:
            lines = list(overview())
    except MbdError as error:
        sys.stderr.write(f"profile: {error}\n")
        sys.exit(1)
    sys.stdout.write("\n".join(lines) + "\n")


def overview() -> Iterator[str]:
    """A line for each robot and camera of ours."""
    yield "robots"
    for name in robot_names():
        robot = robot_profile(name)
        yield f"  {name:20} {robot.title} ({robot.tested})"
    yield "cameras"
    for name in camera_names():
        camera = camera_profile(name)
        yield f"  {name:20} {camera.title} ({camera.tested})"


def entries(value: object, indent: str = "") -> Iterator[str]:
    """A profile's keys and values, one a line, sections indented."""
    for field in dataclasses.fields(value):  # type: ignore[arg-type]
        inner = getattr(value, field.name)
        if dataclasses.is_dataclass(inner):
            yield f"{indent}{field.name}:"
            yield from entries(inner, indent + "  ")
        elif isinstance(inner, tuple) and inner and dataclasses.is_dataclass(inner[0]):
            for number, part in enumerate(inner, start=1):
                yield f"{indent}{field.name} {number}:"
                yield from entries(part, indent + "  ")
        else:
            shown = inner.value if isinstance(inner, enum.Enum) else inner
            yield f"{indent}{field.name}: {list(shown) if isinstance(shown, tuple) else shown}"
