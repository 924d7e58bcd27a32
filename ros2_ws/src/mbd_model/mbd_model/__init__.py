"""The shared vocabulary: objects, scenes, tasks, assists and estimates as frozen values.

Frames and units (REP 103/105): the robot's base frame (x away from the robot, y to its left, z up); metres, radians,
seconds; hue in degrees [0, 360). Nothing in this package but its conversions, ``qos``, ``latch``
and ``run_node`` touches ROS.
"""
