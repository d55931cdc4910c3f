#!/usr/bin/env python3
"""Runs Pebble on simulated clusters, in SimGrid's SMPI: `make simulate`. docs/cluster.md says what that shows.

The program is the real one: all particles are moved and all messages sent, by processes that take turns on one core. Only
time is simulated: that of messages by SimGrid's model of the network in a platform file (*.xml), that of computation in
one of two ways:

  injected   it is declared where the work is done (MPMSimulateWork), by the costs of costs.csv: the same to the last digit each time
  emulated   it is measured while the work runs: this assumes nothing, but has disturbances and the caches of one core that all share

    simulate.py                makes all curves, to 32 processes, and to 1024 where they go on: docs/data/simulated/*.csv
    simulate.py --calibrate    measures costs.csv anew on this machine first
    simulate.py --validate     only simulates this machine, and compares with real runs on one and two of its cores

These options choose a part; all other rows of the tables stay as they are:

    --only weak,weak-large     of costs strong weak strong-large weak-large validate
    --scenes box2d             (with --calibrate: the costs of these alone)
    --mode injected            or emulated
    --strategy spatial         or pool
    --migrate direct           or swarm
    --sizes 512,1024           numbers of processes (one process is always made anew)
    --transport tcp            or shared: of the validation, which has both modes, and one and two processes
"""
import argparse
import concurrent.futures
import contextlib
import csv
import functools
import math
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import typing
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import launch  # noqa: E402 (after the path)
import scenes  # noqa: E402
from scenes import SCENES  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "build/simulate/runs"
DATA = ROOT / "docs/data/simulated"
COSTS = DATA / "costs.csv"

# ---- Settings of SMPI, each with its reason
SETTINGS = [
    "smpi/host-speed:1Gf",  # speed of the core that emulates; the platforms' hosts have the same, so seconds stay seconds
    "smpi/privatization:mmap",  # each process has its own globals, swapped by remapping the program's data
    "smpi/coll-selector:ompi",  # collectives by the algorithms that Open MPI would choose
    "smpi/bcast:binomial_tree",  # Open MPI's broadcast would first find the cores that share memory, by as many messages as the square of the processes
    "smpi/async-small-thresh:65536",  # messages up to 64 KiB leave without waiting for the receiver, as in Open MPI
    "smpi/iprobe:5e-7",  # s, cost of a poll; the default, 100 us, is as long as a whole step
    "smpi/test:5e-7",  # the same for MPI_Test
    "smpi/grow-injected-times:no",  # a poll costs the same each time; the default raises it, for programs that do nothing but poll
    "smpi/cpu-threshold:1e-6",  # s; emulated: a shorter piece of work takes no time, or else the simulator's own work would count
]
# SMPI's own factors describe a cluster with Gigabit Ethernet; those of the platform replace them. lat, bw: message size and
# factor; os, ois, or: what a send and a receive cost the processor, in s (before a size; per message; per byte).
NETWORK = {"cluster": ["smpi/lat-factor:0:1.0", "smpi/bw-factor:0:1.0", "smpi/os:0:3e-7:0", "smpi/ois:0:3e-7:0", "smpi/or:0:3e-7:0"]}
NETWORK["fattree"] = NETWORK["cluster"]

# How two processes of this machine send messages: through memory that they share, or by TCP through the loopback device.
TRANSPORTS = {"shared": [], "tcp": ["--mca", "pml", "ob1", "--mca", "btl", "tcp,self", "--mca", "btl_tcp_if_include", "lo"]}
PLATFORM = """<?xml version='1.0'?>
<!DOCTYPE platform SYSTEM "https://simgrid.org/simgrid.dtd">
<platform version="4.1">
  <zone id="world" routing="Full">
    <cluster id="{name}" prefix="n" suffix="" radical="0-63" speed="1Gf" bw="{bandwidth:.6g}Bps" lat="{latency:.6g}s"
             loopback_bw="{bandwidth:.6g}Bps" loopback_lat="{latency:.6g}s" sharing_policy="SPLITDUPLEX"/>
  </zone>
</platform>
"""

# Costs that a run on one process does not show: copying into messages and out of them, ns a byte; what the pool's worker has
# to do for each particle that moved, and what both sides have to do for each job (JOB), ns. They were measured once, with
# clocks around the code, on the machine of costs.csv.
FIXED = {"PACK": 0.2, "ASSEMBLE": 0.11, "UNPACK": 0.075, "ANSWER": 0.15, "RENUMBER": 7, "JOB": 500}

# Scenes of weak scaling, and of strong scaling with about a million particles, which have tiles for 1024 processes and more
WEAK, LARGE = ("box2d", "box3d"), ("box2d", "box3d", "disks")


# ---- Runs
def weak_size(name, ranks):
    return SCENES[name].weak(ranks)


def write_scene(name, size, steps):
    folder = WORK / str(steps)  # one file for each number of steps
    return Path(scenes.write(folder, name, size, f"-time_max_steps {steps}\n-history_every 1e9\n-report_limits 0\n"))


def parse(text):
    """The values that a run printed."""
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
    out["seconds"] = out.get("seconds", out["phases"]["all"])  # a real run prints three digits
    out["phases"] = {k: 1e9 * v / out["particles"] for k, v in out["phases"].items()}  # ns a particle
    return out


@functools.cache
def patch(pebble, path):
    """The cells of the pool's patches that the model finds best on 8 processes, with messages of a cluster."""
    words = ["-dry_run", "-report_processes", "-output_format", "none", "-output_dir", str(WORK / "none")]  # no calibration is there
    said = launch.run([pebble, "-options_file", path, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True).stdout
    found = re.search(r"best patches on 8 processes (\d+)", said)
    if not found:
        raise RuntimeError(said[-2000:])
    return found[1]


def options(args, path, strategy, migrate):
    # The scenes may write snapshots, and the simulator's build cannot.
    pool = ["-pool_cells", patch(args.pebble, path)] if strategy == "pool" else []
    return ["-report_phases", "-output_format", "none", "-parallel_strategy", strategy, "-parallel_migrate", migrate, *pool]


def run(command, env=None):
    with tempfile.TemporaryDirectory(dir=WORK) as folder:  # several runs of a scene at once write files of the same names
        command = [*command, "-output_dir", folder]
        done = launch.run(command, env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=WORK)
    if done.returncode:
        raise RuntimeError(done.stdout[-2000:])
    return parse(done.stdout)


def real(args, path, ranks=1, strategy="spatial", migrate="direct", copies=1, transport="shared"):
    """Results of runs on this machine, of which `copies` run at once so that all cores are busy."""
    command = [args.pebble, "-options_file", path] + options(args, path, strategy, migrate)
    if ranks > 1:
        command = [args.mpiexec, *TRANSPORTS[transport], "-n", str(ranks)] + command
    environment = launch.environment(ranks, os.cpu_count()) if ranks > 1 else None
    with concurrent.futures.ThreadPoolExecutor(copies) as pool:
        return list(pool.map(lambda _: run(command, environment), range(copies)))


@functools.cache
def hosts(ranks):
    """The file that says where processes run. It must name no more nodes than are used."""
    path = WORK / f"hosts-{ranks}"
    path.write_text("".join(f"n{k}\n" for k in range(ranks)))
    return path


def platform_file(name):
    return (WORK if name in TRANSPORTS else HERE) / f"{name}.xml"


def run_calibrator(args, path, file, transport="shared"):
    """Calibrates a scene on two processes into a file."""
    command = [args.mpiexec, *TRANSPORTS[transport], "-n", "2", args.calibrator, "-options_file", path, "-model_file", file, "-output_dir", WORK]
    done = launch.run(command, launch.environment(2, os.cpu_count()), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"no calibration over {transport}: {(done.stderr + done.stdout)[-500:]}")


def measure(args, transport):
    """Makes the platform of two processes of this machine from what a calibration finds there: the time of a short message, the
    part of it for which the processors at its ends are busy, and the time of a byte. The least of several calibrations counts."""
    file, found = WORK / f"{transport}.model", []
    for _ in range(args.calibrations // 5 + 1):
        run_calibrator(args, write_scene("box2d", SCENES["box2d"].small, 40), file, transport)
        found.append({k: float(v) for k, v in re.findall(r"^(message|post|wire) (\S+)$", file.read_text(), re.M)})
    found = [f for f in found if f["wire"] > 0]  # the other calibrations were disturbed
    if not found:
        raise RuntimeError(f"no calibration over {transport} found what a byte takes")
    message, post = min((f["message"], f["post"]) for f in found)
    wire = min(f["wire"] for f in found)
    post = min(post, 0.8 * message)  # other work may have disturbed it
    platform_file(transport).write_text(PLATFORM.format(name=transport, bandwidth=1 / wire, latency=(message - post) / 2))  # two links
    NETWORK[transport] = ["smpi/lat-factor:0:1.0", "smpi/bw-factor:0:1.0"]
    NETWORK[transport] += [f"smpi/{k}:0:{post / 2:.3g}:0" for k in ("os", "ois", "or")]
    print(f"  {transport}: a short message {1e6 * message:.3g} us, of it {1e6 * post:.3g} us of processors; {1e-9 / wire:.3g} GB/s")
    row = {"transport": transport, "message": f"{message:.4g}", "post": f"{post:.4g}", "wire": f"{wire:.4g}"}
    path = DATA / "networks.csv"
    write(path, sorted([r for r in read_rows(path) if r["transport"] != transport] + [row], key=lambda r: r["transport"]))


def simulated(args, path, hosts, ranks, mode, strategy, migrate, platform, costs):
    settings = SETTINGS + NETWORK[platform] + (["smpi/simulate-computation:no"] if mode == "injected" else [])
    # smpirun passes arguments through a shell, so all that has blanks or quotes stands in the file.
    command = ["nice", "-n", "19"] if mode == "injected" else []
    command += ["smpirun", "-np", str(ranks), "-platform", platform_file(platform), "-hostfile", hosts, "--log=root.thres:error"]
    command += [f"--cfg={s}" for s in settings] + [args.simulator, "-options_file", path] + options(args, path, strategy, migrate)
    environment = {k: v for k, v in os.environ.items() if k != "PEBBLE_COSTS"}
    if mode == "injected":
        environment["PEBBLE_COSTS"] = ",".join(f"{k}={v:g}" for k, v in costs.items())
    began = time.time()
    best = None
    for _ in range(1 if mode == "injected" or strategy == "pool" else args.repeat):  # emulated: the least disturbed
        got = run(command, environment)
        if not best or got["seconds"] < best["seconds"]:
            best = got
    best["wall"] = time.time() - began
    return best


@functools.cache
def true_digest(args_pebble, path):
    """The digest of the real run on one process."""
    return run([args_pebble, "-options_file", path] + options(None, path, "spatial", "direct"))["digest"]


# ---- Costs
def migration(name):
    """The costs of migration, ns: of a particle that changes process; of a call of DMSwarmMigrate, without its collectives, and in it
    of a particle that is there. They are from calibrations of the filled boxes in as many dimensions, by real runs on two processes."""
    box = "box3d" if name.endswith("3d") else "box2d"
    text = (ROOT / f"docs/data/models/{box}.model").read_text()
    known = dict(re.findall(r"^migration\[(\d\]\.\w+) (\S+)$", text, re.M))
    return {cost: 1e9 * float(known[k]) for cost, k in (("LEAVER", "1].leaver"), ("SWARM", "0].call"), ("SWARM_PARTICLE", "0].particle"))}


def slowest(copies):
    """One result of runs that were made at once: the longest time of each phase, since the copy that began last, or ended first, had
    the memory for itself for a while."""
    phases = {name: max(r["phases"].get(name, 0) for r in copies) for name in copies[0]["phases"]}
    return {**max(copies, key=lambda run: run["seconds"]), "phases": phases}


def in_turns(args, path, ways):
    """The fastest of many short runs of each way, in turns, since other work on the machine slows what runs at the time.
    Each has particles, s a step, digest, and ns a particle of each phase, for which each phase has its own least."""
    best = [None] * len(ways)
    for _ in range(args.calibrations):
        for k, way in enumerate(ways):
            r = slowest(real(args, path, **way))
            old = best[k] or r
            phases = {name: min(ns, old["phases"].get(name, math.inf)) for name, ns in r["phases"].items()}
            best[k] = {**min(old, r, key=lambda run: run["seconds"]), "phases": phases}
    return best


ALONE = {"copies": 1}  # one process, which has the memory of the machine for itself
BUSY = {"copies": os.cpu_count()}  # one process on each core, each a run of its own
BUSY_SECONDS = 0.3  # of a run for the cost of sharing a memory: much more than two programs need to start one after the other
MEMORY = DATA / "memory.csv"


def memory_factors(alone, busy):
    """How many times as long each phase takes when all cores are busy; less than 1 is the noise of the clock."""
    return {name: max(1.0, busy[name] / ns) for name, ns in alone.items() if ns > 0 and name in busy}


def sharing(costs, factors, processes, copies):
    """The costs of a run in which so many processes share a memory; the factors are those of `copies` processes. Each further
    process adds as much. Costs without a factor were measured on two processes at once, and stay."""
    share = min(1.0, (processes - 1) / (copies - 1)) if copies > 1 else 0.0
    return {name: ns * (1 + share * (factors.get(name, 1.0) - 1)) for name, ns in costs.items()}


def measure_memory(args, name, size, seconds):
    """The factors of a scene whose step takes so many seconds, by long runs on one process and on all cores in turns; they go to
    memory.csv. A machine of one core has none."""
    if BUSY["copies"] == 1:
        return {}
    steps = max(40, math.ceil(BUSY_SECONDS / seconds))
    alone, busy = in_turns(args, write_scene(name, size, steps), [ALONE, BUSY])
    factors = memory_factors(*(costs_of(name, run) for run in (alone, busy)))
    factors = {k: f for k, f in factors.items() if k in alone["phases"]}
    rows = [{"scene": name, "particles": alone["particles"], "name": k, "processes": BUSY["copies"], "alone_ns": f"{alone['phases'][k]:.4g}",
             "busy_ns": f"{busy['phases'][k]:.4g}", "factor": f"{f:.3f}"} for k, f in factors.items()]
    same = lambda row: (row["scene"], str(row["particles"])) == (name, str(alone["particles"]))
    write(MEMORY, [row for row in read_rows(MEMORY) if not same(row)] + rows)
    return factors


def costs_of(name, alone):
    """Costs of phases, ns a particle, and of migration."""
    phases = {k: v for k, v in alone["phases"].items() if k not in ("REDUCE", "MIGRATE", "SETTLE", "other", "all")}
    return phases | migration(name)


def calibrate(args):
    """Measures costs.csv anew, or the costs of some scenes."""
    rows = [row for row in read_rows(COSTS) if not wanted(args.scenes, row["scene"])]
    for box in ("box2d", "box3d"):
        run_calibrator(args, write_scene(box, SCENES[box].strong, 40), ROOT / f"docs/data/models/{box}.model")
    for name, scene in SCENES.items():
        if not wanted(args.scenes, name):
            continue
        run = in_turns(args, write_scene(name, scene.small, 40), [ALONE])[0]
        costs = costs_of(name, run)
        print(f"  {name:10} {run['particles']} particles: " + ", ".join(f"{k} {v:.4g}" for k, v in costs.items()), flush=True)
        rows += [{"scene": name, "particles": run["particles"], "name": k, "ns": f"{v:.4g}"} for k, v in costs.items()]
    write(COSTS, sorted((r for r in rows if r["scene"] in SCENES), key=lambda r: list(SCENES).index(r["scene"])))


def read_costs():
    costs = {}
    for row in read_rows(COSTS):
        costs.setdefault(row["scene"], dict(FIXED))[row["name"]] = float(row["ns"])
    for name in SCENES:
        if name not in costs:
            print(f"no costs of {name}: not simulated; simulate.py --calibrate --only costs --scenes {name} measures them")
    return costs


# ---- Tables
def write(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as f:
        out = csv.DictWriter(f, rows[0], lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def read_rows(path):
    if not path.exists():
        return []
    with open(path) as f:
        return list(csv.DictReader(f))


def wanted(chosen, value):
    """Is the value one of those that an option names? Without the option all are."""
    return not chosen or value in chosen


KEY = ("scene", "strategy", "migrate", "mode", "platform", "ranks")  # columns that tell the rows of a table apart


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

    def key(self):
        return tuple(str(getattr(self, k)) for k in KEY)


def chosen(args, run):
    """Is this run to be made?"""
    return (wanted(args.scenes, run.scene) and wanted(args.mode, run.mode) and wanted(args.strategy, run.strategy) and
            wanted(args.migrate, run.migrate) and (run.ranks == 1 or wanted(args.sizes, run.ranks)))


def write_table(path, plan, done):
    """Writes the rows in the sequence of the plan, with efficiencies: the time a particle on one process of the same scene, mode and platform,
    over that of this run times its processes."""
    keys = [run.key() for run in plan]
    rows, base = [done[k] for k in keys if k in done] + [row for k, row in done.items() if k not in keys], {}
    for row in rows:
        work = float(row["seconds_per_step"]) * int(row["ranks"]) / int(row["particles"])
        one = base.setdefault((row["scene"], row["mode"], row["platform"]), work if int(row["ranks"]) == 1 else math.nan)
        row["efficiency"] = f"{one / work:.4f}"
    if rows:
        write(path, rows)


LARGE_RUN = threading.Lock()  # runs on many processes take much memory: one at a time


def table(args, path, plan, costs):
    """Makes the chosen runs of a plan and writes their table, in which the other rows stay."""
    plan, wrong = [run for run in plan if run.scene in costs], 0
    making = [run for run in plan if chosen(args, run)]
    done = {tuple(row[k] for k in KEY): row for row in read_rows(path)}  # a new row takes the place of its old one when it is there

    def make(run):
        with LARGE_RUN if run.ranks >= 512 else contextlib.nullcontext():
            return simulated(args, write_scene(run.scene, run.size, run.steps), hosts(run.ranks), run.ranks, run.mode,
                             run.strategy, run.migrate, run.platform, costs[run.scene])

    executor = concurrent.futures.ThreadPoolExecutor(os.cpu_count())
    # Injected runs may share the machine; emulated ones wait until they are alone.
    started = [executor.submit(make, run).result if run.mode == "injected" else functools.partial(make, run) for run in making]
    for run, result in zip(making, started):
        if run.mode == "emulated":
            executor.shutdown()
        label = f"  {run.scene:10} {run.strategy:8} {run.migrate:7} {run.mode:9} {run.platform:8} {run.ranks:5}"
        try:
            r = result()
        except RuntimeError as fault:
            print(f"{label}  failed: {str(fault).strip().splitlines()[-1][:150]}", flush=True)
            wrong += 1
            continue
        same = r["digest"] == true_digest(args.pebble, write_scene(run.scene, run.size, run.steps))
        wrong += not same
        cells = patch(args.pebble, write_scene(run.scene, run.size, run.steps)) if run.strategy == "pool" else ""
        row = {"scene": run.scene, "strategy": run.strategy, "migrate": run.migrate, "pool_cells": cells, "mode": run.mode,
               "platform": run.platform, "ranks": run.ranks, "particles": r["particles"], "steps": r["steps"],
               "seconds_per_step": f"{r['seconds']:.9g}", "efficiency": "", "imbalance": f"{r['imbalance']:.3f}",
               "cut": r["cut"], "digest": r["digest"], "same_as_real": "yes" if same else "no"}
        done[run.key()] = row
        write_table(path, plan, done)
        print(f"{label}  {1e6 * r['seconds']:10.1f} us/step  efficiency {row['efficiency']}  max/mean {r['imbalance']:.3f}  "
              f"{'same bits' if same else 'OTHER BITS'}  ({r['wall']:.1f} s)", flush=True)
    executor.shutdown()
    return wrong


def curves(ranks, scenes, size, steps):
    """Runs of the main curve, then with DMSwarmMigrate, then of the pool, injected and then emulated; all refer to the run on one process."""
    for name in scenes:
        for mode in ("injected", "emulated"):
            for strategy, migrate in (("spatial", "direct"), ("spatial", "swarm"), ("pool", "direct")):
                if mode == "emulated" and migrate == "swarm":
                    continue
                for p in ranks:
                    if p > 1 or (strategy, migrate) == ("spatial", "direct"):
                        # The simulator takes long for the pool's many messages, and its steps are all alike.
                        yield Run(name, size(name, p), steps if strategy == "spatial" else steps // 4, strategy, migrate, mode, "cluster", p)


def strong():
    yield from curves((1, 2, 4, 8, 16, 32), SCENES, lambda name, p: SCENES[name].strong, 40)


def weak():
    yield from curves((1, 2, 4, 8, 16, 32), WEAK, weak_size, 40)


BEYOND = (64, 128, 256, 512, 1024)  # the simulator takes minutes to set up 256 and more: only the most important runs have so many


def large_weak():
    """Runs of weak scaling on more than 32 processes."""
    for name in WEAK:
        for p in (1, *BEYOND):
            yield Run(name, weak_size(name, p), 20, "spatial", "direct", "injected", "cluster", p)
    for platform, migrate in (("fattree", "direct"), ("cluster", "swarm")):
        for p in (1, *(p for p in BEYOND if p <= 256)):
            yield Run("box2d", weak_size("box2d", p), 20, "spatial", migrate, "injected", platform, p)


def large_strong():
    """Runs of strong scaling with about a million particles."""
    for name in LARGE:
        for p in (1, *BEYOND):
            yield Run(name, SCENES[name].large, 20, "spatial", "direct", "injected", "cluster", p)


def validate(args, _):
    """Simulates this machine, and compares with real runs on one and two of its cores, whose messages go through shared memory or by
    TCP. The costs are measured in turns with these runs: of the same scene, on one process. Where two processes share the memory
    they are multiplied by the factors that runs on one core and on all find just before."""
    ways = [{"ranks": 1, "strategy": "spatial", "migrate": "direct", "transport": "shared"}]
    for transport in TRANSPORTS:
        if wanted(args.transport, transport):
            measure(args, transport)
            ways += [{"ranks": 2, "strategy": strategy, "migrate": migrate, "transport": transport}
                     for strategy, migrate in (("spatial", "direct"), ("spatial", "swarm"), ("pool", "direct"))
                     if wanted(args.strategy, strategy) and wanted(args.migrate, migrate)]
    path_of_table, wrong = DATA / "validate.csv", 0
    key = lambda row: tuple(str(row[k]) for k in ("scene", "particles", *ways[0]))
    done = {key(row): {**row, "memory_factor": row.get("memory_factor", "")} for row in read_rows(path_of_table)}
    for name, scene in SCENES.items():
        for size in (scene.small, scene.strong) if wanted(args.scenes, name) else ():
            path = write_scene(name, size, 40)
            factors = measure_memory(args, name, size, in_turns(args, path, [ALONE])[0]["seconds"])
            alone, *runs = in_turns(args, path, [ALONE, *ways])
            one = FIXED | costs_of(name, alone)
            for how, run in zip(ways, runs):
                row = {"scene": name, "particles": run["particles"], **how, "real": f"{run['seconds']:.6g}"}
                digests = {run["digest"], alone["digest"]}
                platform = how["transport"] if how["ranks"] > 1 else "cluster"  # one process sends nothing
                costs = sharing(one, factors, how["ranks"], BUSY["copies"])
                for mode in ("injected", "emulated"):
                    r = simulated(args, path, hosts(how["ranks"]), how["ranks"], mode, how["strategy"], how["migrate"], platform, costs)
                    digests.add(r["digest"])
                    row[mode], row[f"{mode}_over_real"] = f"{r['seconds']:.6g}", f"{r['seconds'] / run['seconds']:.3f}"
                wrong += len(digests) > 1
                row["same_digest"] = "no" if len(digests) > 1 else "yes"
                row["memory_factor"] = f"{sum(costs[k] for k in factors) / sum(one[k] for k in factors):.3f}" if factors else ""
                print(f"  {name:10} {row['particles']:7} {how['strategy']:8} {how['migrate']:7} {how['ranks']} {how['transport']:6}  real "
                      f"{1e6 * run['seconds']:9.1f} us/step  injected {row['injected_over_real']}  emulated {row['emulated_over_real']} of it", flush=True)
                done[key(row)] = row
            write(path_of_table, sorted(done.values(), key=lambda r: (
                list(SCENES).index(r["scene"]), int(r["particles"]), int(r["ranks"]), list(TRANSPORTS).index(r["transport"]))))
    return wrong


def main():
    names = lambda text: text.split(",")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=ROOT / "pebble", type=lambda p: Path(p).resolve(), help="the program")
    parser.add_argument("--simulator", default=ROOT / "build/simulate/pebble", type=lambda p: Path(p).resolve(), help="built with smpicc")
    parser.add_argument("--calibrator", default=ROOT / "build/mpicc/calibrate", type=lambda p: Path(p).resolve(),
                        help="the program of make calibrate")
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--calibrate", action="store_true")
    parser.add_argument("--validate", action="store_true")
    parser.add_argument("--only", type=names)
    parser.add_argument("--scenes", type=names)
    parser.add_argument("--mode", choices=["injected", "emulated"])
    parser.add_argument("--strategy", choices=["spatial", "pool"])
    parser.add_argument("--migrate", choices=["direct", "swarm"])
    parser.add_argument("--transport", choices=list(TRANSPORTS), help="transport of messages in the validation on two processes")
    parser.add_argument("--sizes", type=lambda text: [int(p) for p in text.split(",")])
    parser.add_argument("--calibrations", type=int, default=15, help="runs of each kind, of which the fastest counts")
    parser.add_argument("--repeat", type=int, default=2, help="emulated runs, of which the fastest counts")
    args = parser.parse_args()
    parts = {"costs": lambda costs: 0,
             "strong": lambda costs: table(args, DATA / "strong.csv", strong(), costs),
             "weak": lambda costs: table(args, DATA / "weak.csv", weak(), costs),
             "weak-large": lambda costs: table(args, DATA / "weak-large.csv", large_weak(), costs),
             "strong-large": lambda costs: table(args, DATA / "strong-large.csv", large_strong(), costs),
             "validate": lambda costs: validate(args, costs)}
    only = ["validate"] if args.validate else args.only or list(parts)
    if set(only) - set(parts) or set(args.scenes or ()) - set(SCENES):
        parser.error(f"parts are {', '.join(parts)}, scenes {', '.join(SCENES)}")
    WORK.mkdir(parents=True, exist_ok=True)
    if args.calibrate or not COSTS.exists():
        print("costs, ns a particle (SWARM: a call), measured on this machine")
        calibrate(args)
    costs, wrong = read_costs(), 0
    if set(only) & {"strong", "weak", "validate"} and not args.scenes:
        scenes.record(DATA, scenes.machine(args.pebble, args.mpiexec) | {"PETSc of the simulator": "3.26.1", "simulator": scenes.said("smpirun", "--version")})
    for what in parts:
        if what in only and what != "costs":
            print(what)
            wrong += parts[what](costs)
    print(f"tables in {os.path.relpath(DATA)}; {wrong} runs failed or had other bits than the real program")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
