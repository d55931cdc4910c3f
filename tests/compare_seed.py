#!/usr/bin/env python3
"""Compare the result of seed_serial with the last step of a Pebble file.

usage: compare_seed.py RESULT.txt FILE.h5 [--tol 1e-12] [--stress-floor 0]

Prints one line a field: the largest absolute difference over the largest absolute value in the seed's result.
Exit status 1 when a figure is above the tolerance (or not a number), or when the particles are not the same ones.
"""
import argparse
import sys

import h5py
import numpy as np


def read_seed(path):
    """Fields of the seed's lines: id x y vx vy F00 F01 F10 F11 sxx sxy syx syy."""
    table = np.loadtxt(path, ndmin=2)
    if table.shape[1] != 13:
        sys.exit(f"{path}: {table.shape[1]} columns, not 13")
    return {"id": table[:, 0], "x": table[:, 1:3], "v": table[:, 3:5], "F": table[:, 5:9], "stress": table[:, 9:13]}


def read_pebble(path):
    """The same fields of the last step: 2-D parts of vectors of 3, tensors of 9 and (xx xy xz yy yz zz) of 6."""
    with h5py.File(path, "r") as file:
        steps = [name for name in file if name.startswith("step_")]
        if not steps:
            sys.exit(f"{path}: no step in it")
        # As numbers: %06d sorts as text only up to 999999.
        step = file[max(steps, key=lambda name: int(name[len("step_"):]))]
        get = {name: step["particles"][name][...] for name in ("id", "x", "v", "F", "stress")}
        print(f"step {step.attrs['step']}  time {step.attrs['time']:.9g}  {len(get['id'])} particles")
    return {"id": get["id"], "x": get["x"][:, :2], "v": get["v"][:, :2], "F": get["F"][:, [0, 1, 3, 4]],
            "stress": get["stress"][:, [0, 1, 1, 3]]}


def difference(seed, pebble, floor):
    """Normwise: components that are zero but for round-off have no relative error of their own."""
    scale = max(np.abs(seed).max(), floor)
    gap = np.abs(pebble - seed).max()
    return gap / scale if scale > 0 else gap


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seed", metavar="RESULT.txt")
    parser.add_argument("pebble", metavar="FILE.h5")
    parser.add_argument("--tol", type=float, default=1e-12)
    parser.add_argument("--stress-floor", type=float, default=0.0,
                        help="least stress to compare with, for bodies in free flight whose stress is round-off")
    args = parser.parse_args()
    seed, pebble = read_seed(args.seed), read_pebble(args.pebble)
    if not np.array_equal(seed["id"], pebble["id"]):
        sys.exit(f"particles differ: {len(seed['id'])} in {args.seed}, {len(pebble['id'])} in {args.pebble}"
                 " (or other ids)")
    failed = False
    for name in ("x", "v", "F", "stress"):
        figure = difference(seed[name], pebble[name], args.stress_floor if name == "stress" else 0.0)
        good = figure <= args.tol  # false for NaN
        failed = failed or not good
        print(f"{name:8s}{figure:.3e}{'' if good else f'  above {args.tol:g}'}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
