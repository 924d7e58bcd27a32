"""The recorder's parameters, and the config they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mbd_model.parameters import ParameterSpec, ParameterTable

from mbd_bag.errors import BagError
from mbd_bag.storage.bag_metadata import read_metadata
from mbd_bag.storage.bag_writer import BagWriter, Compression
from mbd_bag.storage.superseded import supersede

RUN = "run"  # the fact that states it

RECORDER = ParameterTable(
    "recorder",
    (
        ParameterSpec("bag", "", "Folder of the bag to write; it must not exist yet.", required=True),
        # Hidden topics are actions' own.
        ParameterSpec("exclude", (r".*/_[^/]*(/.*)?",), "Regular expressions of complete topic names not to record."),
        ParameterSpec(
            "images",
            "compressed",
            "Colour as JPEG and depth as PNG (compressed), or as they come (raw).",
            choices=("compressed", "raw"),
        ),
        ParameterSpec("clouds", False, "Record point clouds too; colour, depth and camera_info determine them."),
        ParameterSpec("jpeg_quality", 90, "Of compressed colour, which keeps its full resolution.", range=(1, 100)),
        ParameterSpec(
            "image_rate",
            0.0,
            "At most so many images a second of each topic, colour and depth of one moment together; 0: all.",
            "Hz",
            range=(0.0, 1000.0),
        ),
        ParameterSpec("session", "", "Name of the session; the bag's when empty."),
        ParameterSpec("participant", "", "Who teaches (a pseudonym)."),
        ParameterSpec("task", "", "Name of the task."),
        ParameterSpec("seed", 0, "Seed of the simulated session."),
        ParameterSpec("resume", False, "Go on in a finished bag, in its next file."),
        ParameterSpec(
            "redo", False, "Record an existing bag again; the old one is kept as <bag>_superseded_<n>, marked."
        ),
        ParameterSpec(
            "end_with_session",
            False,
            "Close the bag 2 s after the session is DONE or ABORTED; a word of a person that comes later, or the "
            "session that goes on, is recorded in the bag's next file.",
        ),
        ParameterSpec(
            "plan",
            (),
            "Of the study's plan, name=value (condition=mbd, deviation=why, ...): facts of the bag, plan.<name>.",
        ),
        ParameterSpec(
            "run", "", "Names one start of a session: a recorder started again within it goes on in its own bag."
        ),
        ParameterSpec(
            "spool",
            "",
            "Folder of the spool's journal, from which what the recorder missed is taken; nothing is when empty.",
        ),
        ParameterSpec(
            "file_size",
            256.0,
            "Of a file, after which the bag's next begins: what a recorder that was killed left is read again first.",
            "MB",
            range=(1.0, 1e6),
        ),
        ParameterSpec(
            "memory",
            256.0,
            "Of pictures that wait to be written; from half of it on ever fewer are kept. All else is always kept.",
            "MB",
            range=(16.0, 1e6),
        ),
        ParameterSpec("compression", Compression.LZ4.value, "Of the bag's chunks.", choices=tuple(Compression)),
        ParameterSpec(
            "min_free", 500.0, "Free disk space to insist on at the start; warn below.", "MB", range=(0.0, 1e9)
        ),
        ParameterSpec("stop_free", 50.0, "Free disk space below which the bag is closed.", "MB", range=(0.0, 1e9)),
        ParameterSpec("discovery_period", 0.2, "Between looks for new topics.", "s", range=(0.01, 10.0)),
    ),
)


@dataclass(frozen=True)
class RecorderConfig:
    """Parameters of the node; each is described in RECORDER."""

    bag: str
    exclude: tuple[str, ...]
    images: str
    clouds: bool
    jpeg_quality: int
    image_rate: float
    session: str
    participant: str
    task: str
    seed: int
    resume: bool
    redo: bool
    end_with_session: bool
    plan: tuple[str, ...]
    run: str
    spool: str
    file_size: float
    memory: float
    compression: str
    min_free: float
    stop_free: float
    discovery_period: float

    @property
    def plan_facts(self) -> dict[str, str]:
        """What the bag states of the study's plan; raises BagError for a word that is no name=value."""
        facts = {}
        for word in self.plan:
            name, equals, value = word.partition("=")
            if not equals or not name.isidentifier():
                raise BagError(f"parameter plan has {word!r}; expected name=value, as condition=mbd")
            facts[f"plan.{name}"] = value
        return facts

    def open_bag(self, *, again: bool = False) -> BagWriter:
        """The bag to write; raises BagError when it or a parameter cannot be used.

        Args:
            again: go on in it although it was closed, as this recorder did itself.
        """
        if not self.bag:
            raise BagError("no bag to write: give the parameter bag, e.g. --ros-args -p bag:=bags/sorting_1")
        if self.resume and self.redo:
            raise BagError("parameters resume and redo are both true; go on in the bag, or record it again")
        folder = Path(self.bag).expanduser().absolute()
        own = bool(self.run) and run_of(folder) == self.run
        try:
            if self.redo and folder.exists() and not (own or again):
                supersede(folder)
            return BagWriter(
                folder,
                compression=Compression(self.compression),
                resume=self.resume or own or again,
                min_free=int(self.min_free * 1e6),
            )
        except OSError as error:
            raise BagError(
                f"bag {folder} cannot be written ({error.strerror or error}): give a folder that this user may write, "
                "with no file in its place"
            ) from error


def run_of(folder: Path) -> str:
    """Which start of a session a finished bag is of; "" when there is none, or it states none."""
    try:
        return str(read_metadata(folder)["custom_data"].get(RUN, ""))
    except BagError:
        return ""


def recorder_config(values: Mapping[str, Any]) -> RecorderConfig:
    """How a session is recorded, from values of the parameters of RECORDER by name."""
    return RecorderConfig(**values)
