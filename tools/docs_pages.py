"""A hook of MkDocs: pages that lie outside docs/, and a page of API for each folder of modules, from docstrings."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from mkdocs.structure.files import File, Files

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "ros2_ws" / "src"
# Where each page lies in the repository, and its name in the site.
ELSEWHERE = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "bags/README.md": "sample_bags.md",
}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Add the API pages to the navigation, package by package."""
    if config.nav is None:
        raise ValueError("mkdocs.yml has no nav: the API pages are added to it")
    config.nav.append({"API": [{package: [*pages]} for package, pages in api_pages().items()]})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages made here to those that MkDocs found."""
    for source, name in ELSEWHERE.items():
        files.append(File.generated(config, name, content=moved((ROOT / source).read_text(), source)))
    for pages in api_pages().values():
        for name, folder in pages_of(pages).items():
            files.append(File.generated(config, name, content=api_page(folder)))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """A link out of docs/ to one of the pages that lie elsewhere leads to its copy in the site."""
    for source, name in ELSEWHERE.items():
        markdown = markdown.replace(f"](../{source}", f"]({name}")
    return markdown


def moved(text: str, source: str) -> str:
    """The page with each link to another page or picture as it is seen from the site's root."""
    folder = (ROOT / source).parent

    def link(match: re.Match[str]) -> str:
        path, _, anchor = match.group(1).partition("#")
        if "://" in path or not path:
            return match.group(0)
        target = (folder / path).resolve().relative_to(ROOT).as_posix()
        target = ELSEWHERE.get(target, target.removeprefix("docs/"))
        return f"]({target}{'#' if anchor else ''}{anchor})"

    return re.sub(r"\]\(([^)]+)\)", link, text)


def api_pages() -> dict[str, list[dict[str, str]]]:
    """For each package its pages: title (the folder's import name) to name in the site."""
    pages: dict[str, list[dict[str, str]]] = {}
    for package in sorted(p.parent.name for p in SRC.glob("*/setup.py")):
        folders = sorted(
            {file.parent for file in (SRC / package / package).rglob("*.py") if file.name != "__init__.py"}
        )
        names = [".".join(folder.relative_to(SRC / package).parts) for folder in folders]
        pages[package] = [{name: f"api/{name}.md"} for name in names]
    return pages


def pages_of(pages: list[dict[str, str]]) -> dict[str, Path]:
    """Each page's name in the site, and the folder of modules it is about."""
    named = {file: title for page in pages for title, file in page.items()}
    return {file: SRC / title.partition(".")[0] / title.replace(".", "/") for file, title in named.items()}


def api_page(folder: Path) -> str:
    """Markdown that has mkdocstrings write what the folder's modules offer."""
    package = next(part for part in folder.parts[len(SRC.parts) :])
    name = ".".join(folder.relative_to(SRC / package).parts)
    modules = [f.stem for f in sorted(folder.glob("*.py")) if f.stem not in {"__init__", "__main__"}]
    return f"# {name}\n\n" + "\n".join(f"::: {name}.{module}\n" for module in modules)
