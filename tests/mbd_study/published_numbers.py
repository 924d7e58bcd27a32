"""Numbers of textbooks and of R's data sets, and how a table of numbers becomes a measure of a study."""

from __future__ import annotations

from itertools import product

import numpy as np
from mbd_study.analysis.measured import MeasuredValue, MeasuredValues, MeasureScale, scale_of


def numbers(text: str) -> np.ndarray:
    return np.array([float(word) for word in text.split()])


# R's `sleep` (Student 1908): ten people, two drugs; more hours of sleep.
DRUG_1 = np.array([0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0])
DRUG_2 = np.array([1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4])
# R's `depression` (Hollander & Wolfe 1973), in the help of wilcox.test.
FIRST = np.array([1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30])
SECOND = np.array([0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29])
# R's `RoundingTimes` (Hollander & Wolfe 1973), in the help of friedman.test: 22 players, three methods.
ROUNDING = numbers(
    """
    5.4 5.5 5.55 5.85 5.7 5.75 5.2 5.6 5.5 5.55 5.5 5.4 5.9 5.85 5.7 5.45 5.55 5.6 5.4 5.4 5.35 5.45 5.5 5.35
    5.25 5.15 5 5.85 5.8 5.7 5.25 5.2 5.1 5.65 5.55 5.45 5.6 5.35 5.45 5.05 5 4.95 5.5 5.5 5.4 5.45 5.55 5.5
    5.55 5.55 5.35 5.45 5.5 5.55 5.5 5.45 5.25 5.65 5.6 5.4 5.7 5.65 5.55 6.3 6.3 6.25
    """
).reshape(-1, 3)
# R's `InsectSprays` (Beall 1942): insects on twelve plots of each of six sprays.
SPRAYS = numbers(
    """
    10 7 20 14 14 12 10 23 17 20 14 13 11 17 21 11 16 14 17 17 19 21 7 13 0 1 7 2 3 1 2 1 3 0 1 4 3 5 12 6 4 3 5
    5 5 5 2 4 3 5 3 5 3 6 1 1 3 2 6 4 11 9 15 22 15 16 13 10 26 26 24 13
    """
).reshape(6, 12)
# nlme's `Orthodont` (Potthoff & Roy 1964): a distance at the ages 8, 10, 12 and 14 [mm].
ORTHODONT = """
M01 26 25 29 31; M02 21.5 22.5 23 26.5; M03 23 22.5 24 27.5; M04 25.5 27.5 26.5 27; M05 20 23.5 22.5 26; M06
24.5 25.5 27 28.5; M07 22 22 24.5 26.5; M08 24 21.5 24.5 25.5; M09 23 20.5 31 26; M10 27.5 28 31 31.5; M11 23
23 23.5 25; M12 21.5 23.5 24 28; M13 17 24.5 26 29.5; M14 22.5 25.5 25.5 26; M15 23 24.5 26 30; M16 22 21.5
23.5 25; F01 21 20 21.5 23; F02 21 21.5 24 25.5; F03 20.5 24 24.5 26; F04 23.5 24.5 25 26.5; F05 21.5 23 22.5
23.5; F06 20 21 21 22.5; F07 21.5 22.5 23 25; F08 23 23 23.5 24; F09 20 21 22 21.5; F10 16.5 19 19 19.5; F11
24.5 25 28 28
"""
PEOPLE = [line.split() for line in ORTHODONT.replace("\n", " ").split(";")]
DISTANCES = np.array([[float(v) for v in words[1:]] for words in PEOPLE])
GIRLS = np.array([words[0].startswith("F") for words in PEOPLE])


def measured(table: np.ndarray, scale: MeasureScale | None = None) -> MeasuredValues:
    """A measure of (participants, conditions); NaN: not measured."""
    values = [
        MeasuredValue(f"p{p}", f"c{c}", float(table[p, c]))
        for p, c in product(range(table.shape[0]), range(table.shape[1]))
        if not np.isnan(table[p, c])
    ]
    return MeasuredValues("m", scale or scale_of([v.value for v in values]), tuple(values))


def groups(*values: np.ndarray, scale: MeasureScale = MeasureScale.NUMBERS) -> MeasuredValues:
    """A measure of other participants in each condition."""
    rows = [MeasuredValue(f"p{c}_{k}", f"c{c}", float(v)) for c, g in enumerate(values) for k, v in enumerate(g)]
    return MeasuredValues("m", scale, tuple(rows))
