"""A policy of SROS 2 (schema 0.2.0) from what each node of a session publishes, receives, serves and asks for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from xml.etree import ElementTree

VERSION = "0.2.0"  # of the schema, sros2/policy/schemas/policy.xsd
ROOT = "/mbd"  # enclave of a session as one; those of its nodes lie below
EVERYTHING = "*"
_ACTION = "/_action/"
# Kind of expression, qualifier, and the attribute of NodeAccess that lists them.
_RULES = (
    ("topic", "subscribe", "subscribes"),
    ("topic", "publish", "publishes"),
    ("service", "reply", "serves"),
    ("service", "request", "asks"),
    ("action", "execute", "executes"),
    ("action", "call", "calls"),
)


@dataclass(frozen=True)
class NodeAccess:
    """What one node does, by absolute names.

    Attributes:
        publishes, subscribes: topics.
        serves, asks: services.
        executes, calls: actions.
    """

    publishes: frozenset[str] = frozenset()
    subscribes: frozenset[str] = frozenset()
    serves: frozenset[str] = frozenset()
    asks: frozenset[str] = frozenset()
    executes: frozenset[str] = frozenset()
    calls: frozenset[str] = frozenset()

    def __or__(self, other: NodeAccess) -> NodeAccess:
        """What one or the other does."""
        return NodeAccess(*(getattr(self, f.name) | getattr(other, f.name) for f in fields(self)))


def access_of(
    publishes: Iterable[str], subscribes: Iterable[str], serves: Iterable[str], asks: Iterable[str]
) -> NodeAccess:
    """A node's access by the names that ROS's graph has for it: an action shows there as topics and services.

    Args:
        publishes: topics, absolute names.
        subscribes: alike.
        serves: services.
        asks: alike.
    """
    served, asked = frozenset(serves), frozenset(asks)
    return NodeAccess(
        publishes=frozenset(n for n in publishes if _ACTION not in n),
        subscribes=frozenset(n for n in subscribes if _ACTION not in n),
        serves=frozenset(n for n in served if _ACTION not in n),
        asks=frozenset(n for n in asked if _ACTION not in n),
        executes=frozenset(n.partition(_ACTION)[0] for n in served if _ACTION in n),
        calls=frozenset(n.partition(_ACTION)[0] for n in asked if _ACTION in n),
    )


def policy_xml(nodes: dict[str, NodeAccess], recording: Iterable[str] = ()) -> str:
    """The text of a policy: an enclave for each node, and one for all, ``/mbd``.

    Args:
        nodes: what each does, by its name.
        recording: nodes that record, and so may receive every topic, also those that come later.
    """
    everything = frozenset({EVERYTHING})
    known = {
        name: access | NodeAccess(subscribes=everything) if name in set(recording) else access
        for name, access in nodes.items()
    }
    policy = ElementTree.Element("policy", version=VERSION)
    enclaves = ElementTree.SubElement(policy, "enclaves")
    for path, names in ((ROOT, sorted(known)), *((f"{ROOT}/{name}", [name]) for name in sorted(known))):
        profiles = ElementTree.SubElement(ElementTree.SubElement(enclaves, "enclave", path=path), "profiles")
        for name in names:
            profile = ElementTree.SubElement(profiles, "profile", ns="/", node=name)
            _add_rules(profile, known[name])
    ElementTree.indent(policy)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(policy, encoding="unicode") + "\n"


def _add_rules(profile: ElementTree.Element, access: NodeAccess) -> None:
    for kind, qualifier, attribute in _RULES:
        names: frozenset[str] = getattr(access, attribute)
        shown = [EVERYTHING] if EVERYTHING in names else sorted(names)
        if shown:
            rules = ElementTree.SubElement(profile, f"{kind}s", {qualifier: "ALLOW"})
            for name in shown:
                ElementTree.SubElement(rules, kind).text = name
