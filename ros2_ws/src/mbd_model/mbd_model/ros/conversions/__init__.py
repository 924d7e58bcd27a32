"""Between the frozen values of this package and mbd_msgs, both ways: every module of this folder under one name.

``..._from_msg`` only reads attributes, so it takes messages of rclpy and messages decoded by rosbags alike.
``..._to_msg`` makes rclpy messages. Times are float seconds here and builtin_interfaces/Time there.
"""

from mbd_model.ros.conversions.assist import (
    assist_from_msg,
    assist_to_msg,
    assists_from_msg,
    assists_to_msg,
    denial_from_msg,
    denial_to_msg,
    denials_from_msg,
)
from mbd_model.ros.conversions.correction import (
    correction_from_msg,
    correction_to_msg,
    correction_to_request,
)
from mbd_model.ros.conversions.estimate import (
    estimate_from_msg,
    estimate_to_msg,
    inputs_from_msg,
    mapping_from_msg,
    mapping_to_msg,
)
from mbd_model.ros.conversions.form import form_from_msg, form_to_msg
from mbd_model.ros.conversions.progress import progress_from_msg, progress_to_msg
from mbd_model.ros.conversions.scene import (
    CODE_TO_ROLE,
    ROLE_TO_CODE,
    object_from_msg,
    object_to_msg,
    role_from_code,
    scene_from_msg,
    scene_to_msg,
)
from mbd_model.ros.conversions.session import prompt_from_msg, prompt_to_msg, state_from_msg, state_to_msg
from mbd_model.ros.conversions.task import step_from_msg, step_to_msg, task_from_msg, task_to_msg
from mbd_model.ros.conversions.times import (
    clock_seconds,
    header,
    stamp_from_msg,
    stamp_to_msg,
    time_from_msg,
    time_to_msg,
)

__all__ = [
    "CODE_TO_ROLE",
    "ROLE_TO_CODE",
    "assist_from_msg",
    "assist_to_msg",
    "assists_from_msg",
    "assists_to_msg",
    "clock_seconds",
    "correction_from_msg",
    "correction_to_msg",
    "correction_to_request",
    "denial_from_msg",
    "denial_to_msg",
    "denials_from_msg",
    "estimate_from_msg",
    "estimate_to_msg",
    "form_from_msg",
    "form_to_msg",
    "header",
    "inputs_from_msg",
    "mapping_from_msg",
    "mapping_to_msg",
    "object_from_msg",
    "object_to_msg",
    "progress_from_msg",
    "progress_to_msg",
    "prompt_from_msg",
    "prompt_to_msg",
    "role_from_code",
    "scene_from_msg",
    "scene_to_msg",
    "stamp_from_msg",
    "stamp_to_msg",
    "state_from_msg",
    "state_to_msg",
    "step_from_msg",
    "step_to_msg",
    "task_from_msg",
    "task_to_msg",
    "time_from_msg",
    "time_to_msg",
]
