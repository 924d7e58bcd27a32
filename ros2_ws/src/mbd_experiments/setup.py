"""Install mbd_experiments as an ament_python package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from package_setup import install

install(
    executables=[
        "study_data = mbd_experiments.public_study.study_data:main",
        "explain = mbd_experiments.public_study.explain:main",
        "import_study = mbd_experiments.user_study.import_study:main",
        "table5_readings = mbd_experiments.public_study.table5_readings:main",
        "answers = mbd_experiments.user_study.answers:main",
        "experiment1 = mbd_experiments.simulated_problems.experiment1_tool:main",
        "case_studies = mbd_experiments.simulated_problems.case_studies_tool:main",
        "experiment2 = mbd_experiments.user_study.experiment2:main",
        "experiment3 = mbd_experiments.user_study.experiment3:main",
        "lab_prior = mbd_experiments.user_study.lab_prior_command:main",
        "reproduce = mbd_experiments.reproduction.reproduce:main",
        "simulate_study = mbd_experiments.simulated_participants.study:main",
        "rehearse_study = mbd_experiments.rehearsal.rehearse_command:main",
        "mapping_suite = mbd_experiments.teacher_families.suite:main",
        "fit_priors = mbd_experiments.teacher_families.fitting:main",
        "promise = mbd_experiments.teacher_families.promising:main",
        "train_rejoin = mbd_experiments.perception_training.train_rejoin:main",
        "fit_deviations = mbd_experiments.perception_training.fit_deviations:main",
        "feature_errors = mbd_experiments.perception_training.feature_errors_command:main",
        "execution_trials = mbd_experiments.execution_trials.trials_command:main",
        "session_video = mbd_experiments.session_video.video_command:main",
    ],
)
