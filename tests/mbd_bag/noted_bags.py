"""Small bags of notes, as tests write and read them."""

from __future__ import annotations

from pathlib import Path

from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_msgs.msg import WizardNote


def write_notes(folder: Path, count: int, start: int = 0, **options: object) -> None:
    """Notes of 1 ns each, flushed (which ends a chunk) after every third."""
    with BagWriter(folder, **options) as bag:
        bag.add_facts({"session": "notes"})
        writer = MessageWriter(bag)
        for k in range(start, start + count):
            writer.write("/wizard/note", WizardNote(text=f"note {k}"), k)
            writer.write("/other/note", WizardNote(text=f"other {k}"), k)
            if k % 3 == 2:
                bag.flush()


def texts(path: Path) -> list[str]:
    return [msg.text for _, msg in Bag(path).decoded({"/wizard/note"})]


def cut_to(folder: Path, size: int) -> None:
    write_notes(folder, 3)
    (folder / "metadata.yaml").unlink()
    file = folder / f"{folder.name}_0.mcap"
    file.write_bytes(file.read_bytes()[:size])
