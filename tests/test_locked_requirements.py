"""What is locked is what is pinned: each pin, with hashes, and no address of an index; each licence is listed."""

from __future__ import annotations

import re
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LOCK = ROOT / "requirements" / "locked.txt"
FILES = ("ros", "build", "run", "files", "console", "sim", "robot", "cluster", "recordings", "test")
AGAIN = "run tools/lock, then tools/licences --write"


@pytest.fixture(scope="module")
def licences() -> object:
    loader = SourceFileLoader("licences", str(ROOT / "tools" / "licences"))
    module = module_from_spec(spec_from_loader("licences", loader))
    loader.exec_module(module)
    return module


def test_each_pin_is_locked_at_its_version(licences: object):
    locked = licences.pinned(LOCK.read_text())
    wanted: dict[str, str] = {}
    for name in FILES:
        wanted |= licences.pinned((ROOT / "requirements" / f"{name}.txt").read_text())
    assert len(wanted) > 50
    differing = {name: (version, locked.get(name)) for name, version in wanted.items() if locked.get(name) != version}
    assert differing == {}, f"pinned otherwise than locked: {AGAIN}"


def test_the_lock_is_made_of_the_files_that_setup_installs():
    setup = (ROOT / "tools" / "setup").read_text()
    installed = set(re.findall(r"requirements/(\w+)\.txt", setup)) - {"setup", "locked"}
    locked = (ROOT / "tools" / "lock").read_text()
    assert installed == set(FILES)
    assert re.search(r"for name in ([\w ]+);", locked).group(1).split() == list(FILES)


def test_each_locked_file_has_hashes_and_the_lock_names_no_place():
    text = LOCK.read_text()
    packages = re.split(r"^(?=[A-Za-z0-9])", text, flags=re.MULTILINE)[1:]
    assert len(packages) > 300
    assert [p.splitlines()[0] for p in packages if not re.search(r"--hash=sha256:[0-9a-f]{64}", p)] == []
    assert [p.splitlines()[0] for p in packages if not re.match(r"^[A-Za-z0-9._-]+==\S+", p)] == []
    assert re.search(r"--index|--extra-index|--find-links|://| @ ", text) is None


def test_each_locked_package_has_its_licence_on_the_page(licences: object):
    page = (ROOT / "docs" / "licences.md").read_text()
    listed = {
        name: (version, words) for name, version, words in re.findall(r"^\| ([\w-]+) \| (\S+) \| (.*) \|$", page, re.M)
    }
    listed.pop("package")
    locked = licences.pinned(LOCK.read_text())
    assert {name: version for name, (version, _) in listed.items()} == locked, f"another list: {AGAIN}"
    assert all(words for _, words in listed.values())
