"""Reads what the report is made of, the CSV files of docs/data, and brings all evidence into rows of one form."""

import csv
import functools
import os
import sys

from short_model import Short

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools"))
from scenes import SCENES  # noqa: E402 (after the path)

FOLDER = [os.path.join(ROOT, "docs", "data")]
PROCESSES = 1, 2, 4, 8, 16, 32
WAYS = DIRECT, SWARM, POOL = "spatial, direct", "spatial, DMSwarmMigrate", "pool"
CLASSES = "critical path", "closed form", "injected simulation", "emulated simulation"
BOXES = "box2d", "box3d"
WEAK = 16384  # particles a process of the boxes


def value(text):
    try:
        number = float(text)
        return int(number) if number.is_integer() and "." not in text and "e" not in text.lower() else number
    except (TypeError, ValueError):
        return text


@functools.cache
def rows(name):
    with open(os.path.join(FOLDER[0], name), newline="") as f:
        return tuple({k: value(v) for k, v in row.items()} for row in csv.DictReader(f))


def use(folder):
    """Reads other data from now on: the test `report` falsifies some."""
    FOLDER[0] = folder
    for function in (rows, short, runs, simulations):
        function.cache_clear()


def way(row):
    """Of a row of runs.csv or of a simulation."""
    if row["strategy"] == "serial" or row.get("ranks") == 1:
        return "one process"
    return POOL if row["strategy"] == "pool" else SWARM if row["migrate"] == "swarm" else DIRECT


def constants(scene):
    """{constant: value} of a scene."""
    return {r["constant"]: r["value"] for r in rows("constants.csv") if r["scene"] == scene}


@functools.cache
def short(scene):
    c = constants(scene)
    return Short(c["dimensions"], *(c[name] for name in "CLBRM"))


@functools.cache
def runs(study, kind):
    """Rows of real runs: `measured`, `critical path`, or `closed form`, which is computed here for the imbalance that the
    program counted. (runs.csv calls what the program printed by a calibration of that day a closed form: it is not used.)"""
    out = []
    for r in rows("scaling/runs.csv"):
        if r["study"] == study and r["class"] == ("measured" if kind == "measured" else "critical path") and r["efficiency"] != "":
            r = {**r, "class": kind, "way": way(r), "seconds": r["seconds_per_step"]}
            if kind == "closed form":
                s, p, n = short(r["scene"]), r["processes"], r["particles"]
                r["efficiency"] = (s.pool(p) if r["way"] == POOL else s.speedup(n, p, r["imbalance"])) / p
                r["seconds"] = s.C * n / r["efficiency"] / p
            if (kind, r["way"]) != ("closed form", SWARM):
                out.append(r)
    return out


@functools.cache
def simulations(study, kind):
    """Rows of simulated runs, strong, weak, strong-large or weak-large; kind: `injected simulation` or `emulated simulation`."""
    return [{**r, "class": kind, "study": study, "way": way(r), "processes": r["ranks"], "seconds": r["seconds_per_step"]}
            for r in rows(f"simulated/{study}.csv") if f"{r['mode']} simulation" == kind]  # fmt: skip


def evidence(study, kind):
    """The rows of a study in a class, with scene, way, processes, particles, seconds of a step, efficiency, imbalance."""
    return [r for r in simulations(study, kind) if r["platform"] == "cluster"] if kind.endswith("simulation") else runs(study, kind)


def efficiency(scene, study, kind, how=DIRECT):
    """{processes: efficiency}"""
    return {r["processes"]: r["efficiency"] for r in evidence(study, kind) if (r["scene"], r["way"]) == (scene, how)}


def modelled(scene, study, how="spatial direct", column="efficiency"):
    """{processes: a number of model.csv}; how: `spatial direct`, `spatial swarm` or `pool`."""
    return {r["processes"]: r[column] for r in rows("model.csv") if (r["scene"], r["study"], r["way"]) == (scene, study, how)}


def pairs(kind):
    """For each run on two processes of which wall time and this class are known: way, particles a process, and measured
    efficiency over that of the class, and measured time over that of the class."""
    if kind.endswith("simulation"):
        some, mode = rows("simulated/validate.csv"), kind.split()[0]
        one = {(r["scene"], r["particles"]): r for r in some if r["ranks"] == 1}
        for r in (r for r in some if r["ranks"] == 2):
            alone = one[r["scene"], r["particles"]]
            e = alone["real"] / r["real"] / (alone[mode] / r[mode])
            yield {"way": way(r), "share": r["particles"] / 2, "efficiency": e, "time": r["real"] / r[mode]}
        return
    for study in ("strong", "weak"):
        known = {(r["scene"], r["way"]): r for r in runs(study, "measured") if r["processes"] == 2}
        for r in (r for r in runs(study, kind) if r["processes"] == 2):
            m = known[r["scene"], r["way"]]
            yield {"way": r["way"], "share": r["particles"] / 2, "efficiency": m["efficiency"] / r["efficiency"], "time": m["seconds"] / r["seconds"]}


def title(scene):
    return SCENES[scene].title
