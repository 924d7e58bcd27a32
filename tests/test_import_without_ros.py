"""Algorithm modules work where there is no ROS."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[1] / "ros2_ws" / "src"
# Modules that may import ROS lie in a folder of this name.
ROS_FOLDER = "ros"


def algorithm_modules() -> list[str]:
    modules = []
    for package in sorted(p for p in SRC.iterdir() if (p / p.name / "__init__.py").exists()):
        for file in sorted((package / package.name).rglob("*.py")):
            if ROS_FOLDER not in file.relative_to(package).parts:
                parts = file.relative_to(package).with_suffix("").parts
                modules.append(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
    return modules


BLOCK = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        root = name.partition('.')[0]
        ros = root in {'rclpy', 'ament_index_python', 'launch', 'launch_ros'}
        if ros or root.endswith(('_msgs', '_srvs', '_interfaces')):
            raise ImportError(f'{name} is blocked: an algorithm module must not import ROS')
sys.meta_path.insert(0, Block())
import importlib, traceback
failed = []
for module in sys.argv[1:]:
    try:
        importlib.import_module(module)
    except ImportError as error:
        failed.append(f'{module}: {error}')
print('\\n'.join(failed))
sys.exit(bool(failed))
"""


def test_every_algorithm_module_imports_with_ros_blocked():
    modules = algorithm_modules()
    assert len(modules) > 8
    done = subprocess.run([sys.executable, "-c", BLOCK, *modules], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("module", ["mbd_model.ros.conversions"])
def test_the_blocker_blocks(module: str):
    done = subprocess.run([sys.executable, "-c", BLOCK, module], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "blocked" in done.stdout
