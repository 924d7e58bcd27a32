"""What every ament_python package of this workspace installs, written once; each ``setup.py`` calls ``install``."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from glob import glob
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup
from setuptools.command.sdist import sdist


class SdistWithThisFile(sdist):
    """A source distribution is built where this workspace is not: it takes this file along, and what it reads."""

    def make_release_tree(self, base_dir: str, files: Sequence[str]) -> None:
        """Copy this module beside setup.py, where Python looks for it, and the files it installs."""
        super().make_release_tree(base_dir, files)
        for file in (str(Path(__file__).resolve()), "package.xml", *_data_files("config"), *_data_files("launch")):
            target = Path(base_dir) / (Path(file).name if Path(file).is_absolute() else file)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
        shutil.copytree("resource", Path(base_dir) / "resource", dirs_exist_ok=True)


def _data_files(folder: str) -> list[str]:
    return [f for f in sorted(glob(f"{folder}/*")) if Path(f).is_file()]


def install(executables: Sequence[str] = (), package_data: Sequence[str] = ()) -> None:
    """Call setuptools for the package whose setup.py runs; name, version and so on come from its package.xml.

    Args:
        executables: of ``ros2 run``, as ``name = package.module:function``.
        package_data: files besides ``py.typed`` that belong beside the modules, as patterns below the package.
    """
    # setuptools looks in the current folder. The path is not resolved: colcon links setup.py into its build folder.
    script = Path(sys.argv[0])
    if script.name == "setup.py" and script.exists():
        os.chdir(script.absolute().parent)
    manifest = ElementTree.fromstring(Path("package.xml").read_text(encoding="utf-8"))

    def text(tag: str) -> str:
        value = manifest.findtext(tag)
        if not value:
            raise SystemExit(f"{Path('package.xml').absolute()} has no <{tag}>; every ROS 2 package needs one")
        return value

    name = text("name")
    share = {folder: _data_files(folder) for folder in ("config", "launch")}
    setup(
        name=name,
        version=text("version"),
        description=text("description"),
        license=text("license"),
        maintainer=text("maintainer"),
        maintainer_email="".join(m.get("email", "") for m in manifest.findall("maintainer")[:1]),
        packages=find_packages(exclude=["test"]),
        package_data={name: ["py.typed", *package_data]},
        data_files=[
            ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
            (f"share/{name}", ["package.xml"]),
            *((f"share/{name}/{folder}", files) for folder, files in share.items() if files),
        ],
        install_requires=["setuptools"],
        zip_safe=True,
        extras_require={"test": ["pytest"]},
        entry_points={"console_scripts": list(executables)},
        cmdclass={"sdist": SdistWithThisFile},
    )
