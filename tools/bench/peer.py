"""The part that the scripts of the peers share: it takes the scene from the command line, and runs it on request.

    peer_<name>.py SCHEME DIM PARTICLES PER_AXIS...

A peer prints a line when it is compiled and ready. Then, for each line "STEPS" on standard input, it starts the scene anew,
runs one step that is not timed, times the steps after it, and prints a line of JSON. So a peer compiles once and waits while
others run.
"""
import json
import sys
import time

import numpy as np

from scene import RHO, Scene

SCHEMES = ("flip", "mls")


def serve(make):
    """make(scene, scheme) returns reset(x, v), steps(n) and state() -> v, grid_mass()."""
    scheme, dim, particles = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
    if scheme not in SCHEMES:
        sys.exit(__doc__)
    scene = Scene(dim, particles, [int(p) for p in sys.argv[4:]])
    x, v, volume = scene.arrays()
    reset, steps, state, grid_mass = make(scene, scheme, volume)
    reset(x, v)
    steps(2)
    print(json.dumps({"particles": len(x)}), flush=True)
    for line in sys.stdin:
        n = int(line)
        reset(x, v)
        steps(1)
        start = time.perf_counter()
        steps(n - 1)
        seconds = time.perf_counter() - start
        new = state()
        mass = RHO * volume
        print(json.dumps({
            "ns": 1e9 * seconds / max(n - 1, 1) / len(x), "kinetic": float(0.5 * mass * np.sum(new * new)),
            "mass": mass * len(x), "grid_mass": grid_mass(), "momentum": (mass * new.sum(axis=0)).tolist(),
            "momentum_start": (mass * v.sum(axis=0)).tolist()}), flush=True)
