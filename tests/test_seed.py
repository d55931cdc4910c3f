"""Two colliding disks by the assignment's serial program and by pebble: the same points after 1, 10 and 500 steps.

usage: test_seed.py SEED PEBBLE SOURCE MATERIAL [WORK]     (WORK: folder for the files, default the current one)
"""
import os
import subprocess
import sys

DT, TOLERANCE = "0.006", "1e-12"
FLOOR = "1000"  # Young's modulus: before the contact stress is round-off, which no relative error can judge


def run(*command):
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print("$ " + " ".join(command), result.stdout, sep="\n", flush=True)
    if result.returncode:
        sys.exit(f"FAIL: exit status {result.returncode} of {command[0]}")


def main(seed, pebble, source, material, work="."):
    for steps in ("1", "10", "500"):
        points, folder = os.path.join(work, f"seed_{steps}.txt"), os.path.join(work, f"pebble_{steps}")
        run(seed, "cells=20", "ppc=4", f"dt={DT}", f"steps={steps}", f"material={material}", f"out={points}")
        run(pebble, "-options_file", os.path.join(source, "options", "disks.opts"), "-material_soft_model", material,
            "-dt_size", DT, "-time_end", "1e6", "-time_max_steps", steps, "-output_dir", folder)
        run(sys.executable, os.path.join(source, "tests", "compare_seed.py"), points, os.path.join(folder, "disks.h5"),
            "--tol", TOLERANCE, "--stress-floor", FLOOR if steps != "500" else "0")


if __name__ == "__main__":
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    main(*sys.argv[1:])
