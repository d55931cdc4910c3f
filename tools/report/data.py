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
    except ValueError:
        return text


@functools.cache
def rows(name):
    with open(os.path.join(FOLDER[0], f"{name}.csv"), newline="") as f:
        return tuple({k: value(v) for k, v in row.items()} for row in csv.DictReader(f))


def find(some, column, by="processes", **which):
    """{by: column} of those rows that have these values; `some` are rows, or the name of a file."""
    return {r[by]: r[column] for r in (rows(some) if isinstance(some, str) else some) if all(r[k] == v for k, v in which.items())}


def use(folder):
    """Reads other data from now on: the test `report` falsifies some."""
    FOLDER[0] = folder
    for function in (rows, short, evidence):
        function.cache_clear()


def constants(scene):
    """{constant: value} of a scene."""
    return find("constants", "value", "constant", scene=scene)


@functools.cache
def short(scene):
    c = constants(scene)
    return Short(SCENES[scene].dim, *(c[name] for name in "CLBRM"))


def way(row):
    """Of a row of runs.csv or of a simulation."""
    if row["strategy"] == "serial" or row.get("ranks") == 1:
        return "one process"
    name = POOL if row["strategy"] == "pool" else SWARM if row["migrate"] == "swarm" else DIRECT
    return f"{name}, racks of 32" if row.get("platform") == "fattree" else name


@functools.cache
def evidence(study, kind):
    """The rows of a study (strong, weak; simulated also strong-large, weak-large) in a class of evidence or `measured`, with
    scene, way, processes, particles, seconds of a step, efficiency and imbalance. A closed form is computed here for the
    imbalance that the program counted. (What runs.csv calls so was printed by a calibration of that day, and is not used.)"""
    if kind.endswith("simulation"):
        some = (r for r in rows(f"simulated/{study}") if f"{r['mode']} simulation" == kind)
        return [r | dict(way=way(r), processes=r["ranks"], seconds=r["seconds_per_step"]) for r in some]
    out = []
    for r in rows("scaling/runs"):
        if r["study"] == study and r["class"] == ("measured" if kind == "measured" else "critical path") and r["efficiency"] != "":
            r = r | dict(way=way(r), seconds=r["seconds_per_step"])
            if kind == "closed form":
                s, p, n = short(r["scene"]), r["processes"], r["particles"]
                r["efficiency"] = (s.pool(p) if r["way"] == POOL else s.speedup(n, p, r["imbalance"])) / p
                r["seconds"] = s.C * n / r["efficiency"] / p
            if (kind, r["way"]) != ("closed form", SWARM):
                out.append(r)
    return out


def efficiency(scene, study, kind, how=DIRECT):
    """{processes: efficiency}"""
    return find(evidence(study, kind), "efficiency", scene=scene, way=how)


def modelled(scene, study, how=DIRECT, column="efficiency"):
    """{processes: what the full model says}"""
    return find("model", column, scene=scene, study=study, way=how)


def pairs(kind):
    """For each run on two processes of which wall time and this class are known: way, particles a process, and measured over
    what the class says, of the efficiency and of the time."""
    if kind.endswith("simulation"):
        some, mode = rows("simulated/validate"), kind.split()[0]
        alone = {(r["scene"], r["particles"]): r["real"] / r[mode] for r in some if r["ranks"] == 1}
        for r in (r for r in some if r["ranks"] == 2):
            time = r["real"] / r[mode]
            yield way(r), r["particles"] / 2, alone[r["scene"], r["particles"]] / time, time
        return
    for study in ("strong", "weak"):
        measured, said = ({(r["scene"], r["way"]): r for r in evidence(study, k) if r["processes"] == 2} for k in ("measured", kind))
        for key, r in said.items():
            yield key[1], r["particles"] / 2, measured[key]["efficiency"] / r["efficiency"], measured[key]["seconds"] / r["seconds"]
