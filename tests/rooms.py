"""The rooms of src: each folder uses only itself and those before it, no two files use each other in a circle, none is too
long. What a file uses is seen in its includes and in its compiled object: a call by a prototype that was written by hand
counts, and so does a function in a table.

usage: rooms.py PEBBLE SOURCE MPIEXEC BUILD        (folder of the objects: BUILD/room/file.o, file.8.o ... of src/room/file.c)
       rooms.py PEBBLE SOURCE MPIEXEC --self-test  (makes small trees with each fault, and looks for it)
"""
import bisect
import collections
import functools
import os
import re
import shutil
import subprocess
import sys

import check

ROOMS = "base options physics known kernels particles parallel scene step results cost restart advice run".split()
LINES = {".c": 450, ".h": 250}  # most of a file
ENDS = (".c", ".h", ".def")


def files_of(src):
    """Paths of all files below src, from there."""
    return sorted(os.path.relpath(os.path.join(folder, name), src) for folder, _, names in os.walk(src) for name in names)


def room_of(path):
    return path.split("/")[0]


# ---- Files and includes

def misplaced(src, rooms):
    """What does not lie in a room as it should, and rooms that are not there."""
    files = files_of(src)
    faults = [f"src/{path}: not src/ROOM/name with one of the rooms {' '.join(rooms)} and of the ends {' '.join(ENDS)}" for path in files
              if not (path.count("/") == 1 and room_of(path) in rooms and path.endswith(ENDS))]
    return faults + [f"src/{room} has no files" for room in rooms if room not in map(room_of, files)]


def too_long(src):
    faults = []
    for path in files_of(src):
        with open(os.path.join(src, path), encoding="utf-8") as file:
            lines, most = sum(1 for _ in file), LINES.get(os.path.splitext(path)[1])
        if most and lines > most:
            faults.append(f"src/{path}: {lines} lines, {most} at most")
    return faults


def wrong_includes(src, rooms):
    faults = []
    for path in files_of(src):
        if room_of(path) not in rooms:
            continue
        with open(os.path.join(src, path), encoding="utf-8") as file:
            found = [(number, *match.groups()) for number, line in enumerate(file, 1) if (match := re.match(r'\s*#\s*include\s*(["<])([^">]+)', line))]
        for number, mark, name in found:
            ours = room_of(name) in rooms and "/" in name
            if mark == "<" and not ours:
                continue  # of the system or of a library
            where = f"src/{path}:{number} includes {name}"
            if not ours or ".." in name.split("/"):
                faults.append(f"{where}: not by the name of a room and of a file in it")
            elif rooms.index(room_of(name)) > rooms.index(room_of(path)):
                faults.append(f"{where}: of a later room")
    return faults


# ---- Symbols

def objdump(option, path):
    return subprocess.run(["objdump", option, "--wide", path], check=True, capture_output=True, text=True).stdout.splitlines()


def symbols_of(path):
    """Names that an object defines for others; and {section: [(start, end, name)]} of its functions and data."""
    defined, places = set(), collections.defaultdict(list)
    for line in objdump("-t", path):
        # address, seven letters (local or global ..., function or object), section, size, perhaps the visibility, name
        match = re.match(r"([0-9a-f]+) (.{7}) (\S+)\s+([0-9a-f]+)(?: \.\w+)? (\S+)$", line)
        if not match or match[3] == "*UND*":
            continue
        start, letters, section, size, name = int(match[1], 16), match[2], match[3], int(match[4], 16), match[5]
        if letters[0] in "gu!" or letters[1] == "w":
            defined.add(name)
        if letters[6] in "FO":
            places[section].append((start, start + size, name))
    return defined, {section: sorted(found) for section, found in places.items()}


def references_of(path, places):
    """(function or table of an object, symbol that it refers to): every relocation of code and data."""
    found, section = set(), None
    for line in objdump("-r", path):
        if head := re.match(r"RELOCATION RECORDS FOR \[(.*)\]:", line):
            section = head[1]
        elif (match := re.match(r"([0-9a-f]+) R_\S+\s+(\S+)", line)) and not section.startswith((".debug", ".eh_frame")):
            offset, inside = int(match[1], 16), places.get(section, [])
            k = bisect.bisect(inside, (offset, sys.maxsize)) - 1
            user = inside[k][2] if k >= 0 and offset < inside[k][1] else section
            # without what compilers add to names of parts of functions, and to symbols in relocations
            found.add((re.sub(r"\.(cold|part|constprop|isra|\d).*", "", user), re.sub(r"[-+]0x[0-9a-f]+$|@.*", "", match[2])))
    return found


def uses_of(src, build, rooms):
    """({file: {file that it uses: {(function or table, symbol)}}}, faults): by the objects of every .c file."""
    objects, faults = collections.defaultdict(list), []
    for path in files_of(build):
        if match := re.fullmatch(r"(\w+/\w+)(\.\d+)?\.o", path):
            objects[match[1] + ".c"].append(os.path.join(build, path))
    sources = [path for path in files_of(src) if path.endswith(".c") and room_of(path) in rooms]
    faults += [f"src/{source}: no object in {build}" for source in sources if source not in objects]
    homes, references = collections.defaultdict(set), collections.defaultdict(set)
    for source in sources:  # objects of other sources are old
        for path in objects[source]:
            defined, places = symbols_of(path)
            for name in defined:
                homes[name].add(source)
            references[source] |= references_of(path, places)
    uses = {source: collections.defaultdict(set) for source in sources}
    for source in sources:
        for user, symbol in references[source]:
            for home in homes.get(symbol, {source}) if source not in homes.get(symbol, {source}) else ():
                uses[source][home].add((user, symbol))
    return uses, faults


def words(pairs):
    return ", ".join(f"{user} uses {symbol}" for user, symbol in sorted(pairs))


def climbs(uses, rooms):
    return [f"src/{source} uses src/{home} of a later room: {words(pairs)}" for source in sorted(uses) for home, pairs in sorted(uses[source].items())
            if rooms.index(room_of(home)) > rooms.index(room_of(source))]


def circles(uses):
    """Groups of files of which each reaches each."""
    @functools.cache
    def reached(start):
        seen, rest = set(), [start]
        while rest:
            new = set(uses[rest.pop()]) - seen
            seen |= new
            rest += new
        return frozenset(seen)

    groups = {frozenset(other for other in reached(source) if source in reached(other)) for source in uses if source in reached(source)}
    faults = []
    for group in sorted(map(sorted, groups)):
        edges = [f"  {source} -> {home}: {words(pairs)}" for source in group for home, pairs in sorted(uses[source].items()) if home in group]
        faults.append("\n".join([f"a circle of {len(group)} files: {' '.join(group)}", *edges]))
    return faults


def faults_of(src, build, rooms):
    uses, faults = uses_of(src, build, rooms)
    seen = sum(len(pairs) for homes in uses.values() for pairs in homes.values())
    print(f"{len(uses)} sources, {seen} uses of symbols of other sources")
    check.need(seen, "no source uses another: these objects are read wrongly")
    return faults + misplaced(src, rooms) + too_long(src) + wrong_includes(src, rooms) + climbs(uses, rooms) + circles(uses)


# ---- The test of this test

# Three rooms without a fault; a table of a later room may hold a function of an earlier one.
GOOD = {
    "base/low.h": "int Low(void);\n",
    "base/low.c": '#include "base/low.h"\n#include <stdio.h>\nint Low(void)\n{\n  return puts("low");\n}\n',
    "options/high.h": '#include "base/low.h"\nint High(void);\n',
    "options/high.c": '#include "options/high.h"\nint High(void)\n{\n  return Low();\n}\nint (*const Table[])(void) = {Low, High};\n',
    "options/list.def": "X(one)\n",
    "options/side.c": '#include "options/high.h"\nint Side(void)\n{\n  return High();\n}\n',
    "run/main.c": "int Side(void);\nint main(void)\n{\n  return Side();\n}\n",
}
BAD = {  # name: (files that are different, expected faults as patterns)
    "nothing": ({}, []),
    "a climb by include": ({"base/more.c": '#include "base/low.h"\n  # include  "options/high.h"\n'}, [r"src/base/more\.c:2 includes options/high\.h: of a later room"]),
    "a climb by a symbol": ({"base/more.c": "int High(void);\nint First(void)\n{\n  return 1;\n}\nint More(void)\n{\n  return High() + 1;\n}\n"},
                            [r"src/base/more\.c uses src/options/high\.c of a later room: More uses High"]),
    "a climb of a static function": ({"base/more.c": "int High(void);\nstatic __attribute__((noinline)) int Hidden(int n)\n{\n  return n * High();\n}\nint More(int n)\n{\n  return Hidden(n) + 1;\n}\n"},
                                     [r"src/base/more\.c uses src/options/high\.c of a later room: Hidden uses High"]),
    "a climb by a table": ({"base/more.c": "int High(void);\nint (*const Functions[])(void) = {0, High};\n"},
                           [r"src/base/more\.c uses src/options/high\.c of a later room: Functions uses High"]),
    "a climb by data": ({"base/more.c": "extern int (*const Table[])(void);\nint More(void)\n{\n  return Table[1]();\n}\n"},
                        [r"src/base/more\.c uses src/options/high\.c of a later room: More uses Table"]),
    "a circle": ({"options/high.c": '#include "options/high.h"\nint Side(void);\nint High(void)\n{\n  return Low() ? Side() : 0;\n}\n'},
                 [r"a circle of 2 files: options/high\.c options/side\.c\n  options/high\.c -> options/side\.c: High uses Side\n  options/side\.c -> options/high\.c: Side uses High"]),
    "a circle of three": ({"options/high.c": '#include "options/high.h"\nint Third(void);\nint High(void)\n{\n  return Low() ? Third() : 0;\n}\n',
                           "options/third.c": "int Side(void);\nint Third(void)\n{\n  return Side() + 1;\n}\n"},
                          [r"(?s)a circle of 3 files: options/high\.c options/side\.c options/third\.c\n.*High uses Third.*Side uses High.*Third uses Side"]),
    "a source that is too long": ({"base/low.c": GOOD["base/low.c"] + "\n" * 450}, [r"src/base/low\.c: 456 lines, 450 at most"]),
    "a header that is too long": ({"base/low.h": GOOD["base/low.h"] + "\n" * 250}, [r"src/base/low\.h: 251 lines, 250 at most"]),
    "files of just the length": ({"base/low.h": GOOD["base/low.h"] + "\n" * 249, "base/low.c": GOOD["base/low.c"] + "\n" * 444}, []),
    "an include without a room": ({"options/high.h": '#include "../base/low.h"\nint High(void);\n'}, [r"src/options/high\.h:1 includes \.\./base/low\.h: not by the name"]),
    "an include around a room": ({"options/high.h": '#include "options/../base/low.h"\nint High(void);\n'}, [r"src/options/high\.h:1 includes options/\.\./base/low\.h: not by the name"]),
    "a file outside": ({"stray.h": "\n"}, [r"src/stray\.h: not src/ROOM/name"]),
    "a room without files": ({"run/main.c": None}, [r"src/run has no files"]),
    "a source without an object": ({"base/more.c": "#error not compiled\n"}, [r"src/base/more\.c: no object in "]),
}


def self_test():
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    for name, (other, expected) in BAD.items():
        folder = check.folder(name.replace(" ", "_"))
        files = {path: text for path, text in {**GOOD, **other}.items() if text is not None}
        for path, text in files.items():
            for place in ("src", "build"):
                os.makedirs(os.path.dirname(f"{folder}/{place}/{path}"), exist_ok=True)
            check.write(f"{folder}/src/{path}", text)
        for path in files:
            if path.endswith(".c") and "#error" not in files[path]:
                target = f"{folder}/build/{path[:-2]}.o".replace("high.o", "high.8.o")  # one with lanes
                done = subprocess.run([compiler, "-O2", "-c", f"-I{folder}/src", f"{folder}/src/{path}", "-o", target], capture_output=True, text=True)
                check.need(done.returncode == 0, done.stderr[:500])
        found = faults_of(f"{folder}/src", f"{folder}/build", ["base", "options", "run"])
        right = len(found) == len(expected) and all(re.match(pattern, fault) for pattern, fault in zip(expected, found))
        check.that(right, f"{name}: {found or 'no faults'}")


(word,) = check.arguments(__doc__, 1)
if word == "--self-test":
    self_test()
else:
    for wrong in faults_of(os.path.join(check.source, "src"), word, ROOMS):
        check.fault(wrong)
    guide = check.content(os.path.join(check.source, "docs", "developer.md")).decode().partition("## The rooms")[2]
    drawn = [match[1] for match in re.finditer(r"^    (\w+) +\S", guide.partition("\n`physics`")[0], re.M)]
    check.that(drawn[::-1] == ROOMS, f"docs/developer.md has the rooms {' '.join(drawn)}, from above")
check.end()
