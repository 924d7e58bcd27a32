"""The markers node, and what the demo does in ROS."""
