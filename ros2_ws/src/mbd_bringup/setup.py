"""Install mbd_bringup as an ament_python package."""

from glob import glob

from setuptools import find_packages, setup

package_name = "mbd_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/config", glob("config/*")),
        (f"share/{package_name}/launch", glob("launch/*.py")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="Mapping by Demonstration maintainers",
    maintainer_email="maintainers@mapping-by-demonstration.org",
    description="Launch files, parameters and the demo.",
    license="Apache-2.0",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": [
            "demo = mbd_bringup.demo:main",
            "markers = mbd_bringup.markers_node:main",
        ],
    },
)
