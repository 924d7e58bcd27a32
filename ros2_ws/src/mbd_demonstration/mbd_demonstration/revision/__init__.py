"""Corrections of a recorded task, and recordings that go on from one."""
