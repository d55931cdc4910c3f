#!/usr/bin/env python3
"""In the hot loops every product is part of a fused multiply-add, or bits would depend on what a compiler fuses: where
processors have such instructions, the compiled loops hold no other multiplication of reals.

usage: test_fused.py BUILD     (folder of the objects)
"""
import os
import re
import subprocess
import sys

faults, fused = [], {}
for lanes in (8, 4):
    path = os.path.join(sys.argv[1], f"transfer_sums.{lanes}.o")
    if not os.path.exists(path):
        continue  # not an x86 processor
    code = subprocess.run(["objdump", "-d", "--no-show-raw-insn", path], capture_output=True, text=True, check=True).stdout
    function, fused[lanes] = "", 0
    for line in code.splitlines():
        if head := re.match(r"[0-9a-f]+ <(\w+)", line):
            function = head[1]
        elif re.search(r"\sv?mul[ps]d\s", line) and not function.startswith("MPMChains"):  # no sum of points
            faults.append(f"{path}: {function}: {line.strip()}")
        fused[lanes] += bool(re.search(r"\svfn?m(add|sub)\d+[ps]d\s", line))
    if not fused[lanes]:
        faults.append(f"{path} has no fused multiply-adds at all")
for fault in faults:
    print("FAIL", fault)
print(f"fused multiply-adds by lanes: {fused}, {len(faults)} faults")
sys.exit(bool(faults))
