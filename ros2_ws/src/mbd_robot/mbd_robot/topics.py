"""Names under which the suite reads and moves a robot, whatever its drivers speak."""

from __future__ import annotations

TOOL_POSE, JOINT_STATE = "robot/out/tool_pose", "robot/out/joint_state"
MOVE_TOOL, MOVE_GRIPPER = "robot/move_tool", "robot/move_gripper"
HAND_GUIDING = "robot/hand_guiding"
