"""Who may say what to whom, for ROS 2's own access control (SROS 2)."""
