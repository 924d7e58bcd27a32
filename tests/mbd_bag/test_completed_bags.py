"""What a bag holds outlives the end of who wrote it: repaired, completed, and never half a record."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.formats.contents import FileEnd
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.mcap_completion import complete
from mbd_bag.storage.mcap_file import McapFile
from mbd_bag.storage.message_writer import MessageWriter
from mbd_bag.tools import repair
from mbd_msgs.msg import WizardNote
from noted_bags import cut_to, texts, write_notes
from rosbags.rosbag2 import Reader


def run_repair(*words: str | Path) -> int:
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr(sys, "argv", ["repair", *map(str, words)])
        repair.main()
    return int(ended.value.code)


@pytest.mark.parametrize("loss", [0, 300])
def test_a_repaired_copy_is_taken_by_other_readers_and_the_bag_stays_as_it_was(loss: int, tmp_path: Path):
    folder = tmp_path / "bag"
    write_notes(folder, 12)
    (folder / "metadata.yaml").unlink()
    file = folder / "bag_0.mcap"
    end = McapFile(file).contents.chunks[-1].chunk_start_offset
    file.write_bytes(file.read_bytes()[: end - loss])
    before = file.read_bytes()
    assert run_repair(folder) == 0
    assert [p.read_bytes() for p in folder.iterdir()] == [before]
    copy = tmp_path / "bag_repaired"
    assert Bag(copy).problems == ()
    assert Bag(copy).facts["session"] == "notes"
    assert texts(copy) == texts(folder) == [f"note {k}" for k in range(9 if loss == 0 else 6)]
    with Reader(copy) as reader:
        assert reader.message_count == len(list(reader.messages())) == 2 * len(texts(copy))
    assert run_repair(folder) == 2  # the copy is not overwritten
    assert run_repair(copy) == 0  # nothing to do
    assert not (tmp_path / "bag_repaired_repaired").exists()


def test_what_holds_nothing_is_not_repaired(tmp_path: Path):
    cut_to(tmp_path / "bag", 0)
    assert run_repair(tmp_path / "bag") == 2
    assert [p.name for p in tmp_path.iterdir()] == ["bag"]


def test_a_damaged_bag_is_repaired_but_for_its_damaged_chunk(tmp_path: Path):
    folder = tmp_path / "bag"
    write_notes(folder, 12)
    (folder / "metadata.yaml").unlink()
    file = folder / "bag_0.mcap"
    third = McapFile(file).contents.chunks[2]
    data = bytearray(file.read_bytes()[:-8])
    data[third.chunk_start_offset + third.chunk_length - 20] ^= 0xFF
    file.write_bytes(data)
    assert run_repair(folder, "--out", tmp_path / "copy") == 0
    assert texts(tmp_path / "copy") == [f"note {k}" for k in (*range(6), *range(9, 12))]
    assert Bag(tmp_path / "copy").problems == ()


@pytest.mark.parametrize("name", ["bag", "damaged"])
def test_a_cut_file_is_completed_and_a_damaged_one_is_not_whatever_they_are_called(name: str, tmp_path: Path):
    write_notes(tmp_path / name, 12)
    cut, damaged = tmp_path / name / f"{name}_0.mcap", tmp_path / f"{name}_1.mcap"
    data = bytearray(cut.read_bytes()[:-8])
    third = McapFile(cut).contents.chunks[2]
    cut.write_bytes(data)
    data[third.chunk_start_offset + third.chunk_length - 20] ^= 0xFF
    damaged.write_bytes(data)
    assert (McapFile(cut).contents.ends, McapFile(damaged).contents.ends) == (FileEnd.CUT_OFF, FileEnd.DAMAGED)
    assert complete(cut).complete
    with pytest.raises(BagError, match="repair"):
        complete(damaged)


@given(flushed=st.integers(0, 5), more=st.integers(0, 3))
def test_a_process_that_ends_anywhere_leaves_complete_records(
    flushed: int, more: int, tmp_path_factory: pytest.TempPathFactory
):
    """Read while the writer is at work: just what a killed one would leave."""
    folder = tmp_path_factory.mktemp("killed") / "bag"
    bag = BagWriter(folder)
    writer = MessageWriter(bag)
    for k in range(flushed + more):
        writer.write("/wizard/note", WizardNote(text=f"note {k}"), k)
        if k < flushed:
            bag.flush()
    left = McapFile(bag.path).contents
    bag.close()
    assert left.problem.endswith("all of it is read")
    assert sum(left.counts.values()) == flushed
