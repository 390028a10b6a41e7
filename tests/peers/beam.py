"""The beam of tests/data/reference and its two measures: what the scripts of all engines share.

A script has a list RUNS and a class Engine and ends with `beam.main(Engine, RUNS)`. Called as `SCRIPT list` it prints its runs,
one JSON object per line; called as `SCRIPT run RUN FOLDER` it makes one of them, with the meshes in FOLDER, and prints what was
measured. `cargo xtask bench peers` calls it so, one process per run and on one thread. SI units.
"""

import json
import math
import pathlib
import sys
import time

import numpy

YOUNG = 1e5
POISSON = 0.3
DENSITY = 1000.0
GRAVITY = 9.81
SIZE = (0.1, 0.02, 0.02)

# A sag that no solution comes near: the run has come apart.
LOST = 2 * SIZE[0]
# The peak is the largest sag before the curve has fallen for this time; given up after the second one.
FALLEN = 0.05
NO_PEAK = 0.6
# Between readings of the sag, for methods with shorter steps.
SAMPLE = 0.5e-3
# At rest: within this share of the exact sag, for this time and number of steps, before this time is over.
BAND = 0.01
STAYS = (0.5, 5)
NO_REST = 20.0
# A run is repeated until it has taken this CPU time, at most so often; the fastest counts.
REPEAT = (1.0, 7)


class Mesh:
    """Linear tetrahedra, all with positive volume."""

    def __init__(self, path):
        lines = pathlib.Path(path).read_text().splitlines()
        at = lines.index("$Nodes") + 1
        rows = [line.split() for line in lines[at + 1 : at + 1 + int(lines[at])]]
        index = {row[0]: i for i, row in enumerate(rows)}
        self.nodes = numpy.array([[float(v) for v in row[1:4]] for row in rows])
        at = lines.index("$Elements") + 1
        rows = [line.split() for line in lines[at + 1 : at + 1 + int(lines[at])]]
        # Type 4 is the tetrahedron; its corners follow the tags.
        tets = [[index[v] for v in row[3 + int(row[2]) :]] for row in rows if row[1] == "4"]
        self.tets = numpy.array(tets)
        a, b, c, d = (self.nodes[self.tets[:, k]] for k in range(4))
        volumes = numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6
        turned = volumes < 0
        self.tets[turned] = self.tets[turned][:, [1, 0, 2, 3]]
        self.volumes = numpy.abs(volumes)
        self.clamped = numpy.flatnonzero(self.nodes[:, 0] < 1e-6 * SIZE[0])
        self.end = numpy.flatnonzero(self.nodes[:, 0] > (1 - 1e-6) * SIZE[0])

    def masses(self):
        """A quarter of each tetrahedron's mass to each of its corners."""
        masses = numpy.zeros(len(self.nodes))
        for k in range(4):
            numpy.add.at(masses, self.tets[:, k], DENSITY * self.volumes / 4)
        return masses


class Lost(Exception):
    """The run has come apart."""


def timed(engine, steps):
    """Advances an engine; returns the CPU time of it alone, and the sag."""
    start = time.process_time()
    engine.advance(steps)
    cpu = time.process_time() - start
    sag = engine.sag()
    if not math.isfinite(sag) or abs(sag) > LOST:
        raise Lost
    return cpu, sag


def measure_peak(engine, step, exact):
    """The first peak: height and time of the parabola through the three highest readings, against the exact ones."""
    steps = max(1, round(SAMPLE / step))
    interval = steps * step
    sags, cpu, best = [0.0], 0.0, 0
    while True:
        spent, sag = timed(engine, steps)
        cpu += spent
        sags.append(sag)
        last = len(sags) - 1
        if sag > sags[best]:
            best = last
        if last > best and (last - best) * interval >= FALLEN:
            break
        if last * interval > NO_PEAK:
            return {"note": f"no peak in {NO_PEAK} s"}
    before, top, after = sags[best - 1], sags[best], sags[best + 1]
    bend = before - 2 * top + after
    slope = (after - before) / 2
    height = top if bend == 0 else top - slope * slope / (2 * bend)
    moment = best * interval if bend == 0 else (best - slope / bend) * interval
    return {
        "cpu_s_per_s": cpu / (last * interval),
        "peak_error": height / exact["peak"] - 1,
        "peak_time_error": moment / exact["time"] - 1,
    }


def measure_rest(engine, step, exact, cap):
    """From release to where the sag is, and then stays, within BAND of the exact one."""
    cpu, now, inside, entered = 0.0, 0.0, 0, None
    while True:
        spent, sag = timed(engine, 1)
        cpu += spent
        now += step
        error = sag / exact["rest"] - 1
        if abs(error) > BAND:
            inside, entered = 0, None
        else:
            inside += 1
            entered = entered or cpu
            if inside >= STAYS[1] and inside * step >= STAYS[0]:
                return {"cpu_s_to_rest": entered, "rest_error": error}
        if now > NO_REST or cpu > cap:
            why = f"not at rest after {now:.3g} s, which took {cpu:.3g} s of CPU time"
            return {"rest_error": error, "note": why}


def repeated(measure, engine):
    """A measure of a fresh body, repeated; the fastest counts."""
    results, start = [], time.process_time()
    while True:
        engine.reset()
        results.append(measure(engine))
        if time.process_time() - start > REPEAT[0] or len(results) == REPEAT[1]:
            return min(results, key=lambda r: r.get("cpu_s_per_s") or r.get("cpu_s_to_rest") or 0.0)


def run(engine_class, what, folder):
    """Makes one run; returns what was measured."""
    exact = json.loads((folder / "exact.json").read_text())[what["exact"]][what["mesh"]]
    engine = engine_class(what, folder)
    result = {"version": engine.version}
    try:
        if "peak" in what["measures"]:
            result |= repeated(lambda e: measure_peak(e, what["step"], exact), engine)
        if "rest" in what["measures"]:
            result |= repeated(lambda e: measure_rest(e, what["step"], exact, what["cap"]), engine)
    except Lost:
        result["note"] = "comes apart"
    return result


def plan(method, mesh, steps_ms, measures, describe, exact, /, slow=None, cap=60.0, **settings):
    """Runs of one method over steps; `slow` says why they are left out unless everything is asked for."""
    return [
        {
            "method": method,
            "mesh": mesh,
            "step": step / 1e3,
            "measures": measures,
            "settings": describe,
            "exact": exact,
            "slow": slow,
            "cap": cap,
            "engine": settings,
        }
        for step in steps_ms
    ]


def main(engine_class, runs):
    """The command line."""
    if sys.argv[1] == "list":
        for what in runs:
            print(json.dumps(what))
    else:
        result = run(engine_class, json.loads(sys.argv[2]), pathlib.Path(sys.argv[3]))
        print(json.dumps(result))
