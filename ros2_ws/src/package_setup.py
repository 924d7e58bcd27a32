"""What every ament_python package of this workspace installs, said once; each ``setup.py`` calls ``install``."""

from __future__ import annotations

from collections.abc import Sequence
from glob import glob
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup


def install(executables: Sequence[str] = (), package_data: Sequence[str] = ()) -> None:
    """Call setuptools for the package in the current folder; name, version and so on come from its package.xml.

    Args:
        executables: of ``ros2 run``, as ``name = package.module:function``.
        package_data: files besides ``py.typed`` that belong beside the modules, as patterns below the package.
    """
    manifest = ElementTree.fromstring(Path("package.xml").read_text(encoding="utf-8"))
    name = manifest.findtext("name", "")
    maintainer = manifest.find("maintainer")
    share = {folder: [f for f in sorted(glob(f"{folder}/*")) if Path(f).is_file()] for folder in ("config", "launch")}
    setup(
        name=name,
        version=manifest.findtext("version"),
        description=manifest.findtext("description"),
        license=manifest.findtext("license"),
        maintainer=None if maintainer is None else maintainer.text,
        maintainer_email=None if maintainer is None else maintainer.get("email"),
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
    )
