"""``info BAG``: a session at a glance."""

from __future__ import annotations

from mbd_bag.recorder.topic_counts import stated_counts
from mbd_bag.session.command_line import bag_parser, note, read_session, run_tool
from mbd_bag.session.recorded_session import RecordedSession
from mbd_bag.session.session_facts import fingerprint
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.superseded import is_superseded
from mbd_model.times import to_seconds
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mbd_study.tables.session_table import assist_rows

FACTS = ("participant", "task", "seed")


def topic_table(bag: Bag) -> Table:
    """Every topic with its type, number of messages and mean rate."""
    seconds = to_seconds(bag.end - bag.start)
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("topic")
    table.add_column("type")
    table.add_column("messages", justify="right")
    table.add_column(r"\[1/s]", justify="right")
    counts = stated_counts(bag.facts)
    if counts:
        table.add_column("received", justify="right")
        table.add_column("missed", justify="right")
    for topic in bag.topics:
        rate = f"{topic.count / seconds:.1f}" if seconds > 0 and topic.count > 1 else ""
        count = counts.get(topic.name) or counts.get(topic.name.rpartition("/compressed")[0])
        more = (str(count.received), str(count.missing) if count.missing else "") if count is not None else ()
        table.add_row(topic.name, topic.msgtype, str(topic.count), rate, *more)
    return table


def phase_table(session: RecordedSession, start: int) -> Table:
    """When each phase began.

    Args:
        session: as recorded.
        start: log time that counts as 0 [ns].
    """
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column(r"t \[s]", justify="right")
    table.add_column("phase")
    table.add_column("")
    last = None
    for state in session.states:
        if state.value.phase is not last:
            last = state.value.phase
            table.add_row(f"{to_seconds(state.log_time - start):.1f}", last.name.lower(), escape(state.value.detail))
    return table


def _counts(session: RecordedSession) -> str:
    refused = sum(not r.value.accepted for r in session.replies)
    steps = len(session.tasks[-1].value.steps) if session.tasks else 0
    given = len(session.assists[-1].value) if session.assists else 0
    return (
        f"{steps} steps demonstrated, {given} assists in force, {len(session.estimates)} estimates, "
        f"{len(session.replies)} wizard events ({refused} refused), {len(session.notes)} notes"
    )


def _fingerprint(session: RecordedSession) -> str:
    """Of the set-up; a bag that states none has none."""
    stated = any(key.startswith(("version.", "parameter.")) for key in session.facts)
    unknown = "unknown: the bag states no versions and no parameters"
    return session.facts.get("fingerprint") or (fingerprint(session.facts) if stated else unknown)


def _tool() -> int:
    arguments = bag_parser(__doc__ or "").parse_args()
    console = Console()
    bag, session = read_session(arguments.bag, console)
    size = sum(f.path.stat().st_size for f in bag.files)
    facts = ", ".join(f"{key} {escape(session.facts[key])}" for key in FACTS if session.facts.get(key))
    console.print(f"[bold]session {escape(session.name)}[/]" + (f"  {facts}" if facts else ""), highlight=False)
    console.print(
        f"{to_seconds(bag.end - bag.start):.1f} s, {bag.message_count} messages, {size / 1e6:.1f} MB in "
        f"{len(bag.files)} file{'s' if len(bag.files) > 1 else ''}",
        highlight=False,
    )
    console.print(_counts(session), highlight=False)
    for problem in bag.check():
        if problem not in session.problems:
            note(problem, console)
    console.print(f"set-up fingerprint {_fingerprint(session)}", highlight=False)
    if is_superseded(session.facts):
        console.print("[yellow]superseded:[/] this episode was recorded again; this is the first try", highlight=False)
    for title, table in (("phases", phase_table(session, bag.start)), ("topics", topic_table(bag))):
        if table.row_count:
            console.print(f"\n[bold cyan]{title}[/]")
            console.print(table)
    rows = assist_rows(session)
    if rows:
        final = rows[-1]
        right = {True: ", right", False: ", wrong", None: ""}[final.correct]
        console.print("\n[bold cyan]final mapping[/]")
        console.print("  ".join(f"{escape(s)}→{escape(t)}" for s, t in final.pairs) or "none", highlight=False)
        console.print(
            f"by {'+'.join(final.winning) or 'no feature'}, confidence {final.confidence:.4f}{right}", highlight=False
        )
    return 0


def main() -> None:
    """Entry point: exit code 0, or 2 when the bag cannot be used."""
    run_tool("info", _tool)
