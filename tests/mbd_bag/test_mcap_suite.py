"""Every file of MCAP's conformance suite is read as its description says."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import pytest
from mbd_bag.errors import BagError
from mbd_bag.repairing.copying import copy_intact
from mbd_bag.repairing.intact_records import intact_records
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.mcap_file import McapFile
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap_suite import DIGESTS, SuiteFile, suite

FILES = tuple(suite())


def described(file: SuiteFile, kind: type) -> list[object]:
    return [r for r in file.records if isinstance(r, kind)]


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("suite")
    paths = {file.name: folder / f"{file.name}.mcap" for file in FILES}
    for file in FILES:
        paths[file.name].write_bytes(file.data)
    return paths


def test_what_is_written_from_the_descriptions_is_the_suite_byte_for_byte():
    digests = dict(line.split() for line in DIGESTS.read_text().splitlines())
    assert len(digests) == 416
    assert {f.name: sha256(f.data).hexdigest()[:16] for f in FILES} == digests


def test_every_file_is_complete_and_read_as_described(stored: dict[str, Path]):
    for file in FILES:
        opened = McapFile(stored[file.name], of_ros=False)
        assert opened.check() == "", file.name
        assert opened.complete, file.name
        read = [(m.topic, m.log_time, m.publish_time, m.data) for m in opened.messages()]
        messages = [("example", m.log_time, m.publish_time, m.data) for m in described(file, Message)]
        assert read == sorted(messages, key=lambda m: m[1]), file.name
        assert list(opened.contents.channels.values()) == described(file, Channel), file.name
        assert list(opened.contents.schemas.values()) == described(file, Schema), file.name
        # Where statistics state that there is metadata and no index leads to it, all of the file is read for it.
        assert [record for record, _ in opened.contents.metadata] == described(file, Metadata), file.name


def test_every_record_survives_a_repair(stored: dict[str, Path], tmp_path: Path):
    for file in FILES:
        found = intact_records(memoryview(file.data))
        assert (found.damages, found.attachments) == (0, described(file, Attachment)), file.name
        out = tmp_path / f"{file.name}.mcap"
        assert copy_intact(stored[file.name], out).kept == len(described(file, Message)), file.name
        with out.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            copied = [message for _, _, message in reader.iter_messages(log_time_order=False)]
            assert list(reader.iter_attachments()) == described(file, Attachment), file.name
            assert list(reader.iter_metadata()) == described(file, Metadata), file.name
        assert [(m.sequence, m.log_time, m.publish_time, m.data) for m in copied] == [
            (m.sequence, m.log_time, m.publish_time, m.data) for m in described(file, Message)
        ], file.name


def test_none_of_them_is_taken_for_a_session(stored: dict[str, Path]):
    for path in stored.values():
        with pytest.raises(BagError, match="expected a ROS 2 bag"):
            Bag(path)
