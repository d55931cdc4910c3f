"""In the hot loops every product is part of a fused multiply-add, or bits would depend on what a compiler fuses: where
processors have such instructions, the compiled loops hold no other multiplication of reals.

usage: test_fused.py PEBBLE SOURCE MPIEXEC BUILD     (folder of the objects)
"""
import glob
import os
import platform
import re

import check

(build,) = check.arguments(__doc__, 1)
for lanes in (8, 4):
    paths = glob.glob(os.path.join(build, "kernels", f"transfer_sums.{lanes}.o"))
    if not paths and platform.machine() != "x86_64":
        check.that(True, f"{lanes} lanes: not on this processor")
        continue
    check.need(len(paths) == 1, f"{lanes} lanes: {len(paths)} objects transfer_sums.{lanes}.o")
    code = check.run(["objdump", "-d", "--no-show-raw-insn", paths[0]])
    check.need(code.status == 0, f"objdump: {code.said}")
    function, fused, alone = "", 0, []
    for line in code.out.splitlines():
        if head := re.match(r"[0-9a-f]+ <(\w+)", line):
            function = head[1]
        elif re.search(r"\sv?mul[ps]d\s", line) and not function.startswith("MPMChains"):  # no sum of particles
            alone.append(f"{function}: {line.strip()}")
        fused += bool(re.search(r"\svfn?m(add|sub)\d+[ps]d\s", line))
    check.that(not alone, f"{lanes} lanes: products that are not fused: {alone[:5] or 'none'}")
    check.that(fused, f"{lanes} lanes: {fused} fused multiply-adds")
check.end()
