"""The group `predicted` of tools/bench.py: how long each scene of options/ takes over what it said that it would take, with
rough constants. A run that lasts long enough says so by its first steps; that is the whole run with output. Of others the
line before the first step counts, and the time of the steps alone."""
import glob
import os
import re
import statistics
import subprocess
import tempfile

LEAST, MOST = 0.67, 1.5
UNITS = {"second": 1, "minute": 60, "hour": 3600}


def of(out):
    """(measured, predicted) of what a run printed, s; None of a run that predicts nothing, as statics."""
    before = re.search(r"^predict +([\d.e+]+) steps of (\S+) s: ", out, re.M)
    after = re.search(r"^predict +after \S+ s: .*, about ([\d.e+-]+) (second|minute|hour)s? in all", out, re.M)
    if after:
        return float(re.search(r"^done .* in (\S+) s", out, re.M)[1]), float(after[1]) * UNITS[after[2]]
    if not before:
        return None
    each, particles, steps = (float(re.search(pattern, out, re.M)[1]) for pattern in (
        r"^speed +(\S+) ns/particle/step", r"^scene .* (\d+) particles", r"^done +(\d+) steps"))
    return 1e-9 * each * particles * steps, float(before[1]) * float(before[2])


def measure(args, results):
    ratios = {}
    for path in sorted(glob.glob(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "options", "*.opts"))):
        name = os.path.basename(path).removesuffix(".opts")
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run([args.pebble, "-options_file", path, "-output_dir", folder], capture_output=True, text=True, timeout=900)
        if run.returncode:
            results.problem(f"predicted: {name}: exit status {run.returncode}: {run.stderr.strip()}")
            continue
        told = of(run.stdout)
        if told:
            ratios[name] = told[0] / told[1]
            print(f"  {name:44s} measured {told[0]:8.3g} s, predicted {told[1]:8.3g} s, ratio {ratios[name]:.2f}", flush=True)
    if ratios:
        good = sum(LEAST <= ratio <= MOST for ratio in ratios.values())
        print(f"  {good} of {len(ratios)} from {LEAST} to {MOST}, the median {statistics.median(ratios.values()):.2f}")
