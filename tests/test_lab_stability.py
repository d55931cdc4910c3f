"""pebble-study stability finds the slow growth of methods that are known to be unstable where particles cross cells, and does not
deny a stable one; with as many steps as it needs.

usage: test_lab_stability.py PEBBLE SOURCE MPIEXEC
"""
import os
import subprocess

import check
import mpi

check.arguments(__doc__, 0)
os.environ.update(mpi.ENVIRONMENT | dict(os.environ) | {"PEBBLE": check.program, "MPIEXEC": check.mpiexec})
BAR = ["-dim 1", "-grid_lower 0", "-grid_upper 1", "-grid_cells 16", "-materials m", "-material_m_model elastic", "-material_m_rho 1", "-material_m_E 1", "-material_m_nu 0",
       "-bodies b", "-body_b_shape box", "-body_b_lower 0", "-body_b_upper 1", "-body_b_material m", "-time_end 1"]


def study(name, *words):
    """The rows of the table of a study of 40,000 steps."""
    folder = check.folder(name)
    path = check.write(os.path.join(folder, "bar.opts"), BAR)
    done = subprocess.run([os.path.join(check.source, "pebble-study"), "stability", path, "-output_dir", folder, "--steps", "40000", *words], capture_output=True, text=True, timeout=1500)
    check.that(done.returncode == 0, f"{name}: {done.stdout[-500:]}{done.stderr[-500:]}")
    return check.rows(os.path.join(folder, "bar_stability.csv"))


def number(row, name):
    return float(row[name]) if row[name] else float("inf")


rows = study("musl", "--basis", "bspline2,gimp_stretch", "--update", "musl", "--transfer", "flip")
for row in rows:
    check.that(number(row, "crossing_unstable") <= 0.4, f"{row['basis']} musl flip, crossing: unstable from {row['crossing_unstable']}")
    check.that(number(row, "rest") >= 1, f"{row['basis']} musl flip, at rest: stable to {row['rest']}")
check.that(len(rows) == 2, "two methods")
(row,) = study("usl", "--basis", "bspline2", "--update", "usl", "--transfer", "flip")
for probe in ("rest", "crossing", "block"):
    check.that(number(row, probe) >= 0.4, f"bspline2 usl flip, {probe}: stable to {row[probe]}")
check.end()
