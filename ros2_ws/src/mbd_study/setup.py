"""Install mbd_study as an ament_python package."""

from glob import glob

from setuptools import find_packages, setup

package_name = "mbd_study"

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
    description="Record and replay study sessions as MCAP bags; experiments, tables and figures.",
    license="Apache-2.0",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": [
            "recorder = mbd_study.recorder_node:main",
            "replay = mbd_study.replay_command_node:main",
            "reevaluate = mbd_study.reevaluate:main",
            "export = mbd_study.export:main",
            "report = mbd_study.report:main",
            "table = mbd_study.session_table:main",
            "info = mbd_study.info:main",
            "repair = mbd_study.repair:main",
            "picture = mbd_study.pictures:main",
            "import_study = mbd_study.experiments.import_study:main",
            "answers = mbd_study.experiments.answers:main",
            "experiment2 = mbd_study.experiments.experiment2:main",
            "experiment3 = mbd_study.experiments.experiment3:main",
            "reproduce = mbd_study.experiments.reproduce:main",
            "simulate_study = mbd_study.participants.study:main",
        ],
    },
)
