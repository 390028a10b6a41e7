"""Two groups beside each other, and the learning curve of everyone in them.

Cells begin with `# %%`: editors with notebooks run them one by one; as a program it is

    python compare_groups.py --store --groups Experts Novices --module coordination --level 2
    python compare_groups.py --sessions FOLDER

With `--store` the groups are those of the store (`microsim trainees`), with `--sessions` the kinds of synthetic trainees among the sessions
of a folder. Pictures are drawn where matplotlib is installed, into `--out`.
"""

# %% What is compared
from __future__ import annotations

import argparse
from pathlib import Path

import microsim

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
source = arguments.add_mutually_exclusive_group(required=True)
source.add_argument("--store", nargs="?", const=microsim.default_store(), type=Path, help="the store [default: that of the user]")
source.add_argument("--sessions", type=Path, help="a folder of sessions of synthetic trainees")
arguments.add_argument("--groups", nargs=2, metavar=("FIRST", "SECOND"), default=("expert", "novice"))
arguments.add_argument("--module")
arguments.add_argument("--level", type=int)
arguments.add_argument("--what", default="duration", help="score, duration or the id of a metric")
arguments.add_argument("--out", type=Path, default=Path("."), help="folder for pictures")
chosen = arguments.parse_args()


def kind(attempt: microsim.Attempt) -> str:
    """Of what kind a synthetic trainee is: `profile novice, seed 3, from …`."""
    return (attempt.synthetic or "").removeprefix("profile ").split(",")[0]


def wanted(attempt: microsim.Attempt) -> bool:
    return chosen.module in (None, attempt.module) and chosen.level in (None, attempt.level) and attempt.counts


# %% Attempts of both groups, in the order in which they were made
attempts: dict[str, list[microsim.Attempt]] = {}
for group in chosen.groups:
    if chosen.sessions:
        found = [a for a in microsim.attempts_in(chosen.sessions) if kind(a) == group]
    else:
        with microsim.Store.open(chosen.store) as store:
            if group not in store.groups():
                raise SystemExit(f"no group {group!r}; there are: {', '.join(store.groups()) or 'none'}")
            found = list(store.attempts(group=group))
    attempts[group] = [attempt for attempt in found if wanted(attempt)]
    passed = sum(attempt.passed for attempt in attempts[group])
    print(f"{group}: {len(attempts[group])} attempts, {passed} passed")

# %% How much more the second group has than the first: Hedges' g with its interval of 95 %
# Attempts of one trainee are not independent: what is compared is the mean of each. A synthetic trainee makes one attempt.
values = {}
for group in chosen.groups:
    of_trainee: dict[str, list[float]] = {}
    for attempt in attempts[group]:
        value = attempt.value(chosen.what)
        if value is not None:
            of_trainee.setdefault(attempt.synthetic or attempt.trainee or attempt.id, []).append(value)
    values[group] = [sum(list_) / len(list_) for list_ in of_trainee.values()]
first, second = chosen.groups
try:
    comparison = microsim.compare(values[first], values[second])
except ValueError as error:
    raise SystemExit(f"{chosen.what} cannot be compared: {error}") from error
for group, mean, deviation, count in zip(chosen.groups, comparison.means, comparison.deviations, comparison.counts):
    print(f"{chosen.what} of {group}: mean {mean:.4g}, standard deviation {deviation:.3g}, {count} trainees")
print(f"Hedges' g {comparison.g:.2f} (95 %: {comparison.low:.2f} to {comparison.high:.2f}); positive: {second} has more")

# %% Learning curves: a sum that falls with every pass and rises with every failure
curves = {}
for group in chosen.groups:
    for who in dict.fromkeys(attempt.trainee for attempt in attempts[group]):
        outcomes = [attempt.passed for attempt in attempts[group] if attempt.trainee == who]
        curve = microsim.cusum(outcomes)
        curves[group, who] = curve
        print(f"{group}, {who or 'all'}: {len(outcomes)} attempts, CUSUM {curve.values[-1]:.2f}: {curve.verdict}")

# %% Pictures
try:
    import matplotlib
except ImportError:
    print("No pictures: matplotlib is not installed")
else:
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    left.boxplot([values[group] for group in chosen.groups], tick_labels=list(chosen.groups))
    left.set_ylabel(f"{chosen.what} [s]" if chosen.what == "duration" else chosen.what)
    left.set_title(f"g = {comparison.g:.2f} ({comparison.low:.2f} to {comparison.high:.2f})")
    for (group, who), curve in curves.items():
        right.plot(range(1, len(curve.values) + 1), curve.values, marker=".", label=f"{group}, {who or 'all'}")
        right.axhline(curve.lower, color="green", linewidth=0.5)
        right.axhline(curve.upper, color="red", linewidth=0.5)
    right.set_xlabel("attempt")
    right.set_ylabel("CUSUM")
    right.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    picture = chosen.out / "compare_groups.png"
    figure.savefig(picture, dpi=150)
    print(f"Picture: {picture}")
