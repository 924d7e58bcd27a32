"""``share BAG… --out FOLDER``: copies to give away, under new names, without pictures and a person's words.

With ``--cameras`` of the pictures what lies in the table's volume, without the faces that are found.
"""

from __future__ import annotations

import csv
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from mbd_bag.errors import BagError
from mbd_bag.session.command_line import note, run_tool
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.command_line.parser import CommandParser
from mbd_model.errors import MbdError
from rich.console import Console

from mbd_study.plan.schedule import planned_sessions
from mbd_study.plan.study_plan import read_plan
from mbd_study.room.films import films_beside
from mbd_study.sharing.pictures.cover import CoverCounts
from mbd_study.sharing.pictures.faces import FaceFinder
from mbd_study.sharing.pseudonyms import SessionToShare, new_participants, new_sessions
from mbd_study.sharing.rules import SharedPictures
from mbd_study.sharing.shared_copy import Omissions, shared_copy

INCOMPLETE = 1


def _of(bag: Bag, planned: Mapping[str, str]) -> SessionToShare:
    name = bag.facts.get("session") or bag.path.name
    # Without a pseudonym every session counts as another person's: nothing says that two are of one.
    return SessionToShare(name, bag.facts.get("participant") or name, bag.start, planned.get(name, ""))


def _beside(paths: Sequence[Path], given: Sequence[Path]) -> list[str]:
    """Names of files that lie beside the bags, below what was given: none is copied; nor is a film of the room."""
    bags = {path.resolve() for path in paths}
    below = [folder.resolve() for folder in given if folder.is_dir() and folder.resolve() not in bags]
    found = [
        f"{film.parent.name}/{film.name}"
        for path in paths
        for film in films_beside(path)
        if not any(folder in film.parents for folder in below)
    ]
    for folder in given:
        if not folder.is_dir() or folder.resolve() in bags:
            continue
        for path in sorted(folder.rglob("*")):
            if path.is_file() and not any(parent.resolve() in bags for parent in path.parents):
                found.append(path.relative_to(folder).as_posix())
    return found


def _print_left_out(copies: Sequence[Omissions], console: Console) -> None:
    """What all copies together lack, a line each."""
    topics: dict[tuple[str, str], int] = {}
    blanked: dict[str, int] = {}
    facts: dict[str, int] = {}
    for copy in copies:
        for topic, (why, count) in copy.topics.items():
            topics[topic, why] = topics.get((topic, why), 0) + count
        for key, count in copy.blanked.items():
            blanked[key] = blanked.get(key, 0) + count
        for key in copy.facts:
            facts[key] = facts.get(key, 0) + 1
    lines = [f"left out: {topic}, {count} messages: {why}" for (topic, why), count in sorted(topics.items())]
    lines += [f"emptied, or without names: {key}, {count} texts" for key, count in sorted(blanked.items())]
    if facts:
        lines.append(f"left out: facts {', '.join(sorted(facts))}")
    for line in lines:
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def _print_covered(all_counts: Sequence[CoverCounts], console: Console) -> None:
    """What was done with the pictures, and what that cannot promise."""
    pictures = sum(counts.pictures for counts in all_counts)
    if not pictures:
        return
    faces, with_faces = sum(c.faces for c in all_counts), sum(c.with_faces for c in all_counts)
    words = f"covered: {pictures} pictures and clouds, all but the table's volume; {faces} faces found in {with_faces}"
    console.print(words, highlight=False, markup=False, soft_wrap=True)
    blind = sum(counts.by_direction for counts in all_counts)
    if blind:
        words = (
            "have no distances of their moment: whatever is before the table stays in them, faces that are found not"
        )
        note(f"{blind} of them {words}", console)
    note(
        "not every face is found (profiles, half-covered ones): look at the pictures before you give them away", console
    )


def _names_in(path: Path | None) -> list[str]:
    """The names in a file; raises BagError when it cannot be read."""
    if path is None:
        return []
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BagError(f"{path} cannot be read ({error}); expected a text file in UTF-8, a name a line") from error


def _write_key(path: Path, rows: Sequence[tuple[str, str, str, str]]) -> None:
    """Old and new names, for whoever may know both; raises BagError when the file exists or cannot be written."""
    try:
        with path.open("x", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(("participant", "session", "shared_participant", "shared_session"))
            writer.writerows(rows)
    except FileExistsError as error:
        raise BagError(f"{path} exists already and is not overwritten; choose another --key") from error
    except OSError as error:
        raise BagError(f"{path} cannot be written: {error.strerror}; choose another --key") from error


def _arguments() -> Namespace:
    """What was asked for; raises BagError for places that cannot be taken."""
    parser = CommandParser(prog="share", description=__doc__)
    parser.add_argument("bags", type=Path, nargs="+", help="bags, or folders of bags")
    parser.add_argument("--out", type=Path, required=True, help="folder of the copies; it must not exist")
    parser.add_argument(
        "--cameras",
        nargs="?",
        choices=[kept.value for kept in SharedPictures],
        default=SharedPictures.NONE.value,
        const=SharedPictures.TABLE.value,
        help="keep the pictures: 'table' (when no word follows) covers what is outside of the workspace, and faces; "
        "'whole' covers nothing, for who has everybody's consent",
    )
    parser.add_argument("--plan", type=Path, help="the study's plan: planned sessions keep condition and task as names")
    parser.add_argument("--key", type=Path, help="write old and new names here; keep it apart from the copies")
    parser.add_argument("--names", type=Path, help="text file of more names that must not be read, one a line")
    parser.add_argument("--seed", type=int, help="of the new pseudonyms; by chance without it")
    arguments = parser.parse_args()
    arguments.cameras = SharedPictures(arguments.cameras)
    out: Path = arguments.out
    if out.exists():
        raise BagError(f"{out} exists already and is not overwritten; choose another --out")
    if arguments.key is not None and out.resolve() in (arguments.key.resolve(), *arguments.key.resolve().parents):
        raise BagError(f"the key {arguments.key} would be given away with the copies; choose a place outside of {out}")
    if arguments.key is not None and arguments.key.exists():
        # Reported before many bags are copied, not after.
        raise BagError(f"{arguments.key} exists already and is not overwritten; choose another --key")
    if arguments.seed is not None and arguments.seed < 0:
        raise BagError(f"--seed is {arguments.seed}; expected a whole number from 0")
    if arguments.cameras is SharedPictures.TABLE:
        FaceFinder()  # reported before many bags are copied
    return arguments


def _tool() -> int:
    arguments, console = _arguments(), Console()
    out: Path = arguments.out
    planned = {}
    if arguments.plan is not None:
        planned = {p.session: f"{p.condition}_{p.task}" for p in planned_sessions(read_plan(arguments.plan))}
    paths = list(bags_below(arguments.bags))
    bags, failures = [], []
    for path in paths:
        try:
            bags.append(Bag(path))
        except MbdError as error:
            failures.append(f"{path} is not copied: {error}")
    sessions = [_of(bag, planned) for bag in bags]
    people = new_participants([s.participant for s in sessions], np.random.default_rng(arguments.seed))
    names = new_sessions(sessions, people)
    # A session may name the participant of another.
    known = {*_names_in(arguments.names), *(s.participant for s in sessions), *(s.session for s in sessions)}
    copies, key = [], []
    for bag, one, name in zip(bags, sessions, names, strict=True):
        participant = people[one.participant]
        try:
            copy = shared_copy(
                bag,
                out / name / "bag",
                session=name,
                participant=participant,
                names=known,
                pictures=arguments.cameras,
            )
        except MbdError as error:
            failures.append(f"{bag.path} is not copied: {error}")
            continue
        copies.append(copy)
        key.append((one.participant, one.session, participant, name))
    if not copies:
        raise BagError("; ".join(failures))
    if arguments.key is not None:
        _write_key(arguments.key, key)
    console.print(f"wrote {len(copies)} of {len(paths)} sessions to {out}", highlight=False, soft_wrap=True)
    _print_left_out(copies, console)
    beside = _beside(paths, arguments.bags)
    if beside:
        words = f"left out: {len(beside)} files beside the bags: {', '.join(beside[:20])}"
        console.print(words + (", ..." if len(beside) > 20 else ""), highlight=False, markup=False, soft_wrap=True)
    films = sum(len(films_beside(path)) for path in paths)
    if films:
        note(f"{films} films of the room lie beside the bags (room_<n>.webm): none is in the copies", console)
    if arguments.cameras is SharedPictures.WHOLE:
        note("the pictures are kept as they are: look at each for faces before you give them away", console)
    _print_covered([copy.covered for copy in copies if copy.covered is not None], console)
    note("the times of the messages are kept, and with them the date of each session", console)
    for failure in failures:
        note(failure, console)
    return INCOMPLETE if failures else 0


def main() -> None:
    """Entry point: exit code 0; 1 when a bag is not copied; 2 when nothing can be."""
    run_tool("share", _tool)
