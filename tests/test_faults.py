#!/usr/bin/env python3
"""The faults of PETSc that docs/petsc.md tells of: test_faults.py PEBBLE SOURCE MPIEXEC FOLDER

Each program of tests/petsc, built in FOLDER with the PETSc of the makefile, says FAULT (exit status 1) or "as expected"
(0). It has to say what the document's table says of this version: a fault up to the version that mended it. If PETSc
mends another one this fails, so that the table learns of it. For the two versions that the document shows the output
of, the program has to print the same.
"""
import re
from pathlib import Path

import check
import mpi

NOT_MENDED = "no"


def table(text):
    """The rows of the document's table: program -> its section, number of processes, first version without the fault (or
    NOT_MENDED)."""
    rows = re.findall(r"^\| \[`(\w+)`\]\(#([\w-]+)\) \|.*\| (\d+) \| (?:yes, in (3\.\d+)|no) \|$", text, re.M)
    sections = {section.partition("\n")[0].lower().replace(" ", "-"): section for section in re.split(r"^###? ", text, flags=re.M)}
    return {name: (sections.get(anchor, ""), int(n), mended or NOT_MENDED) for name, anchor, n, mended in rows}


def run(folder, name, n):
    """Runs a program; returns its verdict, the whole line, the version in it, and whether the exit status fits."""
    status, out, err = mpi.run(n, [folder / name], mpiexec=check.mpiexec, timeout=check.TIMEOUT)
    line = re.search(r"^PETSc (\d+\.\d+)\.(\d+): (FAULT|as expected): .*$", out, re.M)
    check.need(line, f"{name} printed no verdict:\n{out}{err}")
    check.that((status == 0) == (line[3] == "as expected"), f"{name}: exit status {status}")
    return line[3], line[0], line[1]


def number(version):
    return tuple(map(int, version.split(".")))


[folder] = check.arguments(__doc__, 1)
text = (Path(check.source) / "docs/petsc.md").read_text(encoding="utf-8")
rows = table(text)
programs = {path.stem for path in (Path(check.source) / "tests/petsc").glob("*.c")}
check.that(programs and set(rows) == programs, f"the table has a row for each of {len(programs)} programs: {sorted(programs ^ set(rows))}")
for name in sorted(programs & set(rows)):
    section, n, mended = rows[name]
    verdict, line, version = run(Path(folder).resolve(), name, n)
    fault = mended == NOT_MENDED or number(version) < number(mended)
    check.that((verdict == "FAULT") == fault, f"{name}: {line} (mended, says docs/petsc.md: {mended})")
    shown = re.findall(r"^ +(PETSc (\d+\.\d+)\.\d+: .*)$", section, re.M)
    check.that(len(shown) == 2, f"{name}: its section shows what two versions print")
    wrong = [printed for printed, of in shown if of == version and printed.partition(": ")[2] != line.partition(": ")[2]]
    check.that(not wrong, f"{name}: lines of its section that differ from what it prints: {wrong}")
check.end()
