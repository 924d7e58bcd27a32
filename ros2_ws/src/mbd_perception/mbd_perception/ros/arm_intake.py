"""Where the arm is: its description from a topic or a file, its joints from joint states."""

from __future__ import annotations

import math
from pathlib import Path

from mbd_model.errors import MbdError
from mbd_model.ros.offered import OfferedSubscription, StreamSource
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from mbd_perception.arm.description import ArmDescription, DescriptionError, Rods, parse_description

# Published by robot_state_publisher.
DESCRIPTION_TOPIC = "robot_description"


class ArmIntake:
    """Knows the arm's shape as soon as it is described and its joints are known.

    Args:
        node: owner of the subscriptions.
        description: path of a URDF; empty for the topic ``robot_description``.
        joint_state: topic of the joints; several publishers may each state some of them.
        base: link whose frame is the base frame.

    Raises:
        MbdError: the file cannot be read, or describes no arm.
    """

    def __init__(self, node: Node, description: str, joint_state: str, base: str) -> None:
        self._node, self._base = node, base
        self._arm: ArmDescription | None = None
        self._positions: dict[str, float] = {}
        if description:
            try:
                self._arm = parse_description(Path(description).read_text(encoding="utf-8"))
            except (OSError, UnicodeDecodeError, DescriptionError) as error:
                raise MbdError(f"arm_description {description}: {error}") from error
        else:
            OfferedSubscription(node, [StreamSource(String, DESCRIPTION_TOPIC)], self._on_description)
        # Deep: several publishers may share the topic.
        OfferedSubscription(node, [StreamSource(JointState, joint_state)], self._on_joints, depth=10)

    def _on_description(self, msg: String) -> None:
        """Take a description; one that is none is told and changes nothing."""
        try:
            self._arm = parse_description(msg.data)
        except DescriptionError as error:
            self._node.get_logger().warning(f"{DESCRIPTION_TOPIC}: {error}")

    def _on_joints(self, msg: JointState) -> None:
        """Remember the positions that are given."""
        given = zip(msg.name, msg.position, strict=False)
        self._positions |= {name: value for name, value in given if math.isfinite(value)}

    @property
    def rods(self) -> Rods | None:
        """Where the arm is now; None while its description or one of its joints is unknown (fingers may be)."""
        if self._arm is None or not self._arm.needed <= self._positions.keys():
            return None
        return self._arm.rods(self._positions, self._base)
