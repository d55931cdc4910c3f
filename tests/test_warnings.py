"""The compiler had nothing to say about any object of the program: make keeps what it says beside each.

usage: test_warnings.py PEBBLE SOURCE MPIEXEC BUILD     (folder of the objects)
"""
import glob
import os

import check

(build,) = check.arguments(__doc__, 1)
runs = os.path.join(build, "tests", "")
objects = [path for path in glob.glob(os.path.join(build, "**", "*.o"), recursive=True) if not path.startswith(runs)]
for path in objects:
    said = check.content(path + ".said").decode() if os.path.exists(path + ".said") else "not compiled by this makefile"
    check.fault(said and f"{os.path.relpath(path, build)}: {said}")
print(f"{len(objects)} objects")
check.end()
