"""The same seed gives the same result in every process, down to the last bit.

Python orders a set of texts differently in each process unless PYTHONHASHSEED is set. A sum over one then differs in
its last bits, and what is recorded differs from what is computed again.
"""

from __future__ import annotations

import os
import subprocess
import sys

# What each part of the system computes from a seed; numbers are printed so that every bit of them is told.
COMPUTED = """
import numpy as np
from mbd_demonstration.generated.arrivals import arrivals
from mbd_demonstration.generated.repertoire import random_acts
from mbd_demonstration.recording import DemonstrationConfig
from mbd_experiments.simulated_problems.experiment1 import run_problem
from mbd_mapping.config import MappingConfig
from mbd_mapping.inference import infer
from mbd_mapping.synthetic import random_problem
from mbd_model.assists import Assist
from mbd_model.task import StepKind, Task, TaskStep
from mbd_experiments.perception_training.feature_errors import room_errors
from mbd_perception.synthetic.rooms import Kind
from mbd_study.annotation.agreement import agreement
from mbd_study.annotation.intervals import Interval

for seed in range(6):
    rng = np.random.default_rng(seed)
    source, target = random_problem(rng, 3 + seed % 4)
    task = Task(source, tuple(TaskStep(k, StepKind.PICK, name, 0.0) for k, name in enumerate(source.ids)), stamp=1.0)
    for strategy in ("evidence", "mbd"):
        print(infer(task, target, [Assist("s0", "t1")], MappingConfig(strategy=strategy)))
    shown = arrivals(random_acts(rng), rng).recording().task(1.0e9, DemonstrationConfig())
    print(shown.steps, shown.problems)
    edges = np.concatenate([[0.0], np.sort(rng.uniform(0.0, 9.7, 12)), [9.7]])
    both = [[Interval("t", a, b, str(rng.choice(list("uvwxyz")))) for a, b in zip(edges, edges[1:])] for _ in range(2)]
    print(agreement(*both, 9.7))
for error in room_errors(Kind.PLAIN, [1000], 1):
    print(error.errors.tolist(), error.evidence.tolist())
print(run_problem(5, 1, (3, 0)))
"""


def test_what_is_computed_does_not_depend_on_how_python_orders_sets():
    command = [sys.executable, "-c", COMPUTED]
    running = [
        subprocess.Popen(command, env=os.environ | {"PYTHONHASHSEED": seed}, text=True, stdout=subprocess.PIPE)
        for seed in ("0", "1", "2", "3")
    ]
    printed = [process.communicate()[0].splitlines() for process in running]
    assert all(process.returncode == 0 for process in running) and len(printed[0]) > 20
    for other in printed[1:]:
        assert other == printed[0]
