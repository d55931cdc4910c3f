"""What docs/faq.md advises helps: each row of remedies.txt is a run that shows the trouble, and one with the remedy, that does not.

usage: test_remedies.py PEBBLE SOURCE MPIEXEC some|all

some: of the rows that are run each fourth

Each entry of docs/faq.md (a row of a table, an item of a list, a paragraph that names an option) has a row of remedies.txt, which
quotes it, and each option that an entry names in what it advises occurs in one of its rows. Advice of other documents may have rows too.
"""
import glob
import os
import re
import shlex

import numpy as np

import check
import pebble_mpm
from plain import SCENES, changed, rows

ALL = check.arguments(__doc__, 1) == ["all"]
QUOTE = re.compile(r'"`([^`]+)`"')
OPTION = re.compile(r"`(-[a-z][\w<>]*)")
RUN, TEST, NONE = "run", "in", "none"


def plain(text):
    return " ".join(text.split())


def entries(name):
    """(what it says, what it advises) of each entry of a document."""
    for block in re.split(r"\n(?=[*|#]|\d+\. |\n)", check.content(os.path.join(check.source, name)).decode()):
        block = plain(block)
        cells = re.split(r" (?<!\\)\| ", block.strip("| ")) if block.startswith("|") else [block]
        if not block or block[0] == "#" or re.match(r"[| -]+$|\* \[", block) or cells[-1] in ("what to do", "remedy", "probably meant", "what it means, and what to do"):
            continue
        if block[0] in "|*" or re.match(r"\d+\. ", block) or OPTION.search(block):
            yield block, cells[-1]


def words_of(given, more):
    """The command line of a scene of plain.py, or of options/, with options that replace its own."""
    scene, *first = shlex.split(given)
    words = first + more
    n = next((int(word[2:]) for word in reversed(words) if word.startswith("n=")), 1)
    words = [word for word in words if not word.startswith("n=")]
    if scene in SCENES:
        return n, [word for key, value in changed(shlex.join([scene, *words])).items() for word in ("-" + key, str(value))]
    return n, ["-options_file", check.scene(scene), *words]


def run(folder, given, more, dry):
    n, words = words_of(given, more)
    quiet = ["-dry_run"] if dry else ["-report_indicator", "false"]
    words = quiet + [part for key, value in (("-output_dir", folder), ("-output_name", "run"), *([] if dry else [("-output_format", "none")])) if key not in words for part in (key, value)] + words
    return check.pebble(*words, n=n)


def judge(case):
    """What is wrong with a row that is run, or None."""
    number, (quote, kind, trouble, message, *remedies), said = case
    dry = kind == "dry"
    patterns = [] if message == "-" else [message] if message != "*" else [".*?".join(re.escape(part.strip()) for part in one.split("...")) for one in QUOTE.findall(said)]
    first, second = f"out{number}", f"again{number}"
    before = run(first, trouble, [], dry)
    if patterns and not any(re.search(pattern, before.said, re.M) for pattern in patterns):
        return f"{quote}: {trouble}: not printed: {patterns}\n{before.said[-1500:]}"
    for remedy in remedies:
        remedy, _, wanted = remedy.partition(" => ")
        after = run(second, trouble, shlex.split(remedy), dry)
        found = next((found[0] for pattern in patterns if (found := re.search(pattern, after.said, re.M))), None)
        if wanted.startswith("{") and not after.status:
            a, b = (check.history(f"{folder}/run.csv") for folder in (first, second))
            right = eval(wanted[1:-1], {"a": a, "b": b, "np": np, "told": lambda pattern: [float(re.search(pattern, said, re.M)[1]) for said in (before.out, after.out)]})
        else:
            right = (wanted or patterns) and re.search(wanted, after.said, re.M)
        if after.status or found or not right:
            return f"{quote}: {trouble}, with {remedy}: exit status {after.status} {after.err.strip()}, {found or wanted}\n{after.out[-1000:]}"
    return None


def elsewhere(row):
    """What is wrong with a row that names another test, or None."""
    quote, _, name, words = row
    path = os.path.join(check.source, "tests", name)
    if not os.path.exists(path):
        return f"{quote}: there is no tests/{name}"
    text = check.content(path).decode()
    lost = [word for word in words.split(" ; ") if word not in text]
    return f"{quote}: not in tests/{name}: {lost}" if lost else None


def tell(what, told, pattern, status=0):
    check.that(told.status == status and bool(re.search(pattern, told.said)), f"{what}: {told.status} {pattern if told.status == status and re.search(pattern, told.said) else told.said[-800:]}")


def restarts():
    """What is advised where a run goes on, or files are missing."""
    def bar(folder, *words):
        return check.pebble("-options_file", check.scene("bar"), "-report_indicator", "false", "-output_dir", folder, *words)

    def again(*words):
        return bar("kept", "-time_end", "0.4", "-restart_file", "latest", *words)
    tell("a run without checkpoints", bar("none", "-time_end", "0.1"), "done")
    tell("leaves none", bar("none", "-restart_file", "latest"), "there is no checkpoint", 2)
    tell("with -checkpoint_every", bar("kept", "-time_end", "0.3", "-checkpoint_every", "0.1"), "checkpoint step")
    tell("or -checkpoint_wall there is one", bar("wall", "-time_end", "4", "-checkpoint_wall", "0.01", "-output_format", "none"), "checkpoint step")
    tell("but not in another -output_dir", bar("none", "-restart_file", "latest"), "there is no checkpoint", 2)
    tell("nor of another -output_name", again("-output_name", "other"), "there is no checkpoint", 2)
    first = again()
    tell("with it the run goes on", first, "restart +from step")
    check.that("is of an earlier run" not in first.out and "begins with this restart" not in first.out, "and nothing is missing")
    moved = os.path.join(check.folder("moved"), "all")
    os.rename("kept", moved)
    steps = pebble_mpm.load(f"{moved}/bar").snapshots
    check.that(len(steps) > 3 and steps[-1].particles.x.shape[0] > 8, "results that are moved as a whole are read")
    os.rename(moved, "kept")
    os.rename("kept/bar.csv", "bar.csv")
    tell("a history that is gone", again("-time_end", "0.5"), "the history begins with this restart")
    os.rename("kept/bar.snapshots", "bar.snapshots")
    tell("snapshots that are gone", again("-time_end", "0.6", "-checkpoint_every", "0.1"), "the results go on without them")
    last = max(glob.glob("kept/bar-checkpoint-*.h5"), key=lambda path: int(re.search(r"-(\d+)\.h5", path)[1]))
    with open(last, "r+b") as file:
        file.truncate(os.path.getsize(last) - 9)
    tell("a checkpoint that is cut off", bar("kept", "-time_end", "0.6", "-restart_file", last), "it is damaged or cut off: its checksum is wrong", 2)
    tell("latest takes the one before", again("-time_end", "0.6"), "going on from the one before")
    soil = [word for key, value in {**changed("soil -grid_h 2.5,2.5 -time_end 0.02"), "output_dir": "soil", "checkpoint_every": 0.01}.items() for word in ("-" + key, str(value))]
    go = ["-time_end", "0.03", "-restart_file", "latest", "-output_fields", "velocity,plastic_strain"]
    check.must(*soil, "-output_fields", "velocity")
    tell("a field that was not carried", check.pebble(*soil, *go), "its particles have no ep", 3)
    check.must(*soil, "-output_fields", "velocity,plastic_strain")
    tell("and one that was", check.pebble(*soil, *go), "restart +from")
    tell("a run that begins anew", bar("kept", "-time_end", "0.1"), "is of an earlier run: -restart_file latest goes on from it")


def bars(name, *ends):
    """An STL file of boxes, 0.2 x 0.2, each from an x to another."""
    lines = ["solid s"]
    for first, last in ends:
        corners = [(x, y, z) for x in (first, last) for y in (0.4, 0.6) for z in (0.4, 0.6)]
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            for facet in ((a, b, c), (a, c, d)):
                lines += ["facet normal 0 0 0", "outer loop", *("vertex {:g} {:g} {:g}".format(*corners[k]) for k in facet), "endloop", "endfacet"]
    check.write(name, [*lines, "endsolid s"])


def main():
    table, used, jobs = list(rows("remedies.txt")), set(), []
    check.write("foreign.csv", "not of Pebble\n")
    places = [(x, y) for x in np.arange(0.2, 0.3, 0.0125).tolist() for y in np.arange(0.45, 0.55, 0.0125).tolist()]
    for name, volume, points in (("once", 0.0125**2, places), ("twice", 0.0125**2, places * 2), ("large", 1, places), ("small", 1e-10, places)):
        check.write(name + ".csv", ["x,y,volume", *(f"{x!r},{y!r},{volume!r}" for x, y in points)])
    check.write("bare.csv", ["x,y", *(f"{x!r},{y!r}" for x, y in places)])
    bars("overlap.stl", (0.2, 0.5), (0.4, 0.7))
    bars("united.stl", (0.2, 0.7))
    for said, advised in entries("docs/faq.md"):
        found = [row for row in table if row[0] in said]
        used |= {row[0] for row in found}
        text = " ".join(" ".join(row[2:]) for row in found)
        lost = [option for option in OPTION.findall(advised) if not re.search(re.sub(r"<\w>", r"\\w+", option) + r"(?!\w)", text)]
        check.fault(f"docs/faq.md: no row of remedies.txt quotes: {said}" if not found else f"docs/faq.md: no row has {' '.join(lost)} of: {said}" if lost else None)
        jobs += [(len(jobs) + k, row, said) for k, row in enumerate(found)]
    others = " ".join(plain(check.content(path).decode()) for path in [f"{check.source}/README.md", *glob.glob(f"{check.source}/docs/*.md")])
    found = [row for row in table if row[0] not in used and row[0] in others]
    used |= {row[0] for row in found}
    jobs += [(len(jobs) + k, row, row[0]) for k, row in enumerate(found)]
    for row in table:
        check.fault(None if row[0] in used else f"remedies.txt: in no document: {row[0]}")
        check.fault(elsewhere(row) if row[1] == TEST else None)
    wrong = check.at_once(judge, [job for job in jobs if job[1][1] in ("dry", RUN)][::1 if ALL else 4])
    for one in wrong:
        check.fault(one)
    restarts()
    check.that(len(wrong) >= (90 if ALL else 20), f"{len(wrong)} remedies were run, {sum(row[1] == NONE for row in table)} have no run")
    check.end()


main()
