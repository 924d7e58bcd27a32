"""The arm and the hand: kinematics, motion, grasps."""
