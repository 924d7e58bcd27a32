"""``room_sync SESSION…``: by how much films of the room and their bags differ, by the test signals in both."""

from __future__ import annotations

from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.session.command_line import note, run_tool
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_paths import bags_below
from mbd_model.command_line.parser import CommandParser
from mbd_model.room.recording import RoomError, read_room_recording
from rich.console import Console

from mbd_study.room.films import films_beside, marked_signals
from mbd_study.room.offsets import FilmOffsets, SignalOffset, film_offsets

WITHIN = 0.040  # [s]
APART = 1


def signal_line(signal: SignalOffset) -> str:
    """A test signal in words."""
    which = f"test signal {signal.number}"
    if signal.marked is None:
        return f"{which}: it is not marked in the bag"
    if signal.offset is None:
        return f"{which}: it is not in the film's sound"
    way = "after" if signal.offset >= 0 else "before"
    line = f"{which}: the film has it {abs(signal.offset) * 1e3:.1f} ms {way} the bag"
    line += f" (clocks known to {signal.uncertainty * 1e3:.1f} ms)"
    if signal.by_air is not None:
        line += f"; speaker, air and microphone add {signal.by_air * 1e3:.0f} ms"
    return line


def film_line(film: Path, found: FilmOffsets) -> str:
    """A film in words: what it has, and whether it goes with the bag."""
    what = "sound and picture" if found.pictures else "sound"
    measured = [s for s in found.signals if s.offset is not None]
    if not measured:
        return f"{film.name}: {found.seconds:.0f} s of {what}; no test signal is in film and bag, so nothing is known"
    worst = found.worst * 1e3
    words = f"within {WITHIN * 1e3:.0f} ms" if found.worst <= WITHIN else f"MORE than {WITHIN * 1e3:.0f} ms"
    return f"{film.name}: {found.seconds:.0f} s of {what}; at most {worst:.1f} ms from the bag, {words}"


def compared(bag: Path, films: tuple[Path, ...], console: Console) -> bool:
    """Print how films stand to their bag; whether all are near enough."""
    well = True
    try:
        marked = marked_signals(Bag(bag))
    except BagError as error:
        note(f"{bag} is not compared: {error}", console)
        return False
    for film in films:
        try:
            found = film_offsets(film, read_room_recording(film.with_suffix(".json")), marked.get(film.stem, {}))
        except RoomError as error:
            note(f"{film.name} is not compared: {error}", console)
            well = False
            continue
        console.print(film_line(film, found), highlight=False, markup=False, soft_wrap=True)
        for signal in found.signals:
            console.print(f"  {signal_line(signal)}", highlight=False, markup=False, soft_wrap=True)
        if found.signals and all(signal.by_air is None for signal in found.signals):
            console.print("  the microphone did not pick up the speaker: what both add is not known", highlight=False)
        well = well and found.worst <= WITHIN
    return well


def _tool() -> int:
    parser = CommandParser(prog="room_sync", description=__doc__)
    parser.add_argument("sessions", type=Path, nargs="+", help="folders of sessions, or their bags")
    console = Console()
    given: list[Path] = parser.parse_args().sessions
    if missing := [str(path) for path in given if not path.exists()]:
        raise RoomError(f"there is no {', '.join(missing)}; give folders of sessions, or their bags")
    pairs = [(bag, films_beside(bag)) for bag in bags_below(given)]
    filmed = [(bag, films) for bag, films in pairs if films]
    if not filmed:
        raise RoomError(
            "no film room_<n>.webm lies beside these bags; the console's switch “Record the room” or "
            "`room_device` makes one, and it must stay beside the folder of the bag"
        )
    well = [compared(bag, films, console) for bag, films in filmed]  # all of them, also after one that is amiss
    return 0 if all(well) else APART


def main() -> None:
    """Entry point: exit code 0; 1 above 40 ms, or where nothing can be measured; 2 when there is nothing to measure."""
    run_tool("room_sync", _tool)
