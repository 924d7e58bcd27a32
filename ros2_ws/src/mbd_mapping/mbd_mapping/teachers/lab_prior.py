"""What earlier sessions of the same lab say of the next one: which features mattered, how often assists were wrong.

Counts of finished sessions, kept in a JSON file, off unless asked for. Either the lab's tasks go by any feature as
often as by any other, or by some more often (a Dirichlet distribution worth PSEUDO_SESSIONS): both are weighed by how
well they explain the uses seen, and a feature's weight is its expected share. A short history, or one whose uses look
drawn at random, therefore changes little. The rate of wrong assists is drawn towards the configuration's by
PSEUDO_ASSISTS.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from mbd_model.assists import Assist
from mbd_model.errors import MbdError
from mbd_model.estimate import Feature, MappingEstimate

from mbd_mapping.config import MappingConfig

FEATURES = tuple(Feature)
PSEUDO_SESSIONS = 4.0
PSEUDO_ASSISTS = 40.0
INFORMS = 0.2  # probability beforehand that a lab's tasks prefer some features: a dozen sessions at random look uneven
LEAST_ERROR, MOST_ERROR = 0.005, 0.3


class LabPriorError(MbdError):
    """A file that holds no lab prior."""


@dataclass(frozen=True)
class LabPrior:
    """Counts of finished sessions.

    Attributes:
        uses: (7,) sessions in which each feature mattered; a session that several explain counts a part for each.
        sessions: how many.
        assists, wrong: how many assists were given, and how many of them the mapping at the end contradicts.
    """

    uses: tuple[float, ...] = (0.0,) * len(FEATURES)
    sessions: int = 0
    assists: int = 0
    wrong: int = 0

    def __post_init__(self) -> None:
        """Validate once; raises LabPriorError naming what is wrong."""
        if len(self.uses) != len(FEATURES) or not all(math.isfinite(u) and u >= 0.0 for u in self.uses):
            raise LabPriorError(f"lab prior 'uses' is {self.uses}; expected {len(FEATURES)} counts, 0 or more")
        if self.sessions < 0 or not 0 <= self.wrong <= self.assists:
            raise LabPriorError(
                f"lab prior counts {self.sessions} sessions and {self.wrong} wrong of {self.assists} assists; expected "
                "counts, no more wrong than given"
            )

    def after(self, end: MappingEstimate, assists: Sequence[Assist]) -> LabPrior:
        """With one more session, by its last estimate and all its assists."""
        share = 1.0 / len(end.winning) if end.winning else 0.0
        uses = tuple(u + share * (f in end.winning) for u, f in zip(self.uses, FEATURES, strict=True))
        mapped = end.best_guess.as_dict
        wrong = sum(mapped.get(a.source_id) != a.target_id for a in assists)
        return LabPrior(uses, self.sessions + 1, self.assists + len(assists), self.wrong + wrong)

    @property
    def informs(self) -> float:
        """Probability that the lab's tasks go by some features more often than by others."""
        count, total = len(FEATURES), sum(self.uses)
        each = PSEUDO_SESSIONS / count
        own = sum(math.lgamma(each + u) - math.lgamma(each) for u in self.uses)
        own += math.lgamma(PSEUDO_SESSIONS) - math.lgamma(PSEUDO_SESSIONS + total)
        against = (1.0 - INFORMS) / INFORMS * math.exp(min(600.0, -total * math.log(count) - own))
        return 1.0 / (1.0 + against)

    def _own_weights(self) -> tuple[float, ...]:
        """(7,) how often each feature matters if some do more often, relative to the mean."""
        each, total = PSEUDO_SESSIONS / len(FEATURES), sum(self.uses) + PSEUDO_SESSIONS
        return tuple(len(FEATURES) * (u + each) / total for u in self.uses)

    def applied_to(self, config: MappingConfig) -> MappingConfig:
        """The configuration with what was learned."""
        features = tuple(1.0 + self.informs * (weight - 1.0) for weight in self._own_weights())
        error = (self.wrong + PSEUDO_ASSISTS * config.assist_error) / (self.assists + PSEUDO_ASSISTS)
        return replace(
            config,
            priors=replace(config.priors, features=features),
            assist_error=min(MOST_ERROR, max(LEAST_ERROR, error)),
        )

    @staticmethod
    def of(history: Iterable[tuple[MappingEstimate, Sequence[Assist]]]) -> LabPrior:
        """From the last estimate and the assists of each session."""
        prior = LabPrior()
        for end, assists in history:
            prior = prior.after(end, assists)
        return prior

    def write(self, path: Path) -> None:
        """As JSON; features by name."""
        named = {**asdict(self), "uses": dict(zip(map(str, FEATURES), self.uses, strict=True))}
        path.write_text(json.dumps(named, indent=2) + "\n", encoding="utf-8")

    @staticmethod
    def read(path: Path) -> LabPrior:
        """What `write` wrote; raises LabPriorError when there is no such file or it is none."""
        try:
            found = json.loads(path.read_text(encoding="utf-8-sig"))
            uses = tuple(float(found["uses"][str(f)]) for f in FEATURES)
            return LabPrior(uses, int(found["sessions"]), int(found["assists"]), int(found["wrong"]))
        except OSError as error:
            raise LabPriorError(f"cannot read {path}: {error.strerror}; learn one first, or leave it off") from error
        except (ValueError, KeyError, TypeError) as error:
            raise LabPriorError(f"{path} is no lab prior ({error!r}); learn it again") from error
