"""Two colliding disks by the assignment's serial program and by pebble: the same particles after 1, 10 and 500 steps.

usage: test_seed.py PEBBLE SOURCE MPIEXEC SEED MATERIAL
"""
import numpy as np

import check

DT, TOLERANCE = "0.006", 1e-12
FLOOR = 1000.0  # Young's modulus: before the contact stress is round-off, which no relative error can judge
# Pebble's components in 2-D, in the order of the seed: of vectors of 3, tensors of 9 and (xx xy xz yy yz zz) of 6.
PARTS = {"x": [0, 1], "v": [0, 1], "F": [0, 1, 3, 4], "stress": [0, 1, 3, 4]}


def read_seed(path):
    """Fields of the seed's lines: id x y vx vy F00 F01 F10 F11 sxx sxy syx syy."""
    table = np.loadtxt(path, ndmin=2)
    assert table.shape[1] == 13
    table = table[np.argsort(table[:, 0])]
    return {"id": table[:, 0], "x": table[:, 1:3], "v": table[:, 3:5], "F": table[:, 5:9], "stress": table[:, 9:13]}


seed, material = check.arguments(__doc__, 2)
for steps in ("1", "10", "500"):
    name = f"seed_{steps}"
    told = check.run([seed, "cells=20", "ppc=4", f"dt={DT}", f"steps={steps}", f"material={material}", f"out={name}.txt"])
    check.that(told.status == 0, f"{steps} steps by the seed, exit status {told.status}")
    check.must("-options_file", check.scene("disks"), "-material_soft_model", material, "-check_law", "warn", "-dt_size", DT, "-time_end", "1e6",
               "-time_max_steps", steps, "-output_dir", ".", "-output_name", name)
    want, found = read_seed(name + ".txt"), check.particles(name + ".h5")
    if not check.that(np.array_equal(want["id"], found["id"]), f"{steps} steps: the same {len(want['id'])} particles"):
        continue
    for field, parts in PARTS.items():
        scale = max(np.abs(want[field]).max(), FLOOR if field == "stress" and steps != "500" else 0)
        error = np.abs(found[field][:, parts] - want[field]).max() / scale  # normwise: zeros have no relative error
        check.that(error <= TOLERANCE, f"{steps} steps: {field} differs by {error:.1e} of its largest (allowed {TOLERANCE})")
check.end()
