"""Comparisons of groups, and learning curves. Pure: numbers in, numbers out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Comparison:
    """Two groups beside each other. Positive: the second has more."""

    counts: tuple[int, int]
    means: tuple[float, float]
    deviations: tuple[float, float]
    # Hedges' g: difference of the means in pooled standard deviations, without the bias of small groups.
    g: float
    # Its interval of confidence.
    low: float
    high: float
    confidence: float


def compare(first: Iterable[float], second: Iterable[float], confidence: float = 0.95) -> Comparison:
    """Hedges' g of two groups with its interval of confidence.

    g is Cohen's d times 1 − 3/(4 ν − 1), ν = n + m − 2 (Hedges 1981). The interval is that of the noncentral t distribution, times the
    same factor: exact for normal groups of one variance. Raises `ValueError` where a group has less than two values or neither varies.
    """
    a, b = list(map(float, first)), list(map(float, second))
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"a confidence of {confidence}; expected between 0 and 1")
    if min(len(a), len(b)) < 2:
        raise ValueError(f"groups of {len(a)} and {len(b)}; expected two values in each at least")
    if not all(map(math.isfinite, a + b)):
        raise ValueError("a value that is no number")
    n, m = len(a), len(b)
    means = math.fsum(a) / n, math.fsum(b) / m
    squares = [math.fsum((x - mean) ** 2 for x in group) for group, mean in zip((a, b), means)]
    freedom = n + m - 2
    pooled = math.sqrt(sum(squares) / freedom)
    if pooled == 0.0:
        raise ValueError("neither group varies")
    root = math.sqrt(n * m / (n + m))
    t = (means[1] - means[0]) / pooled * root
    unbiased = 1.0 - 3.0 / (4.0 * freedom - 1.0)
    tail = (1.0 - confidence) / 2.0
    low, high = (_noncentrality(t, freedom, p) for p in (1.0 - tail, tail))
    deviations = tuple(math.sqrt(s / (k - 1)) for s, k in zip(squares, (n, m)))
    return Comparison(
        (n, m), means, (deviations[0], deviations[1]), unbiased * t / root, unbiased * low / root, unbiased * high / root, confidence
    )


def _noncentrality(t: float, freedom: float, probability: float) -> float:
    """The noncentrality with which the distribution function at t has this value: it falls with the noncentrality."""
    low, high = t - 1.0, t + 1.0
    while noncentral_t(t, freedom, low) < probability:
        low -= 2.0 * (high - low)
    while noncentral_t(t, freedom, high) > probability:
        high += 2.0 * (high - low)
    # False position with the weight of an end that stays halved (Illinois).
    at_low, at_high = (noncentral_t(t, freedom, end) - probability for end in (low, high))
    for _ in range(100):
        middle = (low * at_high - high * at_low) / (at_high - at_low)
        value = noncentral_t(t, freedom, middle) - probability
        if abs(value) < 1e-14 or high - low < 1e-12:
            return middle
        if value > 0.0:
            low, at_low = middle, value
            at_high *= 0.5
        else:
            high, at_high = middle, value
            at_low *= 0.5
    return 0.5 * (low + high)


# Steps of an integral for each width of its density.
_FINENESS = 14.0


def _normal(x: float) -> float:
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def noncentral_t(t: float, freedom: float, noncentrality: float) -> float:
    """Distribution function of the noncentral t distribution of two degrees of freedom or more.

    T ≤ t where Z + δ ≤ t √(W/ν), with W distributed as χ² of ν degrees of freedom: the mean of Φ(t s − δ) over s = √(W/ν), by the
    trapezoidal rule over the logarithm of s: what is smooth and vanishes at both ends converges faster than any power of the step.
    """
    # ln of the density of s over ln s: a factor, then ν (ln s − s²/2).
    factor = math.log(2.0) + 0.5 * freedom * math.log(0.5 * freedom) - math.lgamma(0.5 * freedom)

    def density(u: float) -> float:
        exponent = factor + freedom * (u - 0.5 * math.exp(2.0 * u))
        return math.exp(exponent) if exponent > -745.0 else 0.0

    # The density falls as exp(ν u) on the left, as a normal one of width 1/√(2 ν) around its top, and faster on the right.
    width = 1.0 / math.sqrt(2.0 * freedom)
    low, high = -(40.0 / freedom + 8.0 * width), 9.0 * width
    steps = math.ceil((high - low) / width * _FINENESS)
    h = (high - low) / steps
    places = [low + k * h for k in range(steps + 1)]
    parts = [density(u) * _normal(t * math.exp(u) - noncentrality) for u in places]
    return min(1.0, max(0.0, math.fsum(parts) * h))


@dataclass(frozen=True)
class Cusum:
    """A learning curve: a sum that falls with successes and rises with failures."""

    # After each attempt.
    values: tuple[float, ...]
    # At or below it the failure rate is acceptable; at or above `upper` it is not.
    lower: float
    upper: float
    # Index of the first attempt after which a limit is reached; `None`: nothing is decided yet.
    decided: int | None

    @property
    def verdict(self) -> str:
        """`acceptable`, `unacceptable` or `undecided`."""
        if self.decided is None:
            return "undecided"
        return "acceptable" if self.values[self.decided] <= self.lower else "unacceptable"


def cusum(
    successes: Sequence[bool], acceptable: float = 0.05, unacceptable: float = 0.15, alpha: float = 0.1, beta: float = 0.1
) -> Cusum:
    """The CUSUM learning curve of attempts in their order.

    With P = ln(p1/p0) and Q = ln((1 − p0)/(1 − p1)) a success takes s = Q/(P + Q) off and a failure adds 1 − s; the limits are
    −ln((1 − α)/β)/(P + Q) and ln((1 − β)/α)/(P + Q). Failure rates of 5 % and 15 % are published (PMC4188705); `microsim results` has
    the same numbers.
    """
    if not 0.0 < acceptable < unacceptable < 1.0:
        raise ValueError("expected failure rates with 0 < acceptable < unacceptable < 1")
    if not (0.0 < alpha < 0.5 and 0.0 < beta < 0.5):
        raise ValueError("expected errors between 0 and 0.5")
    p = math.log(unacceptable / acceptable)
    q = math.log((1.0 - acceptable) / (1.0 - unacceptable))
    step = q / (p + q)
    lower, upper = -math.log((1.0 - alpha) / beta) / (p + q), math.log((1.0 - beta) / alpha) / (p + q)
    values: list[float] = []
    decided, failures = None, 0
    for index, success in enumerate(successes):
        failures += not success
        # Counted and then multiplied: the same sum without the rounding of each step.
        value = failures - (index + 1) * step
        values.append(value)
        if decided is None and not lower < value < upper:
            decided = index
    return Cusum(tuple(values), lower, upper, decided)
