#!/usr/bin/env python3
"""Runs Pebble on simulated clusters, in SimGrid's SMPI: `make simulate`. docs/simulate.md says what that shows.

The program is the real one: all points are moved and all messages sent, by processes that take turns on one core. Only
time is simulated: that of messages by SimGrid's model of the network in a platform file (*.xml), that of computation in
one of two ways:

  injected   declared where it is done (MPMSimulateWork), by the costs of costs.csv: the same to the last digit each time
  emulated   measured while it runs: no assumption, but noise and the caches of one core that all processes share

    simulate.py                the curves to 32 processes, and to 128 where they go on: docs/data/simulated/*.csv
    simulate.py --full         to 1024 processes
    simulate.py --calibrate    measures costs.csv anew on this machine first
    simulate.py --validate     only: this machine simulated, beside real runs on one and two of its cores
    simulate.py --mode injected    these curves only
    simulate.py --only weak    one of costs strong weak large validate
"""
import argparse
import concurrent.futures
import csv
import functools
import math
import os
import re
import subprocess
import sys
import time
import typing
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "build/simulate/runs"
DATA = ROOT / "docs/data/simulated"
COSTS = DATA / "costs.csv"

# ---- Settings of SMPI, each with its reason
SETTINGS = [
    "smpi/host-speed:1Gf",  # of the core that emulates; the platforms' hosts have the same, so seconds stay seconds
    "smpi/privatization:mmap",  # each process has its own globals, swapped by remapping the program's data
    "smpi/coll-selector:ompi",  # collectives by the algorithms that Open MPI would choose
    "smpi/async-small-thresh:65536",  # messages up to 64 KiB leave without waiting for the receiver, as in Open MPI
    "smpi/iprobe:5e-7",  # cost of a poll; the default, 100 us, is a step's worth of work
    "smpi/test:5e-7",  # the same for MPI_Test
    "smpi/grow-injected-times:no",  # no dearer each time: the default is for programs that do nothing but poll
    "smpi/cpu-threshold:1e-6",  # emulated: shorter bursts are free, or the simulator's own cost would count
]
# SMPI's own factors describe a cluster with Gigabit Ethernet: replaced by those of the platform. lat, bw: message size and
# factor; os, ois, or: what a send and a receive cost the processor, s (before a size; per message; per byte).
NETWORK = {
    "cluster": ["smpi/lat-factor:0:1.0", "smpi/bw-factor:0:1.0", "smpi/os:0:3e-7:0", "smpi/ois:0:3e-7:0", "smpi/or:0:3e-7:0"],
    "shared": ["smpi/lat-factor:0:0.6;1024:0.5;4096:3.3;16384:4.1", "smpi/bw-factor:0:0.35;1024:0.265;4096:1.0;16384:1.25",
               "smpi/os:0:2e-8:0", "smpi/ois:0:2e-8:0", "smpi/or:0:2e-8:0"],
}
NETWORK["fattree"] = NETWORK["cluster"]

# Costs that one process alone does not show: copying into messages and out of them, ns a byte; what the pool's worker has
# to do for each point that moved, and both sides for each chunk, ns. Measured once, with clocks around the code, on the
# machine of costs.csv.
FIXED = {"PACK": 0.2, "ASSEMBLE": 0.11, "UNPACK": 0.075, "ANSWER": 0.15, "RENUMBER": 7, "CHUNK": 500}

BOX = """-scene_title "filled box"
-dim {dim}
-grid_lower {lower}
-grid_upper {cells}
-grid_cells {cells}
{walls}
-materials rubber
-material_rubber_model neohookean
-material_rubber_rho 1000
-material_rubber_E 1e6
-material_rubber_nu 0.3
-bodies box
-body_box_shape box
-body_box_lower {lower}
-body_box_upper {cells}
-body_box_material rubber
-body_box_velocity {velocity}
-method_update usl
-time_end 1e9
"""


def box(dim, basis, cells):
    """A box full of rubber that swings, at up to a tenth of its speed of sound: cells of 1 m, 2 points an axis each."""
    axes = "xyz"[:dim]
    text = BOX.format(dim=dim, lower=",".join("0" * dim), cells=",".join(map(str, cells)),
                      walls="\n".join(f"-bc_{a}{s}_type slip" for a in axes for s in ("min", "max")),
                      velocity=",".join(f"4*sin(pi*{a}/{n})" for a, n in zip(axes, cells)))
    return text + f"-method_basis {basis}\n", math.prod(cells) * 2 ** dim


def scene_file(name, more):
    """A scene of options/, finer."""
    return (ROOT / f"options/{name}.opts").read_text() + "\n" + more


def near_cube(dim, parts):
    """parts (a power of 2) as a product of dim factors that differ little."""
    p = [1] * dim
    while math.prod(p) < parts:
        p[p.index(min(p))] *= 2
    return p


def box2d(size):
    return box(2, "linear", size)[0]


def box3d(size):
    return box(3, "bspline2", size)[0]


# In these all points of a body would cross cells in the same steps, or none for long: they get more motion.
def disks(n):
    spin = "\n".join(f"-body_disk{k}_velocity {v}-0.3*(y-{c}),{v}+0.3*(x-{c})" for k, v, c in ((1, 0.1, 0.2), (2, -0.1, 0.8)))
    return scene_file("disks", f"-grid_cells {n},{n}\n-body_disk1_ppc 2,2\n-body_disk2_ppc 2,2\n{spin}\n")


def dambreak(n):
    return scene_file("dambreak", f"-grid_cells {5 * n},{9 * n // 4}\n-body_column_velocity 4*x,-4*y\n")


# name: maker, size for the strong curve, size with about 16,000 points (calibration; validation: and four times that)
SCENES = {
    "box2d": (box2d, (256, 256), (64, 64)),
    "box3d": (box3d, (32, 32, 32), (16, 16, 8)),
    "disks": (disks, 512, 128),
    "dambreak": (dambreak, 160, 48),
}
WEAK = {"box2d": (64, 64), "box3d": (16, 16, 8)}  # cells of a process: 16,384 points


def weak_size(name, ranks):
    return tuple(c * p for c, p in zip(WEAK[name], near_cube(len(WEAK[name]), ranks)))


# ---- Runs
def write_scene(name, size, steps):
    tag = f"{name}-{size if isinstance(size, int) else 'x'.join(map(str, size))}-{steps}"
    path = WORK / f"{tag}.opts"
    WORK.mkdir(parents=True, exist_ok=True)
    path.write_text(SCENES[name][0](size) + f"-time_max_steps {steps}\n-history_every 1e9\n-report_limits 0\n")
    return path


def parse(text):
    """What a run printed."""
    out = {"phases": {}}
    for line in text.splitlines():
        if m := re.match(r"scene .*  (\d+) particles", line):
            out["particles"] = int(m[1])
        elif m := re.match(r"parallel .*, \w+ ([\dx]+), particles max/mean ([\d.]+)", line):
            out["cut"], out["imbalance"] = m[1], float(m[2])
        elif m := re.match(r"done +(\d+) steps", line):
            out["steps"] = int(m[1])
        elif m := re.match(r"  (\w+) +[\d.]+ +[\d.]+ +[\d.]+ +(\S+) ", line):
            out["phases"][m[1]] = float(m[2])
        elif m := re.match(r"simulated +(\S+) s a step", line):
            out["seconds"] = float(m[1])
        elif m := re.match(r"digest (\w+)", line):
            out["digest"] = m[1]
    if "digest" not in out:
        raise RuntimeError(text[-2000:])
    out.setdefault("imbalance", 1.0)
    out.setdefault("cut", "")
    out["seconds"] = out.get("seconds", out["phases"]["all"])  # of a real run: to three digits
    out["phases"] = {k: 1e9 * v / out["particles"] for k, v in out["phases"].items()}  # ns a point
    return out


def options(strategy, migrate):
    # The scenes may write snapshots, and the simulator's build cannot.
    return ["-output_format", "none", "-output_dir", str(WORK), "-parallel_strategy", strategy, "-parallel_migrate", migrate]


def start(command, **more):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=WORK, **more)


def finish(process):
    text = process.communicate()[0]
    if process.returncode:
        raise RuntimeError(text[-2000:])
    return parse(text)


def real(args, path, ranks=1, strategy="spatial", migrate="direct", copies=1):
    """Runs on this machine; copies at once, so that all cores are busy."""
    command = [args.pebble, "-options_file", path] + options(strategy, migrate)
    if ranks > 1:
        command = [args.mpiexec, "-n", str(ranks)] + command
    return [finish(p) for p in [start(command) for _ in range(copies)]]


@functools.cache
def hosts(ranks):
    """The file that says where processes run: it must name no more nodes than are used."""
    path = WORK / f"hosts-{ranks}"
    path.write_text("".join(f"n{k}\n" for k in range(ranks)))
    return path


def simulated(args, path, hosts, ranks, mode, strategy, migrate, platform, costs):
    settings = SETTINGS + NETWORK[platform] + (["smpi/simulate-computation:no"] if mode == "injected" else [])
    # smpirun passes arguments through a shell's eyes, so all that has blanks or quotes stands in the file.
    command = ["nice", "-n", "19"] if mode == "injected" else []
    command += ["smpirun", "-np", str(ranks), "-platform", HERE / f"{platform}.xml", "-hostfile", hosts, "--log=root.thres:error"]
    command += [f"--cfg={s}" for s in settings] + [args.simulator, "-options_file", path] + options(strategy, migrate)
    environment = {k: v for k, v in os.environ.items() if k != "PEBBLE_COSTS"}
    if mode == "injected":
        environment["PEBBLE_COSTS"] = ",".join(f"{k}={v:g}" for k, v in costs.items())
    began = time.time()
    best = None
    for _ in range(1 if mode == "injected" or strategy == "pool" else args.repeat):  # emulated: the least disturbed
        got = finish(start(command, env=environment))
        if not best or got["seconds"] < best["seconds"]:
            best = got
    best["wall"] = time.time() - began
    return best


@functools.cache
def true_digest(args_pebble, path):
    """The digest of the real run on one process."""
    return finish(start([args_pebble, "-options_file", path] + options("spatial", "direct")))["digest"]


# ---- Costs
def calibrate(args):
    """Costs of phases, ns a point, with all cores busy; what DMSwarmMigrate costs more than direct messages. Others may use
    the machine too: the least of many short runs."""
    def least(path, **how):
        runs = [r for _ in range(args.calibrations) for r in real(args, path, **how)]
        return runs[0]["particles"], {k: min(r["phases"].get(k, math.inf) for r in runs) for k in runs[0]["phases"]}

    rows = []
    for name, (_, _, size) in SCENES.items():
        path = write_scene(name, size, 40)
        n, cost = least(path, copies=os.cpu_count())
        direct, swarm = (least(path, ranks=2, migrate=m)[1].get("MIGRATE", 0) for m in ("direct", "swarm"))
        cost["SWARM"] = max(0, swarm - direct) * n
        cost = {k: v for k, v in cost.items() if k not in ("REDUCE", "MIGRATE", "SETTLE", "other", "all")}
        cost = {k: v for k, v in cost.items() if v < math.inf}
        print(f"  {name:10} {n} points: " + ", ".join(f"{k} {v:.4g}" for k, v in cost.items()), flush=True)
        rows += [{"scene": name, "particles": n, "name": k, "ns": f"{v:.4g}"} for k, v in cost.items()]
    call = min(float(r["ns"]) for r in rows if r["name"] == "SWARM")  # the same in all scenes, but for the noise
    write(COSTS, [{**r, "ns": f"{call:.4g}"} if r["name"] == "SWARM" else r for r in rows])


def read_costs():
    costs = {}
    with open(COSTS) as f:
        for row in csv.DictReader(f):
            costs.setdefault(row["scene"], dict(FIXED))[row["name"]] = float(row["ns"])
    return costs


# ---- Tables
def write(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as f:
        out = csv.DictWriter(f, rows[0], lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


class Run(typing.NamedTuple):
    """A row of a plan."""
    scene: str
    size: object
    steps: int
    strategy: str
    migrate: str
    mode: str
    platform: str
    ranks: int


def table(args, path, plan, costs):
    """Makes the runs of a plan and writes their table. The first run of a scene, mode and platform is the base of the
    others' efficiency: its time a particle, over theirs times processes."""
    plan, rows, base, wrong = list(plan), [], {}, 0
    if args.mode:  # the rows of the other mode stay as they are
        plan = [run for run in plan if run.mode == args.mode]
        if path.exists():
            with open(path) as f:
                rows = [row for row in csv.DictReader(f) if row["mode"] != args.mode]
    started = []
    executor = concurrent.futures.ThreadPoolExecutor(os.cpu_count())
    for run in plan:  # injected runs may share the machine; emulated ones wait until they are alone
        call = functools.partial(simulated, args, write_scene(run.scene, run.size, run.steps), hosts(run.ranks), run.ranks,
                                 run.mode, run.strategy, run.migrate, run.platform, costs[run.scene])
        started.append(executor.submit(call).result if run.mode == "injected" else call)
    for run, result in zip(plan, started):
        if run.mode == "emulated":
            executor.shutdown()
        label = f"  {run.scene:9} {run.strategy:8} {run.migrate:7} {run.mode:9} {run.platform:8} {run.ranks:5}"
        try:
            r = result()
        except RuntimeError as fault:
            print(f"{label}  failed: {str(fault).strip().splitlines()[-1][:150]}", flush=True)
            wrong += 1
            continue
        work = r["seconds"] * run.ranks / r["particles"]
        efficiency = base.setdefault((run.scene, run.mode, run.platform), work) / work
        same = r["digest"] == true_digest(args.pebble, write_scene(run.scene, run.size, run.steps))
        wrong += not same
        rows.append({"scene": run.scene, "strategy": run.strategy, "migrate": run.migrate, "mode": run.mode,
                     "platform": run.platform, "ranks": run.ranks, "particles": r["particles"], "steps": r["steps"],
                     "seconds_per_step": f"{r['seconds']:.9g}", "efficiency": f"{efficiency:.4f}",
                     "imbalance": f"{r['imbalance']:.3f}", "cut": r["cut"], "digest": r["digest"],
                     "same_as_real": "yes" if same else "no"})
        print(f"{label}  {1e6 * r['seconds']:10.1f} us/step  efficiency {efficiency:.3f}  max/mean {r['imbalance']:.3f}  "
              f"{'same bits' if same else 'OTHER BITS'}  ({r['wall']:.1f} s)", flush=True)
        write(path, rows)
    executor.shutdown()
    return wrong


def curves(ranks, scenes, size, steps):
    """Main curve, then the swarm's migration, the pool, and both measured: all start from the run on one process."""
    for name in scenes:
        for mode in ("injected", "emulated"):
            for strategy, migrate in (("spatial", "direct"), ("spatial", "swarm"), ("pool", "direct")):
                if mode == "emulated" and migrate == "swarm":
                    continue
                for p in ranks:
                    if p > 1 or (strategy, migrate) == ("spatial", "direct"):
                        # The pool's many messages take the simulator long, and its steps are all alike.
                        yield Run(name, size(name, p), steps if strategy == "spatial" else steps // 4, strategy, migrate, mode, "cluster", p)


def strong():
    yield from curves((1, 2, 4, 8, 16, 32), SCENES, lambda name, p: SCENES[name][1], 40)


def weak():
    yield from curves((1, 2, 4, 8, 16, 32), WEAK, weak_size, 40)


def large_weak(ranks):
    """Beyond 32 processes. Their set-up takes the simulator minutes from 256 on, so there only what matters most."""
    for name in WEAK:
        for p in (1, *ranks):
            yield Run(name, weak_size(name, p), 20, "spatial", "direct", "injected", "cluster", p)
    for platform, migrate in (("fattree", "direct"), ("cluster", "swarm")):
        for p in (1, *(p for p in ranks if p <= 256)):
            yield Run("box2d", weak_size("box2d", p), 20, "spatial", migrate, "injected", platform, p)


def large_strong(ranks):
    """About a million points."""
    for name, size in (("box2d", (512, 512)), ("disks", 1024)):
        for p in (1, *(p for p in ranks if p <= (1024 if name == "box2d" else 256))):
            yield Run(name, size, 20, "spatial", "direct", "injected", "cluster", p)


def validate(args, costs):
    """This machine simulated, beside real runs on one and two of its cores."""
    rows, wrong = [], 0
    for name, (_, big, small) in SCENES.items():
        for size in (small, big):
            path = write_scene(name, size, 40)
            for ranks, strategy, migrate in ((1, "spatial", "direct"), (2, "spatial", "direct"), (2, "spatial", "swarm"), (2, "pool", "direct")):
                runs = [real(args, path, ranks, strategy, migrate)[0] for _ in range(args.calibrations if size == small else 5)]
                measured = min(r["seconds"] for r in runs)
                row = {"scene": name, "particles": runs[0]["particles"], "ranks": ranks, "strategy": strategy, "migrate": migrate,
                       "real": f"{measured:.6g}"}
                for mode in ("injected", "emulated"):
                    r = simulated(args, path, hosts(ranks), ranks, mode, strategy, migrate, "shared", costs[name])
                    wrong += r["digest"] != runs[0]["digest"]
                    row[mode], row[f"{mode}_over_real"] = f"{r['seconds']:.6g}", f"{r['seconds'] / measured:.3f}"
                row["same_digest"] = "yes" if r["digest"] == runs[0]["digest"] else "no"
                rows.append(row)
                print(f"  {name:9} {row['particles']:7} {strategy:8} {migrate:7} {ranks}  real {1e6 * measured:9.1f} us/step"
                      f"  injected {row['injected_over_real']}  emulated {row['emulated_over_real']} of it", flush=True)
                write(DATA / "validate.csv", rows)
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=ROOT / "pebble", type=lambda p: Path(p).resolve(), help="the program")
    parser.add_argument("--simulator", default=ROOT / "build/simulate/pebble", type=lambda p: Path(p).resolve(), help="built with smpicc")
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--calibrate", action="store_true")
    parser.add_argument("--validate", action="store_true")
    parser.add_argument("--only", choices=["costs", "strong", "weak", "large", "validate"])
    parser.add_argument("--mode", choices=["injected", "emulated"], help="the curves of this mode only")
    parser.add_argument("--calibrations", type=int, default=15, help="runs of each kind, of which the fastest counts")
    parser.add_argument("--repeat", type=int, default=2, help="emulated runs, of which the fastest counts")
    args = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    if args.calibrate or not COSTS.exists():
        print("costs, ns a point (SWARM: a call), measured on this machine")
        calibrate(args)
    costs, wrong = read_costs(), 0
    only = "validate" if args.validate else args.only
    ranks = (64, 128, 256, 512, 1024) if args.full else (64, 128)
    for what, run in (("strong", lambda: table(args, DATA / "strong.csv", strong(), costs)),
                      ("weak", lambda: table(args, DATA / "weak.csv", weak(), costs)),
                      ("large", lambda: table(args, DATA / "weak-large.csv", large_weak(ranks), costs) +
                       table(args, DATA / "strong-large.csv", large_strong(ranks), costs)),
                      ("validate", lambda: validate(args, costs))):
        if only in (None, what):
            print(what)
            wrong += run()
    print(f"tables in {DATA.relative_to(ROOT)}; {wrong} runs failed or had other bits than the real program")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
