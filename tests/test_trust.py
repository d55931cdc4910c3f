"""The starter problems (tools/trust) with the default settings: their exact or published numbers are met, but for
those that are known to be missed. docs/trust.md is what its data say.

usage: test_trust.py PEBBLE SOURCE MPIEXEC first|all     (first: 1-D and 2-D on the first grid; all: into trust.csv)
"""
import os
import re
import sys

import check

part, = check.arguments(__doc__, 1)
sys.path[:0] = [os.path.join(check.source, "tools", "trust")]
import trust  # noqa: E402 (after the path)
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
