"""The starter problems (tools/trust) with the default settings: their exact or published numbers are met, but for
those that are known to be missed. docs/trust.md is what its data say.

What is read from particles weighs them by mass or volume.

usage: test_trust.py PEBBLE SOURCE MPIEXEC first|all     (first: 1-D and 2-D on the first grid; all: into trust.csv)
"""
import os
import re
import sys

import numpy as np

import check

part, = check.arguments(__doc__, 1)
sys.path[:0] = [os.path.join(check.source, "tools", "trust")]
import trust  # noqa: E402 (after the path)
import scenes  # noqa: E402
from starters import KNOWN, STARTERS  # noqa: E402

# ---- The table: scenes leave to the program what is its to choose, and every mark belongs to a row.
CHOSEN = r"-(method_\w+|dt_\w+|body_\w+_ppc|body_\w+_offset|material_\w+_tension_cutoff) "
numbers = {}
for name, starter in STARTERS.items():
    for n in starter.grids:
        found = re.findall(CHOSEN, f"{starter.scene(n)} {starter.then}")
        check.fault(f"{name} chooses {found}" if found else None)
        numbers |= {(name, number.name, str(n)): number for number in starter.numbers}
    lengths = {len(starter.grids), *(len(number.limits) for number in starter.numbers)}
    check.fault(None if lengths == {3} else f"{name}: {lengths} grids and limits, not 3")
marks = {(*key[:2], str(key[2])) for key in KNOWN}
check.that(marks <= set(numbers), f"{len(marks)} marks of what is wrong are among the {len(numbers)} numbers")

# ---- What is wrong is found, and so is a mark that is no longer needed.
key = next(key for key in numbers if key not in marks)
row = dict(zip(("starter", "number", "n"), key), right="1", got="1", error="0.01", limit="0.02", status="0", says="")
marked = row | dict(zip(("starter", "number", "n"), next(iter(marks))))
above, no_number = {"error": "0.03"}, {"error": "nan"}
stopped, refused = {"error": "", "status": "3"}, {"error": "", "status": "2"}
for fine, changed in ((True, row), (False, row | above), (False, row | no_number), (False, row | stopped),
                      (False, row | refused), (False, marked), (True, marked | above), (True, marked | stopped)):
    found, line = trust.judge(changed)
    check.that(found == fine, f"{'taken' if found else 'found'}: {line}")

# ---- Matter counts by its mass and volume: a particle that is divided into two changes no number.
class Made:
    """What is read of a run, of made-up particles; halved: which of them are two of half the mass and volume."""
    dim, h = 2, 0.1

    def __init__(self, halved):
        numbers = np.random.default_rng(1)
        self.fields, n = [], len(halved)
        for _ in range(2):
            fields = dict(x=numbers.uniform(0.1, 0.54, (n, 3)), v=numbers.normal(size=(n, 3)), mass=numbers.uniform(1, 2, n),
                          volume=numbers.uniform(1, 2, n), stress=1e5 * numbers.normal(size=(n, 9)))
            self.fields.append({key: np.concatenate([values, values[halved]]) for key, values in fields.items()})
            for key in ("mass", "volume"):
                self.fields[-1][key][np.append(halved, np.ones(halved.sum(), bool))] /= 2

    def particles(self, which, *names):
        return [self.fields[which][name] for name in names]

    def column(self, name):
        return np.ones(2)


whole, halved = Made(np.zeros(40, bool)), Made(np.arange(40) % 3 == 0)
for name, get in dict(spin=scenes.spin, volumes=scenes.volumes, inner_rim=scenes.inner_rim, mean_stress=scenes.mean_stress(0.1), hydrostatic=scenes.hydrostatic,
                      vertical_stress=scenes.vertical_stress, idle=scenes.idle(0.5)).items():
    one, two = get(whole, 8), get(halved, 8)
    check.that(abs(two / one - 1) < 1e-12, f"{name} of particles, and of the same with some divided into two: {one}, {two}")
x = np.random.default_rng(2).normal(size=500)
check.that(abs(scenes.problems.reach(x, np.full(500, 3.0)) - np.quantile(x, 0.995)) < 1e-12, "the reach of particles of one mass is a quantile of their places")
check.that(scenes.problems.reach(np.append(x, x + 10), np.repeat([1, 1e-9], 500)) <= x.max(), "what has next to no mass does not reach far")

# ---- The runs
if part == "first":
    check.that(trust.page(check=True), "docs/trust.md is what docs/data/trust.csv says")
    data = trust.read()
    check.that(set(data) == set(numbers), f"{len(data)} rows of the data are those of the problems")


def say(fine, line):
    check.that(fine, line)


names = [name for name, starter in STARTERS.items() if part == "all" or starter.dim < 3]
rows = trust.study(check.program, "runs", names, *((1, 1) if part == "first" else (3, 2)), say)
if part == "all":
    trust.write(rows, "trust.csv")
for key, row in rows.items() if part == "first" else ():
    told, kept, most = row["got"], data[key]["got"], 0.1 * float(row["limit"]) * (abs(float(row["right"])) or 1)
    alike = key in marks or told and kept and abs(float(told) - float(kept)) <= most
    check.fault(None if alike else f"{', '.join(key)}: {told}, in docs/data/trust.csv {kept}; make verify renews it")
check.end()
