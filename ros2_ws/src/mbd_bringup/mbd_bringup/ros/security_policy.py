"""``security_policy``: lead a simulated session, see who says what to whom, and write it down as a policy of SROS 2."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import rclpy
from mbd_bag.spool.parameters import WRITERS
from mbd_model.command_line.parser import CommandParser
from mbd_model.command_line.values import above_zero
from mbd_model.errors import MbdError
from mbd_model.folders import make_folder
from rclpy.node import Node
from rich.console import Console
from rich.markup import escape

from mbd_bringup.domain import private_domain
from mbd_bringup.nodes import SessionOptions, session_nodes
from mbd_bringup.processes import SessionProcesses
from mbd_bringup.ros.live_session import install_prefixes
from mbd_bringup.security.policy import NodeAccess, access_of, policy_xml

_START = 600.0  # [s] within which all nodes are there
_RECORDING = ("recorder", *WRITERS)


def seen_access(node: Node, names: Collection[str]) -> dict[str, NodeAccess]:
    """What nodes do at this moment, by their names.

    Args:
        node: that looks at the graph.
        names: of the nodes, in the namespace "/".
    """

    def names_by(look: Callable[[str, str], Sequence[tuple[str, Sequence[str]]]], name: str) -> list[str]:
        return [found for found, _ in look(name, "/")]

    present = {name for name, space in node.get_node_names_and_namespaces() if space == "/"} & set(names)
    return {
        name: access_of(
            names_by(node.get_publisher_names_and_types_by_node, name),
            names_by(node.get_subscriber_names_and_types_by_node, name),
            names_by(node.get_service_names_and_types_by_node, name),
            names_by(node.get_client_names_and_types_by_node, name),
        )
        for name in present
    }


def session_access(options: SessionOptions, seconds: float) -> dict[str, NodeAccess]:
    """Start a session's nodes, and see for some time what they do.

    Args:
        options: of the session.
        seconds: to look, from the moment on at which all are there.

    Raises:
        MbdError: the nodes did not come up.
    """
    specs = session_nodes(options)
    names = {spec.executable for spec in specs}
    prefixes = install_prefixes(sorted({s.package for s in specs} | {p for s in specs for p, _ in s.config if p}))
    found: dict[str, NodeAccess] = {}
    with private_domain() as domain:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        node = Node("security_policy", context=context)
        try:
            variables = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
            with SessionProcesses(prefixes, options.folder / "logs", variables) as processes:
                for spec in specs:
                    processes.start(spec)
                end = time.monotonic() + _START
                complete = False
                while time.monotonic() < end:
                    for name, access in seen_access(node, names).items():
                        found[name] = found.get(name, NodeAccess()) | access
                    if not complete and found.keys() == names:
                        complete, end = True, time.monotonic() + seconds
                    time.sleep(0.5)  # the pace of looking; what is not seen yet is seen at a later look
        finally:
            node.destroy_node()
            rclpy.try_shutdown(context=context)
    if missing := names - found.keys():
        raise MbdError(f"nodes {', '.join(sorted(missing))} did not come up within {_START:g} s; is the machine busy?")
    return found


def main() -> None:
    """Entry point: exit code 0; 2 when the nodes do not come up or the file exists."""
    parser = CommandParser(prog="security_policy", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="policy to write (.xml); not overwritten")
    parser.add_argument("--task", default="sorting", help="of the simulated session (default sorting)")
    parser.add_argument("--robot", default="", help="profile of a robot (default: none)")
    parser.add_argument("--camera", default="", help="profile of a camera (default: none)")
    parser.add_argument("--seconds", type=above_zero, default=60.0, help="to look at the session (default 60)")
    arguments = parser.parse_args()
    out: Path = arguments.out
    console = Console()
    try:
        if out.exists():
            raise MbdError(f"{out} exists already and is not overwritten; choose another --out")
        make_folder(out.parent)  # before a session is looked at
        with TemporaryDirectory(prefix="mbd_policy_") as folder:
            options = SessionOptions(
                "policy",
                Path(folder),
                task=arguments.task,
                execute=True,
                console=True,
                markers=True,
                robot=arguments.robot,
                camera=arguments.camera,
            )
            nodes = session_access(options, arguments.seconds)
        with out.open("x", encoding="utf-8") as stream:
            stream.write(policy_xml(nodes, _RECORDING))
    except (MbdError, OSError) as error:
        Console(stderr=True).print(f"[red]security_policy:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        raise SystemExit(2) from error
    console.print(f"wrote {len(nodes)} nodes to {out}", highlight=False, soft_wrap=True, markup=False)
    raise SystemExit(0)
