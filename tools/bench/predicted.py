"""The group `predicted` of tools/bench.py: how long each scene of options/ takes, and what it said with rough constants: by
its first steps of the whole run with output if that lasts long enough, else before the first step of the steps alone."""
import glob
import os
import re
import tempfile

import scenes

UNITS = {"second": 1, "minute": 60, "hour": 3600}


def of(out):
    """(measured, predicted) of what a run printed, s; None of a run that predicts nothing, as statics."""
    before = re.search(r"^predict +([\d.e+]+) steps of (\S+) s: ", out, re.M)
    after = re.search(r"^predict +after \S+ s: .*, about ([\d.e+-]+) (second|minute|hour)s? in all", out, re.M)
    if after:
        return sum(map(float, re.findall(r"^done .* in (\S+) s", out, re.M))), float(after[1]) * UNITS[after[2]]
    if not before:
        return None
    each, particles, steps = (float(re.search(pattern, out, re.M)[1]) for pattern in (
        r"^speed +(\S+) ns/particle/step", r"^scene .* (\d+) particles", r"^done +(\d+) steps"))  # fmt: skip
    return 1e-9 * each * particles * steps, float(before[1]) * float(before[2])


def measure(bench, output):
    rows = []
    for path in sorted(glob.glob(os.path.join(scenes.ROOT, "options", "*.opts"))):
        with tempfile.TemporaryDirectory() as folder:
            out = bench.attempt(output, [bench.args.pebble, "-options_file", path, "-output_dir", folder])
        if told := of(out or ""):
            rows.append(dict(zip(("scene", "measured", "predicted"), (os.path.basename(path).removesuffix(".opts"), *told))))
            print("  {scene:44s} measured {measured:8.3g} s, predicted {predicted:8.3g} s".format(**rows[-1]), flush=True)
    scenes.table(os.path.join(scenes.ROOT, "docs", "data", "bench", "predicted.csv"), rows)
