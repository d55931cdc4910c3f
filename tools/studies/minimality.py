#!/usr/bin/env python3
"""Measures what each scene of options/ carries and sends beside the same scene with -method_carry all: fields and bytes of a
particle, phases of a step, bytes of messages of a step on 2 processes, time of a step. Writes docs/data/minimality.csv.
Scenes in the total frame, which knows no -method_carry, are left out.

    minimality.py                  measures what the file lacks; --again: everything; --scenes disks taylor: these alone

Times are processor times of runs in turns, with and without, so load of the machine enters the ratio little: the median of
the ratios of --pairs pairs. A run takes about half a second, or all steps of the scene if they take less.
"""
import argparse
import csv
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools"))
import launch  # noqa: E402 (after the path)

SECONDS, FIRST, SENT = 0.5, 100, 20  # of a timed run; steps of the run that estimates how many these are; steps whose messages count
MODES = ("needed", "all")
COLUMNS = ["scene", "fields", "bytes", "bytes_all", "phases", "sent", "sent_all", "ns", "ratio"]
# Scenes of options/ as they are, and some with a choice that changes what they need.
CHANGED = {"column, F not shown": ("column", ["-output_fields", "velocity"]), "taylor, F not shown": ("taylor", ["-output_fields", "velocity"])}


class Study:
    def __init__(self, pebble, mpiexec, folder):
        self.pebble, self.mpiexec, self.folder = os.path.abspath(pebble), mpiexec, folder

    def command(self, scene, mode, steps):
        name, more = CHANGED.get(scene, (scene, []))
        return [self.pebble, "-options_file", os.path.join(ROOT, "options", name + ".opts"), "-output_dir", self.folder, "-output_name", "run",
                "-output_every", 1e9, "-history_every", 1e9, "-time_max_steps", steps, "-method_carry", mode, *more]

    def said(self, command):
        told = launch.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self.folder)
        if told.returncode:
            raise RuntimeError(f"exit status {told.returncode}: {' '.join(map(str, command))}\n{told.stdout[-800:]}")
        return told.stdout

    def processor(self, command):
        """Processor time of a run in s."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.said(command)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def sent(self, scene, mode):
        """Bytes that a step sends on 2 processes. -log_view counts a message where it leaves and where it arrives."""
        self.said([self.mpiexec, "-n", 2, *self.command(scene, mode, SENT), "-log_view", ":log.csv:ascii_csv"])
        with open(os.path.join(self.folder, "log.csv"), newline="") as file:
            return sum(float(row["Message Length"]) for row in csv.DictReader(file)
                       if row["Stage Name"] == "MPM steps" and row["Event Name"] == "summary" and row["Rank"]) / 2 / SENT

    def times(self, scene, pairs, particles, most):
        """ns a particle and step, and the ratio of the time with everything to it."""
        zero = {mode: min(self.processor(self.command(scene, mode, 0)) for _ in range(3)) for mode in MODES}
        guess = max(1e-6, self.processor(self.command(scene, "needed", FIRST)) - zero["needed"]) / FIRST
        steps = int(max(FIRST, min(SECONDS / guess, most)))
        taken = {mode: [] for mode in MODES}
        for k in range(pairs):
            for mode in MODES[:: 1 if k % 2 else -1]:
                taken[mode].append(self.processor(self.command(scene, mode, steps)) - zero[mode])
        ratio = statistics.median(b / a for a, b in zip(taken["needed"], taken["all"]))
        return 1e9 * statistics.median(taken["needed"]) / steps / particles, ratio

    def row(self, scene, pairs):
        said = {mode: self.said([*self.command(scene, mode, FIRST), "-report_phases"]) for mode in MODES}
        digests = [re.search(r"^digest (\w+)", s, re.M)[1] for s in said.values()]
        if digests[0] != digests[1]:
            raise RuntimeError(f"{scene}: with all fields the digest is {digests[1]}, not {digests[0]}")
        memory = [int(re.search(r"(\d+) with order and scratch", s)[1]) for s in said.values()]
        fields = re.search(r"^fields +((?:[A-Za-z]+ )+)", said["needed"], re.M)[1].strip()
        table = said["needed"].partition("\nphase ")[2].partition("\n  all ")[0]
        phases = [name for name in re.findall(r"^  (\S+) ", table, re.M) if name not in ("REDUCE", "MIGRATE", "SORT", "SETTLE", "other")]
        particles = int(re.search(r"(\d+) particles", said["needed"])[1])
        ns, ratio = self.times(scene, pairs, particles, float(re.search(r"^predict +([\d.e+]+) steps", self.said([*self.command(scene, "needed", 10**9), "-dry_run"]), re.M)[1]))
        sent = [self.sent(scene, mode) for mode in MODES]
        return dict(zip(COLUMNS, [scene, fields, *memory, " ".join(phases), *(f"{s:.0f}" for s in sent), f"{ns:.3g}", f"{ratio:.2f}"]))


def read(path):
    if not os.path.exists(path):
        return {}
    with open(path, newline="") as file:
        return {row["scene"]: row for row in csv.DictReader(file)}


def write(path, rows):
    with open(path, "w", newline="") as file:
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        out.writerows(rows[scene] for scene in sorted(rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--data", default=os.path.join(ROOT, "docs", "data"), help="folder of minimality.csv")
    parser.add_argument("--jobs", help="is taken and not used: runs are timed, one after the other")
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--scenes", nargs="+")
    parser.add_argument("--again", action="store_true", help="measure also what the file has")
    arguments = parser.parse_args()
    path = os.path.join(arguments.data, "minimality.csv")
    rows = read(path)
    names = sorted(name[:-5] for name in os.listdir(os.path.join(ROOT, "options")) if name.endswith(".opts"))
    names = [name for name in names if "-method_preset solid" not in open(os.path.join(ROOT, "options", name + ".opts")).read()]
    rows = {scene: row for scene, row in rows.items() if scene in [*names, *CHANGED]}
    for scene in arguments.scenes or [*names, *CHANGED]:
        if scene in rows and not arguments.again:
            continue
        with tempfile.TemporaryDirectory() as folder:
            rows[scene] = Study(arguments.pebble, arguments.mpiexec, folder).row(scene, arguments.pairs)
        print(", ".join(map(str, rows[scene].values())), flush=True)
        os.makedirs(arguments.data, exist_ok=True)
        write(path, rows)


if __name__ == "__main__":
    main()
