"""A node of one table of parameters: it declares all of them, and refuses any other name it is given."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterType
from rclpy._rclpy_pybind11 import RCLError

from mbd_model.errors import MbdError
from mbd_model.parameters import ParameterError, ParameterSpec, ParameterTable, ParameterTypeError, Value
from mbd_model.ros.guarded_node import GuardedNode


class TableNode(GuardedNode):
    """A node whose parameters are those of its table, and that nothing sent to it can end.

    Args:
        table: its name and parameters.
        defaults: in place of the table's, by name.
        options: of rclpy's Node (context, namespace, parameter_overrides...).

    Attributes:
        values: of every parameter when the node was made, by name, as ``ParameterTable.values`` gives them.

    Raises:
        ParameterError: a name was given, on the command line or in a file, that the table has not; or a value that a
            parameter does not take.
        MbdError: secured nodes are asked for, and the middleware makes none.
    """

    def __init__(self, table: ParameterTable, *, defaults: Mapping[str, Value] | None = None, **options: Any) -> None:
        # Declared without being asked for, what was given can be looked through; rclpy has no other public way to it.
        try:
            super().__init__(table.node, automatically_declare_parameters_from_overrides=True, **options)
        except ValueError as error:
            raise ParameterError(
                f"a parameter of {table.node} has no type, since it is empty or an empty list; write '' for no text, "
                "[''] for a list of none, or leave it out"
            ) from error
        except RCLError as error:
            if os.environ.get("ROS_SECURITY_ENABLE") != "true":
                raise
            what = " ".join(str(error).partition(", at /")[0].split())
            raise MbdError(
                f"ROS_SECURITY_ENABLE is true, and the middleware makes no secured node: {what}. Expected a ROS 2 with "
                "DDS Security (an installed Jazzy has it, the wheels of PyPI do not), or ROS_SECURITY_ENABLE=false"
            ) from error
        given = {name: parameter.value for name, parameter in self.get_parameters_by_prefix("").items()}
        table.refuse_unknown(given)
        if not isinstance(given.get("use_sim_time", False), bool):  # rclpy would say so, and go on without it
            raise ParameterError(f"parameter use_sim_time is '{given['use_sim_time']}'; expected true or false")
        self.values: dict[str, Any] = {}
        for spec in table.specs:
            if spec.name in given:
                # A wrong type is rclpy's to refuse, which knows how it was written.
                with suppress(ParameterTypeError):
                    spec.checked(given[spec.name])
                self.undeclare_parameter(spec.name)
            default = spec.derived(self.values) if spec.derived is not None else spec.default
            default = (defaults or {}).get(spec.name, default)
            # ROS takes an empty list for one of bytes: a list of no texts is [''] there.
            plain = (list(default) or [""]) if isinstance(default, tuple) else default
            declared = self.declare_parameter(spec.name, plain, descriptor(spec))
            value = spec.checked(declared.value)
            self.values[spec.name] = () if spec.default == () and value == ("",) else value


def descriptor(spec: ParameterSpec) -> ParameterDescriptor:
    """A parameter as ROS describes it to whoever asks the running node."""
    unit = f" [{spec.unit}]" if spec.unit else ""
    made = ParameterDescriptor(
        description=spec.description + unit,
        read_only=spec.read_only,
        additional_constraints=spec.allowed if spec.choices else "",
    )
    if isinstance(spec.default, tuple) and spec.kind == "list of texts":
        made.type = ParameterType.PARAMETER_STRING_ARRAY  # an empty list would be of no type
    if spec.range is not None and isinstance(spec.default, int):
        made.integer_range = [IntegerRange(from_value=int(spec.range[0]), to_value=int(spec.range[1]), step=1)]
    elif spec.range is not None and isinstance(spec.default, float):
        made.floating_point_range = [FloatingPointRange(from_value=spec.range[0], to_value=spec.range[1])]
    return made
