"""What every command says of a line that it cannot use: one line, the reason, and the word that was meant."""

from __future__ import annotations

import ast
import math
from enum import StrEnum
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.command_line.parser import MISUSED, CommandParser
from mbd_model.command_line.values import above_zero, at_least_one, finite, zero_or_more, zero_to_one

SRC = Path(__file__).resolve().parents[2] / "ros2_ws" / "src"


class Colour(StrEnum):
    """Some choices."""

    RED = "red"
    GREEN = "green"


def parser() -> CommandParser:
    made = CommandParser(prog="share", description="``share BAG``: copy.", instead={"--folder": "--out"})
    made.add_argument("bags", nargs="+", type=Path)
    made.add_argument("--out", type=Path, required=True)
    made.add_argument("--cameras", action="store_true")
    made.add_argument("--seed", type=int)
    made.add_argument("--rate", type=float, default=1.0)
    made.add_argument("--colour", type=Colour, choices=list(Colour))
    return made


def refusal(words, capsys, of=None) -> str:
    with pytest.raises(SystemExit) as ended:
        (of or parser()).parse_args(words)
    said = capsys.readouterr().err
    assert ended.value.code == MISUSED
    assert said.startswith("share: ") and said.endswith("; --help says what it takes\n") and said.count("\n") == 1
    return said.removeprefix("share: ").removesuffix("; --help says what it takes\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["bag", "--out", "o", "--camera-pictures"], "there is no option --camera-pictures; did you mean --cameras?"),
        (["bag", "--ouut", "o"], "there is no option --ouut; did you mean --out?"),
        (["bag", "--sed=3", "--out", "o"], "there is no option --sed; did you mean --seed?"),
        (["bag", "--folder", "o"], "there is no option --folder; did you mean --out?"),
        (["bag", "--out", "o", "-x"], "there is no option -x"),
        (["bag", "--out", "o", "--qqqq"], "there is no option --qqqq"),
        (["bag"], "the following arguments are required: --out"),
        (["bag", "--out", "o", "--seed", "-1"], "--seed: -1 is too few; expected 0 or more"),
        (["bag", "--out", "o", "--seed", "abc"], "--seed: 'abc' is no whole number; expected 0 or more"),
        (["bag", "--out", "o", "--rate", "nan"], "--rate: 'nan' is no finite number"),
        (["bag", "--out", ""], "--out: the path is empty (a shell variable that is not set?)"),
        (["bag", "--out"], "--out: expected one argument"),
        (["bag", "--out", "o", "--colour", "gren"], "--colour: 'gren' is none of red, green; did you mean green?"),
    ],
)
def test_a_line_that_cannot_be_used_is_refused_in_one_line(words, said, capsys):
    assert refusal(words, capsys) == said


def test_a_word_too_many_is_named(capsys):
    made = CommandParser(prog="share")
    made.add_argument("bag")
    assert refusal(["a", "b"], capsys, made) == "'b' is one word too many"
    assert refusal(["a", ""], capsys, made) == "'' is one word too many"


def test_an_option_of_a_sub_command_is_found_too(capsys):
    made = CommandParser(prog="share")
    made.add_subparsers(dest="word", required=True).add_parser("write").add_argument("--tier")
    assert refusal(["write", "--teir", "gaze"], capsys, made) == "there is no option --teir; did you mean --tier?"
    assert refusal(["wriet"], capsys, made).startswith("word: 'wriet' is none of write; did you mean write?")


def test_what_stands_behind_two_dashes_is_no_option():
    assert parser().parse_args(["--out", "o", "--", "--odd"]).bags == [Path("--odd")]


def test_the_beginning_of_an_option_stands_for_it():
    assert parser().parse_args(["bag", "--out", "o", "--cam"]).cameras


@given(st.floats().map(str) | st.text(max_size=6))
def test_a_number_is_taken_within_its_bounds_or_refused(word):
    for reading, low, high in (
        (finite, -math.inf, math.inf),
        (zero_or_more, 0.0, math.inf),
        (above_zero, 5e-324, math.inf),
        (zero_to_one, 0.0, 1.0),
        (at_least_one, 1, math.inf),
    ):
        try:
            value = reading(word)
        except Exception as error:
            assert type(error).__name__ == "ArgumentTypeError" and "\n" not in str(error).replace(word, "")
            continue
        assert low <= value <= high and math.isfinite(value)


def test_every_command_takes_its_line_by_this_parser():
    """Another one would print its whole usage for a misspelt option."""
    plain = [
        str(file.relative_to(SRC))
        for file in sorted(SRC.glob("*/*/**/*.py"))
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] == "ArgumentParser"
    ]
    assert plain == []
