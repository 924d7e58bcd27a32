"""The topics of a damaged file: by its own table, else by metadata.yaml where that leaves one answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from mbd_bag.repairing.sqlite.definitions import Messages, TypeDefinition, definition_of
from mbd_bag.repairing.sqlite.rows import BagRows, MessageRow, TopicRow
from mbd_bag.repairing.stated_topics import StatedTopic

_WITNESSES = 3  # topics that must be where they are by the order of metadata.yaml


def topics_of(
    found: BagRows, messages: Messages, rows: Mapping[int, Sequence[MessageRow]], stated: Sequence[StatedTopic]
) -> tuple[dict[int, TopicRow], dict[str, TypeDefinition]]:
    """The topics by id, and the definitions of their types.

    Args:
        found: in the file.
        messages: reads rows.
        rows: messages by topic id.
        stated: the topics by metadata.yaml.
    """
    topics = dict(found.topics)
    names = {t.name: t for t in stated}
    for k, topic in topics.items():
        # One of the two is damaged; metadata.yaml is text that other tools have read.
        if topic.name in names and names[topic.name].msgtype != topic.msgtype:
            topics[k] = replace(topic, msgtype=names[topic.name].msgtype)
    doubtful = [k for k, t in topics.items() if names and t.name not in names and rows.get(k)]
    wanting = sorted({*rows, *doubtful} - (topics.keys() - set(doubtful)))
    used = {t.name for t in topics.values()}
    left = [t for t in stated if t.name not in used and t.count]
    fitting = {
        k: [
            t
            for t in left
            if t.count >= len(rows[k])
            and definition_of(t.msgtype, found.definitions.get(t.msgtype), messages, rows[k]).fits
        ]
        for k in wanting
    }
    matched = _matched(fitting, rows)
    certain = {k: t.name for k, t in topics.items() if k not in wanting} | {k: t.name for k, t in matched.items()}
    for k, stated_topic in (_by_order(fitting, certain, stated) | matched).items():
        topic = topics.get(k, TopicRow(k, "", "", "cdr", "", ""))
        topics[k] = replace(topic, name=stated_topic.name, msgtype=stated_topic.msgtype)
    return topics, _definitions(topics, found, messages, rows)


def _matched(
    fitting: Mapping[int, Sequence[StatedTopic]], rows: Mapping[int, Sequence[MessageRow]]
) -> dict[int, StatedTopic]:
    """Which stated topic each id must be: the only one of whose type its messages are, and that has as many."""
    matched: dict[int, StatedTopic] = {}
    while True:
        taken = {t.name for t in matched.values()}
        # Its own count where nothing of it is lost, else all that remains.
        choices = {k: [t for t in topics if t.name not in taken] for k, topics in fitting.items() if k not in matched}
        exact = {k: [t for t in topics if t.count == len(rows[k])] for k, topics in choices.items()}
        single = {k: topics[0] for k, topics in choices.items() if len(topics) == 1} or {
            k: topics[0] for k, topics in exact.items() if len(topics) == 1
        }
        names = [t.name for t in single.values()]
        new = {k: t for k, t in single.items() if names.count(t.name) == 1}
        if not new:
            return matched
        matched |= new


def _by_order(
    fitting: Mapping[int, Sequence[StatedTopic]], certain: Mapping[int, str], stated: Sequence[StatedTopic]
) -> dict[int, StatedTopic]:
    """The topics at the ids' places in metadata.yaml, when all that are certain stand at theirs."""
    places = {k + 1: t for k, t in enumerate(stated)}
    if len(certain) < _WITNESSES or any(k not in places or places[k].name != name for k, name in certain.items()):
        return {}
    return {k: places[k] for k, topics in fitting.items() if k in places and places[k] in topics}


def _definitions(
    topics: Mapping[int, TopicRow], found: BagRows, messages: Messages, rows: Mapping[int, Sequence[MessageRow]]
) -> dict[str, TypeDefinition]:
    of_type: dict[str, list[MessageRow]] = {}
    for k, topic in topics.items():
        of_type.setdefault(topic.msgtype, []).extend(rows.get(k, ()))
    return {kind: definition_of(kind, found.definitions.get(kind), messages, some) for kind, some in of_type.items()}
