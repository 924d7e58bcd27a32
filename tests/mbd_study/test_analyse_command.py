"""`analyse` reads what `export` writes, states what it left out, and refuses what it cannot compare in one sentence."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import pytest
from mbd_study.analysis import analyse_command

SLEEP = [
    ("1", [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]),
    ("2", [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]),
]


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["analyse", *words])
    with pytest.raises(SystemExit) as ended:
        analyse_command.main()
    return int(ended.value.code)


def write(path: Path, rows: list[dict[str, object]]) -> Path:
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return path


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture
def sleep(tmp_path: Path) -> Path:
    made = [{"drug": drug, "ID": k, "extra": v} for drug, values in SLEEP for k, v in enumerate(values)]
    return write(tmp_path / "sleep.csv", made)


@pytest.fixture
def exported(tmp_path: Path) -> Path:
    """Four participants, two conditions, two tasks; one session unfinished, one a first try."""
    folder = tmp_path / "tables"
    folder.mkdir()
    made = [
        {
            "session": f"p{p}_{condition}_{task}",
            "participant": f"p{p}",
            "task": task,
            "seed": "",
            "last_phase": "abort" if (p, condition, task) == (3, "b", "y") else "done",
            "superseded": "false",
            "assists": p + (2 if condition == "b" else 0),
            "duration_s": 100 + 10 * p + (35.5 if condition == "b" else 0) + (7 if task == "x" else 0) + p * p % 3,
            "correct": "true" if condition == "b" or p else "false",
        }
        for p in range(4)
        for condition in "ab"
        for task in "xy"
    ]
    made.append({**made[0], "superseded": "true"})
    write(folder / "sessions.csv", made)
    events = [
        {"session": r["session"], "topic": "wizard/handed", "latency_s": 1.0 + k + (r is made[0])}
        for r in made[:16]
        for k in range(3)
    ]
    write(folder / "events.csv", [*events, {"session": made[1]["session"], "topic": "wizard/note", "latency_s": 99}])
    scores = [
        {
            "session": r["session"],
            "form": "sus",
            "superseded": again,
            "score": "sus",
            "value": 9 if again == "true" else k,
        }
        for k, r in enumerate(made[:16])
        for again in ("true", "false")
    ]
    write(folder / "scores.csv", scores)
    return folder


def test_any_table_is_compared_and_the_tables_a_paper_prints_are_written(
    sleep: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    out = tmp_path / "out"
    words = (str(sleep), "--by", "drug", "--participant", "ID", "--measures", "extra", "--out", str(out))
    assert run(monkeypatch, *words) == 0
    (test,), (pair,), (shown,) = (rows(out / f"{name}.csv") for name in ("tests", "pairs", "sensitivity"))
    assert float(test["p"]) == pytest.approx(0.002833, abs=1e-6)
    assert float(pair["ci_low"]) == pytest.approx(-2.4598858, abs=1e-6)
    assert 0.9 < float(shown["least_effect"]) < 1.1
    assert [float(r["mean"]) for r in rows(out / "descriptives.csv")] == pytest.approx([0.75, 2.33])
    assert (out / "analysis.md").read_text().strip() in capsys.readouterr().out
    assert (out / "extra.png").read_bytes().startswith(b"\x89PNG")
    assert run(monkeypatch, *words) == 2


def test_exported_tables_take_conditions_from_the_plan_and_leave_out_what_is_no_session_of_it(
    exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    plan = tmp_path / "plan.yaml"
    plan.write_text("study: s\nseed: 1\nconditions: [a, b]\ntasks: [x, y]\nparticipants: [p0, p1, p2, p3]\n")
    out = tmp_path / "out"
    assert run(monkeypatch, str(exported), "--plan", str(plan), "--out", str(out)) == 0
    said = capsys.readouterr().out
    assert "1 of 17 sessions are left out, not finished: p3_b_y" in said
    assert "1 of 17 sessions are left out, first tries" in said
    assert "15 sessions of 4 participants, compared by condition, task as blocks." in said
    means = {(r["measure"], r["condition"]): r for r in rows(out / "descriptives.csv")}
    measures = {"correct", "assists", "duration_s", "answer_latency_s", "form_sus_sus"}
    assert {measure for measure, _ in means} == measures
    assert float(means["answer_latency_s", "a"]["mean"]) == pytest.approx(2.0 + 0.5 / 4)
    assert float(means["form_sus_sus", "a"]["mean"]) == pytest.approx(6.5)
    assert float(means["assists", "b"]["mean"]) == pytest.approx(3.5)
    assert means["assists", "b"]["participants"] == "4"
    tests = {r["measure"]: r for r in rows(out / "tests.csv")}
    assert tests["duration_s"]["test"] == "linear mixed model"
    assert "what the blocks add taken out first" in tests["duration_s"]["why"]
    assert tests["assists"]["test"] == "Wilcoxon signed-rank (exact)"


def test_simulated_sessions_are_said_to_be_such(
    exported: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    made = [{**r, "seed": "7", "condition": r["session"].split("_")[1]} for r in rows(exported / "sessions.csv")]
    write(exported / "sessions.csv", made)
    assert run(monkeypatch, str(exported)) == 0
    assert "SIMULATED are 15 of 15 sessions" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--by", "drgu", "--measures", "extra"], "did you mean 'drug'"),
        (["--by", "drug", "--measures", "extras"], "did you mean 'extra'"),
        (["--by", "drug"], "--measures NAME"),
        (["--measures", "extra"], "nothing says which sessions are of which condition"),
        (["--by", "drug", "--measures", "extra", "--participant", "who"], "no column 'who'"),
        (["--by", "drug", "--measures", "extra", "--plan", "no.yaml"], "no.yaml"),
    ],
)
def test_a_mistake_is_named_with_what_is_expected(
    words: list[str], said: str, sleep: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    if "--participant" not in words:
        words = [*words, "--participant", "ID"]
    assert run(monkeypatch, str(sleep), *words) == 2
    assert said in " ".join(capsys.readouterr().err.split())


def test_a_table_in_which_nothing_could_be_a_condition_is_said_to_be_so_and_not_given_an_empty_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    table, plan = tmp_path / "own.csv", tmp_path / "plan.yaml"
    table.write_text("a,b\n1,2\n")
    plan.write_text("study: x\nseed: 3\nconditions: [a, b]\ntasks: [sorting]\nparticipants: 4\n")
    for words, why in (((), "no column has 2 to 6 different values"), (("--plan", str(plan)), "no column 'session'")):
        assert run(monkeypatch, str(table), *words) == 2
        assert why in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no rows"),
        ("a,b\n", "no rows"),
        ("a,b\n1\n", "line 2 has not as many cells"),
        ("a,b,c\nx,p,one\ny,q,2\n", "expected a number"),
        ("a,b,c\nx,p,inf\ny,q,2\n", "expected a finite number"),
        ("a,b,c\nx,,1\ny,q,2\n", "has no b"),
        ("a,b,c\nx,p,1\nx,q,2\n", "nothing can be compared"),
    ],
)
def test_a_table_that_is_none_is_refused_with_the_place(
    text: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    path = tmp_path / "t.csv"
    path.write_text(text)
    assert run(monkeypatch, str(path), "--by", "a", "--participant", "b", "--measures", "c") == 2
    assert said in " ".join(capsys.readouterr().err.split())
    path.write_bytes(b"a,b\n\xff\xfe,\x00\n")
    assert run(monkeypatch, str(path), "--by", "a") == 2
    assert run(monkeypatch, str(tmp_path), "--by", "a") == 2
