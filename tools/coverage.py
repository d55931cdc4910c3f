"""Which lines of src the runs of a program built with DEBUG=coverage have reached, by rooms. Code that is compiled for several
numbers of lanes counts as one: a line is covered if it ran with any of them.

usage: coverage.py BUILD [--missing] [--least PERCENT]

BUILD      folder of the objects and of what the runs counted, build/mpicc-coverage
--missing  lists the lines that no run reached
--least    the exit status is 1 if less of all lines is covered
"""
import argparse
import collections
import gzip
import json
import pathlib
import subprocess
import sys
import tempfile


def counts(build):
    """{file of src: {line: how often it ran}}"""
    source = pathlib.Path.cwd()
    found = collections.defaultdict(collections.Counter)
    notes = [str(path.resolve()) for path in sorted(build.glob("*/*.gcno"))]
    with tempfile.TemporaryDirectory() as folder:
        for note in notes:
            subprocess.run(["gcov", "--json-format", note], cwd=folder, check=True, capture_output=True)
            for path in pathlib.Path(folder).glob("*.gcov.json.gz"):
                with gzip.open(path) as file:
                    data = json.load(file)
                path.unlink()
                for entry in data["files"]:
                    name = pathlib.Path(data["current_working_directory"], entry["file"])
                    if not name.is_relative_to(source / "src"):
                        continue
                    lines = found[str(name.relative_to(source))]
                    for line in entry["lines"]:
                        lines[line["line_number"]] += line["count"]
    return found


def ranges(lines):
    """Lines as text: 3-5 9."""
    parts = []
    for line in sorted(lines):
        if parts and parts[-1][1] == line - 1:
            parts[-1][1] = line
        else:
            parts.append([line, line])
    return " ".join(f"{a}-{b}" if b > a else str(a) for a, b in parts)


parser = argparse.ArgumentParser(usage=__doc__)
parser.add_argument("build", type=pathlib.Path)
parser.add_argument("--missing", action="store_true")
parser.add_argument("--least", type=float, default=0)
arguments = parser.parse_args()
found = counts(arguments.build)
if not found:
    sys.exit(f"coverage.py: {arguments.build} has no objects that count; make DEBUG=coverage builds them")
rooms = collections.defaultdict(lambda: [0, 0])
for name, lines in found.items():
    for key in (name.split("/")[1], "all"):
        rooms[key][0] += sum(count > 0 for count in lines.values())
        rooms[key][1] += len(lines)
    if arguments.missing and 0 in lines.values():
        print(f"{name}: {ranges(line for line, count in lines.items() if not count)}")
print(f"{'room':<12}{'lines':>8}{'reached':>9}{'%':>8}")
for room, (reached, lines) in sorted(rooms.items(), key=lambda item: (item[0] == "all", item[0])):
    print(f"{room:<12}{lines:>8}{reached:>9}{100 * reached / lines:>8.1f}")
sys.exit(100 * rooms["all"][0] < arguments.least * rooms["all"][1])
