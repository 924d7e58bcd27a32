"""SECURITY.md: its list names every requirement of OWASP ASVS 5.0 level 1, and tests that are there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted([*(ROOT / "ros2_ws" / "src").glob("mbd_*/mbd_*/**/*.py"), *(ROOT / "tools").glob("*.py")])
_NUMBER = r"\b\d+\.\d+\.\d+\b"
STATES = {"holds", "in part", "does not hold", "not there"}
# The numbers of level 1 in ASVS 5.0.0.
_LEVEL_1 = """
1.2.1 1.2.2 1.2.3 1.2.4 1.2.5 1.3.1 1.3.2 1.5.1 2.1.1 2.2.1 2.2.2 2.3.1 3.2.1 3.2.2 3.3.1 3.4.1 3.4.2 3.5.1 3.5.2 3.5.3
4.1.1 4.4.1 5.2.1 5.2.2 5.3.1 5.3.2 6.1.1 6.2.1 6.2.2 6.2.3 6.2.4 6.2.5 6.2.6 6.2.7 6.2.8 6.3.1 6.3.2 6.4.1 6.4.2
7.2.1 7.2.2 7.2.3 7.2.4 7.4.1 7.4.2 8.1.1 8.2.1 8.2.2 8.3.1 9.1.1 9.1.2 9.1.3 9.2.1 10.4.1 10.4.2 10.4.3 10.4.4 10.4.5
11.3.1 11.3.2 11.4.1 12.1.1 12.2.1 12.2.2 13.4.1 14.2.1 14.3.1 15.1.1 15.2.1 15.3.1
"""


def rows() -> list[tuple[str, str, str]]:
    """The list's lines: the requirements, their state, and what shows it."""
    text = re.sub(r"\n  ", " ", (ROOT / "SECURITY.md").read_text())
    return re.findall(r"^- (\d[^;]*); \*\*(.*?)\*\*: (.*)$", text, flags=re.MULTILINE)


def test_every_requirement_of_level_1_has_its_line_and_no_other():
    assert sorted(re.findall(_NUMBER, " ".join(row[0] for row in rows()))) == sorted(re.findall(_NUMBER, _LEVEL_1))
    assert {row[1] for row in rows()} == STATES


def test_every_line_that_holds_names_a_test_that_is_there_or_a_page():
    tests = "".join(file.read_text() for file in (ROOT / "tests").rglob("test_*.py"))
    for requirement, state, shown in rows():
        named = re.findall(r"`(test_\w+)`", shown)
        files = re.findall(r"`(tests/[\w/]+\.py)`|\((docs/[\w/]+\.md)\)", shown)
        assert state != "holds" or named or files, requirement
        assert [name for name in named if f"def {name}(" not in tests] == [], requirement
        assert [file for pair in files for file in pair if file and not (ROOT / file).exists()] == [], requirement


def test_no_command_goes_through_a_shell():
    through = re.compile(r"shell\s*=\s*True|os\.system\(|os\.popen\(|subprocess\.getoutput")
    assert len(SOURCES) > 300
    assert [file for file in SOURCES if through.search(file.read_text())] == []


def test_no_weak_hash_is_used():
    assert [file for file in SOURCES if re.search(r"\b(md5|sha1)\b", file.read_text())] == []
