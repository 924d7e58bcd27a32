"""Scenes, steps and assists to an object mapping with a confidence (paper sec. 4.3).

Nothing in this package but ``node`` touches ROS. ``inference.infer`` is the one entry, for the node and for replay.
"""
