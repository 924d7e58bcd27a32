"""What of the study tools speaks ROS."""
