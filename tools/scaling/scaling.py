#!/usr/bin/env python3
"""Measures how pebble scales: `make scaling`, or `make scaling SCALING=full` (larger, longer and more often).

The machine has fewer cores than the processes that are asked for, so a run on more gives no speed-up by the clock. The column
`class` says which time stands in its place, and no line of a figure joins two classes:

  measured        wall time of a step, where every process has a core
  oversubscribed  wall time where a process has none: it is recorded, and gives no speed-up
  critical path   -report_path: the slowest process's own processor time in each phase of each step, and the messages
                  by the model
  closed form     what the model (docs/model.md) predicts from constants measured on 1 and 2 processes

There are two studies: strong (the same scene on all numbers of processes) and weak (about 16,384 particles a process), with spatial
decomposition (particles migrate `direct`; some runs also by `swarm`) and with the pool, in the patches that the model finds best
on 8 processes. In each, all runs of a scene must give the same digest. Then `counts` compares messages and bytes of a full box by -log_view with formulas, exactly; `users` has
measured and predicted steps of whole runs of the scenes of options/, started one by one as users start them; `lengths` has runs ten times as long as those of strong.

The program writes docs/data/scaling/*.csv and docs/scaling-*.png; its exit status is 1 when digests or counts differ or a run
failed.
"""
import argparse
import csv
import datetime
import glob
import os
import re
import sys

import counts
import runs
import scenes
from runs import Failed, Run

COLUMNS = ["scene", "dim", "basis", "update", "study", "strategy", "migrate", "pool_cells", "processes", "particles", "steps", "class",
           "seconds_per_step", "speedup", "efficiency", "efficiency_net_of_imbalance", "imbalance", "work_imbalance",
           "messages_per_step", "bytes_per_particle_step", "reductions_per_step", "migrating_steps", "digest"]
COUNTS = ["scene", "dim", "basis", "update", "strategy", "processes", "grid", "particles", "quantity", "counted",
          "formula", "equal"]
PHASES = ["scene", "study", "strategy", "migrate", "processes", "particles", "phase", "mean_seconds", "slowest_seconds",
          "message_seconds", "messages_per_step", "bytes_per_step"]
USERS = ["scene", "processes", "repeats", "measured", "predicted"]
LENGTHS = ["scene", "particles", "processes", "steps", "repeats", "seconds_per_step"]
SIZES = (1, 2, 4, 8, 16, 32)
ORDER = [scene.name for scene in runs.SCENES]


class Results:
    def __init__(self, args):
        self.args, self.users, self.lengths, self.problems = args, [], [], []
        # What is not measured now is kept: the tables of other parts, and with --scenes the rows of other scenes.
        self.runs, self.phases, self.counts = (
            [row for row in self.read(name) if part not in args.only or args.scenes and row["scene"] not in args.scenes]
            for name, part in (("runs", "scaling"), ("phases", "scaling"), ("counts", "counts")))

    def read(self, name):
        try:
            with open(os.path.join(self.args.data, name + ".csv"), newline="") as file:
                return list(csv.DictReader(file))
        except OSError:
            return []

    def problem(self, text):
        self.problems.append(text)
        print(f"  FAILED {text}", flush=True)

    def write(self):
        os.makedirs(self.args.data, exist_ok=True)
        for name, columns, rows in (("runs", COLUMNS, self.runs), ("phases", PHASES, self.phases),
                                    ("counts", COUNTS, self.counts),
                                    ("users", USERS, self.users), ("lengths", LENGTHS, self.lengths)):
            if rows:
                if name not in ("users", "lengths"):
                    rows = sorted(rows, key=lambda row: ORDER.index(row["scene"]))
                with open(os.path.join(self.args.data, name + ".csv"), "w", newline="") as file:
                    writer = csv.DictWriter(file, columns, restval="", lineterminator="\n")
                    writer.writeheader()
                    writer.writerows(rows)


# ---- Strong and weak

def best(args, scene, size, processes, strategy, migrate, steps, models):
    """A run, repeated where wall time counts, with the least wall time and critical path of the repeats."""
    result = None
    for _ in range(args.repeats if processes <= args.cores else args.more_repeats):
        run = Run(args, scene.options(size), processes, strategy, migrate, steps, models[min(processes, 2)])
        if result:
            if run.digest != result.digest:
                raise Failed(f"{scene.name} on {processes}: a repeat has another digest")
            run.seconds = min(run.seconds, result.seconds)
            if result.path < run.path:
                run.path, run.phases = result.path, result.phases
            run.work_imbalance = min(run.work_imbalance, result.work_imbalance)
        result = run
    return result


def number(value, digits=4):
    return "" if value is None else f"{value:.{digits}g}"


def record_phases(results, scene, study, run):
    """Adds the rows of a run, one a phase: processor time of the processes, and what -log_view counted there."""
    for phase, mean, slowest, messages in run.phases:
        row = dict(scene=scene.name, study=study, strategy="serial" if run.processes == 1 else run.strategy,
                   migrate=run.migrate if run.processes > 1 and run.strategy == "spatial" else "",
                   processes=run.processes, particles=run.particles, phase=phase, mean_seconds=number(mean),
                   slowest_seconds=number(slowest), message_seconds=number(messages))
        if event := run.events.get(phase):
            row.update(messages_per_step=number(event.messages / run.steps, 6), bytes_per_step=number(event.bytes / run.steps, 6))
        results.phases.append(row)


def record(args, results, scene, study, run, base):
    """Adds the rows of a run, one a class. base: {class: (seconds, particles)} of the run to which speed-up refers."""
    step = dict(zip(("messages", "bytes", "reductions"), (0, 0, 0)))
    migrating = 0
    if run.events:
        total = run.events["summary"]
        step = dict(messages=total.messages / run.steps, bytes=total.bytes / run.steps / run.particles,
                    reductions=total.reductions / run.steps)
        migrating = run.events["MIGRATE"].count if "MIGRATE" in run.events else 0
    clock = "measured" if run.processes <= args.cores else "oversubscribed"
    line = ""
    for kind, seconds in ((clock, run.seconds), ("critical path", run.path), ("closed form", run.predicted)):
        row = dict(scene=scene.name, dim=scene.dim, basis=scene.basis, update=scene.update, study=study,
                   strategy="serial" if run.processes == 1 else run.strategy,
                   migrate=run.migrate if run.processes > 1 and run.strategy == "spatial" else "",
                   pool_cells=run.patch if run.strategy == "pool" and run.processes > 1 else "",
                   processes=run.processes, particles=run.particles, steps=run.steps,
                   seconds_per_step=number(seconds), imbalance=number(run.imbalance),
                   work_imbalance=number(run.work_imbalance), messages_per_step=number(step["messages"], 6),
                   bytes_per_particle_step=number(step["bytes"]), reductions_per_step=number(step["reductions"]),
                   migrating_steps=migrating, digest=run.digest, **{"class": kind})
        if kind != "oversubscribed":
            # Speed-up is the work done in a second over that of one process, since the sizes of the weak study are rounded.
            speedup = base[kind][0] / seconds * run.particles / base[kind][1]
            efficiency = speedup / run.processes
            row.update(speedup=number(speedup), efficiency=number(efficiency),
                       efficiency_net_of_imbalance=number(efficiency * run.imbalance))
            line += f"  {seconds * 1e3:9.3f} {speedup:6.2f}"
        else:
            line += f"  {seconds * 1e3:9.3f}    -  "
        results.runs.append(row)
    record_phases(results, scene, study, run)
    print(f"  {study:6s} {run.strategy if run.processes > 1 else 'serial':8s}{run.migrate if run.processes > 1 else '':7s}"
          f"{run.processes:3d} {run.particles:8d}{line}  {run.imbalance:6.3f} {run.work_imbalance:6.3f} "
          f"{step['messages']:9.1f} {step['bytes']:8.2f} {step['reductions']:5.2f}", flush=True)
    results.write()


def bases(run):
    return {"measured": (run.seconds, run.particles), "critical path": (run.path, run.particles),
            "closed form": (run.predicted, run.particles)}


def tasks(args, study, patch):
    """(processes, strategy, migrate) of the runs of a study."""
    for p in args.sizes:
        yield p, "spatial", "direct"
        if study == "strong" and p in (2, 8, 32):
            yield p, "spatial", "swarm"
        if p > 1:
            yield p, f"pool:{patch}", "direct"


def compare(results, scene, run, digests):
    """Reports a problem unless all runs of the same cells and steps end with the same bits."""
    expected = digests.setdefault((run.particles, run.steps), run.digest)
    if run.digest != expected:
        results.problem(f"{scene.name}, {run.particles} particles: digest {run.digest} with {run.strategy} "
                        f"{run.migrate} on {run.processes} processes, {expected} before")


def strong_and_weak(args, results, scene):
    models = {p: runs.calibrate(args, scene.name, p, scene.options()) for p in (1, 2)}
    for study, steps in (("strong", args.steps), ("weak", args.steps // 2)):
        base, digests = None, {}
        _, patch = runs.dry_run(args, scene.options(), models[2])
        for p, strategy, migrate in tasks(args, study, patch):
            size = scene.strong if study == "strong" else scene.weak(p)
            try:
                run = best(args, scene, size, p, strategy, migrate, steps, models)
                if study == "weak" and p > 1 and (run.particles, run.steps) not in digests:
                    alone = Run(args, scene.options(size), 1, "spatial", migrate, steps, models[1])
                    compare(results, scene, alone, digests)
                    record(args, results, scene, study, alone, base)
                compare(results, scene, run, digests)
            except Failed as failure:
                results.problem(f"{scene.name} {study}: {failure}")
                if p == 1:
                    break
                continue
            base = base or bases(run)
            record(args, results, scene, study, run, base)
        if study == "strong" and base:
            beyond(args, results, scene, models[2], base["closed form"])


def beyond(args, results, scene, model, base):
    """Adds the closed form, by -dry_run, on more processes than any run has."""
    options = scene.options()
    rows, patch = runs.dry_run(args, options, model)
    dealt, _ = runs.dry_run(args, options, model, "-pool_cells", patch)
    for (p, seconds, imbalance, _), pool in zip(rows, dealt):
        for strategy, t in (("spatial", seconds), ("pool", pool[3])):
            if p <= max(SIZES) or t is None:
                continue
            results.runs.append(dict(
                scene=scene.name, dim=scene.dim, basis=scene.basis, update=scene.update, study="strong",
                strategy=strategy, migrate="direct" if strategy == "spatial" else "", processes=p, particles=base[1],
                pool_cells=patch if strategy == "pool" else "",
                seconds_per_step=number(t), speedup=number(base[0] / t), efficiency=number(base[0] / t / p),
                efficiency_net_of_imbalance=number(base[0] / t / p * (imbalance if strategy == "spatial" else 1)),
                imbalance=number(imbalance if strategy == "spatial" else 1), **{"class": "closed form"}))
    results.write()


def scaling(args, results):
    for scene in runs.SCENES:
        if args.scenes and scene.name not in args.scenes:
            continue
        print(f"\n{scene.name}: {scene.dim}-D {scene.basis} {scene.update}\n  study  strategy       procs particles"
              "   clock ms/step S  critical path S     closed form S  max/mean: particles, work  messages B/particle/step "
              "reductions", flush=True)
        strong_and_weak(args, results, scene)


# ---- Counts

def count(args, results):
    print("\nmessages of a full box, counted by -log_view and by formula")
    for scene in runs.SCENES:
        if not scene.name.startswith("box") or args.scenes and scene.name not in args.scenes:
            continue
        for processes in args.sizes[1:]:
            try:
                rows = counts.check(args, scene, processes)
            except Failed as failure:
                results.problem(f"counts: {failure}")
                continue
            results.counts += rows
            for row in rows:
                text = (f"{row['scene']:6s} {row['strategy']:8s}{row['grid'] if row['strategy'] != 'pool' else '':8s} "
                        f"{row['processes']:3d}  {row['quantity']:28s}{row['counted']:>14s}{row['formula']:>14s}")
                print(f"  {text}", flush=True)
                if row["equal"] == "no":
                    results.problem(f"counts differ: {text}")
    results.write()


# ---- Whole runs

def timed(args):
    """The scenes of options/ that a calibration times: those whose steps are explicit."""
    for path in sorted(glob.glob(os.path.join(runs.ROOT, "options", args.validated + ".opts"))):
        with open(path) as file:
            if "-method_time" not in file.read():
                yield path


def users(args, results):
    """Compares predicted with measured steps of whole runs, started one by one after one calibration of each scene: what a user sees."""
    print("\nwhole runs, one by one\n  scene       processes    ms/step  predicted  ratio")
    for path in timed(args):
        name = os.path.basename(path)[:-5]
        try:
            model = runs.calibrate(args, "users-" + name, 2, ["-options_file", path, "-output_format", "none"])
            for p in (1, 2):
                found = []
                for _ in range(args.repeats):
                    words = ["-options_file", path, "-model_file", model, "-parallel_migrate", "direct", "-report_phases"]
                    text = runs.start(args, p, *words, "-output_format", "none", "-output_dir", runs.BUILD)
                    found.append(tuple(map(float, re.search(r"^  all +\S+ +\S+ +\S+ +(\S+) +(\S+) +\S+$", text, re.M).groups())))
                measured, predicted = map(min, zip(*found))
                results.users.append(dict(scene=name, processes=p, repeats=args.repeats, measured=measured, predicted=predicted))
                print(f"  {name:12s}{p:9d}  {1e3 * measured:9.4f}  {1e3 * predicted:9.4f}  {predicted / measured:5.2f}", flush=True)
        except Failed as failure:
            results.problem(f"users: {name}: {failure}")
    results.write()


def lengths(args, results):
    """Compares runs as long as those of the strong study with runs ten times as long, on 1 and 2 processes, in turns."""
    print("\nruns of the strong study, and ten times as long\n  scene       processes steps    ms/step")
    for scene in runs.SCENES:
        found = {}
        try:
            for _ in range(args.repeats):
                for steps in (args.steps, 10 * args.steps):
                    for p in (1, 2):
                        run = Run(args, scene.options(), p, "spatial", "direct", steps, None, count=False, path=False)
                        found.setdefault((p, run.steps), []).append(run.seconds)
        except Failed as failure:
            results.problem(f"lengths: {scene.name}: {failure}")
        for (p, steps), seconds in found.items():
            results.lengths.append(dict(scene=scene.name, particles=run.particles, processes=p, steps=steps, repeats=len(seconds),
                                        seconds_per_step=number(min(seconds))))
            print(f"  {scene.name:12s}{p:9d} {steps:5d}  {1e3 * min(seconds):9.4f}", flush=True)
    results.write()


README = """# Data of the scaling studies

Written by `make scaling` ({when}; {machine}; load average {load} at the start, {minutes:.0f} minutes). Times are s.

**runs.csv**, a row a run and class:

| column | meaning |
| --- | --- |
| scene, dim, basis, update | tools/scenes.py has the scenes, scenes.csv what they were |
| study | `strong`: the same scene on all numbers of processes; `weak`: about 16,384 particles a process |
| strategy, migrate | `serial` (one process), `spatial` with its way of migration; `pool` |
| pool_cells | edge of the pool's patches |
| processes, particles, steps | weak with `serial`: the scene of a larger number of processes, for its digest |
| class | `measured`: wall time, a core for each process; `oversubscribed`: wall time, more processes than cores, no speed-up; `critical path`: slowest processor time in each phase and step, messages by the model; `closed form`: what the program predicts by a calibration of that day (the report has its own closed forms, of ../constants.csv) |
| seconds_per_step | least of the repeats |
| speedup | particles a second over those of one process, of the same class |
| efficiency, efficiency_net_of_imbalance | speedup / processes; times imbalance |
| imbalance | largest over mean number of particles of a process at the start |
| work_imbalance | slowest over mean processor time; in the pool the master's |
| messages_per_step, bytes_per_particle_step | sent in all, by -log_view; in the pool by and to the master |
| reductions_per_step | by -log_view |
| migrating_steps | steps in which some particle changed process |
| digest | of the state at the end: equal for all runs of a scene, number of particles and steps |

**phases.csv**, a row a run and phase, of the runs with which runs.csv has a critical path: s a step

| column | meaning |
| --- | --- |
| mean_seconds, slowest_seconds | processor time of the processes: the mean, and the largest of each step |
| message_seconds | messages on the critical path, by the model |
| messages_per_step, bytes_per_step | sent in this phase, all processes together, by -log_view; in the pool by and to the master |

**counts.csv**: messages and bytes a step of a full box at rest in its cells, counted and by formula (tools/scaling/counts.py);
bytes are counted to six digits.

**users.csv**: of whole runs of the scenes of options/ with explicit steps, started one by one after one calibration of each, the step measured and the step
predicted, the least of the repeats. **lengths.csv**: steps of runs as
long as those of the strong study and ten times as long, on 1 and 2 processes, the least of the repeats. **scenes.csv**, **machine.csv**:
what the scenes were, and what ran them.
"""


def main():
    parts = {"scaling": scaling, "counts": count, "users": users, "lengths": lengths}
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--pebble", default="./pebble")
    p.add_argument("--calibrator", default=os.path.join(runs.ROOT, "build", "mpicc", "calibrate"), help="program of make calibrate")
    p.add_argument("--mpiexec", default="mpiexec")
    p.add_argument("--full", action="store_true", help="100 steps, 5 repeats")
    p.add_argument("--only", help=f"of {', '.join(parts)}, separated by commas")
    p.add_argument("--scenes", help="scenes of the studies, separated by commas")
    p.add_argument("--sizes", help="numbers of processes, separated by commas, 1 first")
    p.add_argument("--cores", type=int, default=os.cpu_count(), help="cores that are free (tools/launch.py)")
    p.add_argument("--repeats", type=int, default=3, help="repeats of runs in which every process has a core")
    p.add_argument("--keep", action="store_true", help="calibrations that build/scaling has are not made again")
    p.add_argument("--data", default=os.path.join(runs.ROOT, "docs", "data", "scaling"), help="folder of the tables")
    p.add_argument("--figures", default=os.path.join(runs.ROOT, "docs"))
    p.add_argument("--plot", action="store_true", help="only draw the figures from the tables")
    p.add_argument("--validated", default="*", help="scenes of options/ for users, as the shell names files")
    args = p.parse_args()
    args.steps, args.more_repeats = 40, 1
    if args.full:
        args.steps, args.repeats, args.more_repeats = 100, 5, 3
    args.sizes = tuple(map(int, args.sizes.split(","))) if args.sizes else SIZES
    args.scenes = args.scenes.split(",") if args.scenes else []
    whole = not args.only and not args.scenes
    args.only = args.only.split(",") if args.only else list(parts)
    if set(args.only) - set(parts) or set(args.scenes) - {scene.name for scene in runs.SCENES}:
        p.error("no such part or scene")

    results, start, load = Results(args), datetime.datetime.now(), os.getloadavg()[0]
    if not args.plot:
        if load > 0.5:
            print(f"The load average is {load:.1f}: other work is running, times will be too long")
        for name in args.only:
            parts[name](args, results)
        minutes = (datetime.datetime.now() - start).total_seconds() / 60
        facts = scenes.machine(args.pebble, args.mpiexec)
        if "scaling" in args.only and not args.scenes:
            scenes.record(args.data, facts)
        readme = os.path.join(args.data, "README.md")
        if whole or not os.path.exists(readme):
            with open(readme, "w") as file:
                file.write(README.format(when=f"{start:%Y-%m-%d %H:%M}", machine=f"{facts['processor']}, {args.cores} cores",
                                         load=f"{load:.1f}", minutes=minutes))
        else:
            print(f"a part of the tables is new: {os.path.relpath(readme)} wants a word about it")
        print(f"\n{minutes:.1f} minutes, load average {load:.1f} at the start")
    try:
        import plots
        plots.draw(args.data, args.figures)
    except ImportError as missing:
        print(f"no figures: {missing}")
    for problem in results.problems:
        print(f"FAILED {problem}")
    return bool(results.problems)


if __name__ == "__main__":
    sys.exit(main())
