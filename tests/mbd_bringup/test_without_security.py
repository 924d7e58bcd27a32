"""Where the middleware has no DDS Security, a node that is to be secured does not run unprotected: it says so."""

from __future__ import annotations

import pytest
from mbd_bag.ros.spool_node import Spool
from mbd_model.errors import MbdError
from rclpy._rclpy_pybind11 import RCLError
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter


@pytest.mark.parametrize("strategy", ["Enforce", "Permissive"])
def test_a_node_that_cannot_be_secured_is_not_made(strategy, ros_domain, tmp_path, monkeypatch):
    (tmp_path / "keys" / "enclaves").mkdir(parents=True)
    for name, value in (("ENABLE", "true"), ("STRATEGY", strategy), ("KEYSTORE", str(tmp_path / "keys"))):
        monkeypatch.setenv(f"ROS_SECURITY_{name}", value)
    context = Context()
    try:
        context.init(domain_id=ros_domain)
        Node("any", context=context).destroy_node()
    except RCLError as error:
        if "security libraries" not in str(error):
            pytest.skip("this middleware has DDS Security, and no keys here")
    else:
        pytest.skip("this middleware has DDS Security")
    try:
        folder = Parameter("folder", value=str(tmp_path / "spool"))
        with pytest.raises(MbdError, match=r"ROS_SECURITY_ENABLE is true.*security libraries.*Expected a ROS 2 with"):
            Spool(context=context, parameter_overrides=[folder])
    finally:
        context.try_shutdown()
