"""An attempt: a session with its result, from the store or from the file of the session."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Attempt:
    """A session with its result."""

    id: str
    path: str
    # Id of the trainee; `None` for a run without one.
    trainee: str | None
    module: str
    level: int
    # Wall clock, seconds since 1970.
    started: int
    verdict: str
    # Whether it counts as a result of the trainee.
    counts: bool
    # By what a synthetic trainee was made; `None` for people.
    synthetic: str | None
    # 0 to 100; `None` where nothing was judged.
    score: float | None
    # Running time of the level [s].
    duration: float
    # Values in SI units by the ids of metrics; one that was not applicable is not there.
    metrics: Mapping[str, float]

    @property
    def passed(self) -> bool:
        """Whether the level was passed."""
        return self.verdict == "passed"

    def value(self, what: str) -> float | None:
        """`score`, `duration`, or the metric of this id."""
        if what == "score":
            return self.score
        if what == "duration":
            return self.duration
        return self.metrics.get(what)
