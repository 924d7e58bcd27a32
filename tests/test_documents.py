"""The documents: lines of one width, and the furniture of a project in the forms that tools read."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from catkin_pkg.package import parse_package

ROOT = Path(__file__).resolve().parents[1]
CHECK = ROOT / "tools" / "check_documents"
VERSION = parse_package(ROOT / "ros2_ws" / "src" / "mbd_msgs").version


def check(*files: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, CHECK, *files], capture_output=True, text=True, check=False)


def test_no_line_of_a_document_is_over_120_characters():
    if not (ROOT / ".git").exists():
        pytest.skip("not a git checkout: there is no list of tracked files")
    done = check()
    assert done.returncode == 0, done.stderr


def test_a_line_of_121_characters_is_named_and_one_of_120_is_not(tmp_path: Path):
    page = tmp_path / "page.md"
    page.write_text("x" * 120 + "\n| " + "ü" * 117 + " |\n")
    done = check(page)
    assert (done.returncode, done.stderr.splitlines()[0]) == (1, f"{page}:2: 121 characters")


def test_changelog_citation_and_every_package_have_the_same_version():
    assert re.search(rf"^## \[{re.escape(VERSION)}\] - \d{{4}}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == VERSION
    for package in (ROOT / "ros2_ws" / "src").glob("*/package.xml"):
        assert parse_package(package).version == VERSION, package


def test_the_changelog_has_the_headings_of_keep_a_changelog():
    headings = re.findall(r"^### (.+)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    allowed = {"Added", "Changed", "Deprecated", "Removed", "Renamed", "Fixed", "Security"}
    assert headings
    assert set(headings) <= allowed


def test_the_citation_has_what_its_format_demands():
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= set(cff)
    assert cff["cff-version"] == "1.2.0"
    (paper,) = cff["references"]
    assert {"type", "title", "authors"} <= set(paper)
    assert [author["family-names"] for author in paper["authors"]] == ["Fitzgerald", "Goel", "Thomaz"]


def test_pre_commit_fetches_nothing_and_names_tools_that_are_there():
    config = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())
    assert [repository["repo"] for repository in config["repos"]] == ["local"]
    for hook in config["repos"][0]["hooks"]:
        assert hook["language"] == "system"
        for word in hook["entry"].split():
            if word.startswith((".venv/", "tools/")):
                assert (ROOT / word).exists(), f"{hook['id']}: {word}"


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda p: p.name)
def test_every_page_is_in_the_sites_navigation_and_in_the_readme(page: Path):
    assert re.search(rf"^ *- {re.escape(page.name)}$", (ROOT / "mkdocs.yml").read_text(), re.M)
    assert f"docs/{page.name}" in (ROOT / "README.md").read_text()


PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "SECURITY.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_file_of_ours_that_it_names_is_there(page: Path):
    """``mbd_mapping/mbd.py``, relative to the package's modules or to the package itself; ``tests/…`` to the root."""
    text = page.read_text()
    source = ROOT / "ros2_ws" / "src"
    named = set(re.findall(r"`((?:mbd_\w+|tests|tools|requirements|benchmarks)/[\w./-]*\w/?)`", text))
    gone = {
        name
        for name in named
        if not any((base / name).exists() for base in (ROOT, source, source / name.partition("/")[0]))
    }
    assert gone == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_module_that_it_names_is_there(page: Path):
    """``plane.py`` alone is enough where the page is about one package."""
    modules = {
        f"/{file.relative_to(ROOT)}"
        for top in ("ros2_ws/src", "tests", "benchmarks")
        for file in (ROOT / top).rglob("*.py")
    }
    named = set(re.findall(r"`([\w/]*[a-z]\w*\.py)`", page.read_text())) - {"setup.py"}
    named = {name for name in named if not name.startswith("_")}
    assert {name for name in named if not any(module.endswith(f"/{name}") for module in modules)} == set()
