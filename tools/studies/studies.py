#!/usr/bin/env python3
"""Renders the tables and figures of docs/choosing.md and docs/choosing-data.md from the data of docs/data: `make studies`.

A table stands between the lines <!-- table NAME --> and <!-- end -->. tables.py makes it, or the function table() of the
module of its name in this folder, or it is the file docs/data/NAME.csv as it is. `make studies STUDIES=missing` measures
first what docs/data lacks, for example of a new method; `STUDIES=all` measures everything anew, in output/studies/data, and
takes its place when it is complete. Both go on where they were stopped. With --check nothing is written: exit status 1 if a
document is not what the data say.
"""
import argparse
import importlib
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
sys.path[:0] = [os.path.join(ROOT, "tools"), HERE]
import marks  # noqa: E402 (after the path)
import tables  # noqa: E402

DOCUMENTS = ["choosing.md", "choosing-data.md"]
# What measures, in sequence, and the files that it writes: each goes on where it was stopped. Times of a step last, alone.
MEASURES = [(["run.py"], "choosing.csv"), (["run.py", "--varied"], "choosing.csv"), (["run.py", "--motion"], "motion.csv"), (["run.py", "--cost"], "method_cost.csv"),
            (["solid.py"], "solid.csv"), (["stability.py"], "stability.csv"), (["minimality.py"], "minimality.csv")]
MEASURES = [(words, name) for words, name in MEASURES if os.path.exists(os.path.join(HERE, words[0]))]


def table(name, results):
    if name in tables.TABLES:
        return tables.TABLES[name](results)
    if os.path.exists(os.path.join(HERE, name + ".py")):
        return importlib.import_module(name).table(results)
    rows = tables.read(os.path.join(tables.DATA, name + ".csv"))
    if not rows:
        raise FileNotFoundError(f"no function of tables.py and no file docs/data/{name}.csv for the table {name}")
    return marks.markdown(list(rows[0]), [row.values() for row in rows])


def render(text, results):
    for name in marks.names(text):
        text = marks.renew(text, name, table(name, results))
    return text


def measure(pebble, jobs, anew):
    subprocess.run([sys.executable, os.path.join(HERE, "reference_pressure.py")], check=True)
    folder = os.path.join(ROOT, "output", "studies", "data") if anew else tables.DATA
    for words, _ in MEASURES:
        print("measuring:", *words, flush=True)
        subprocess.run([sys.executable, os.path.join(HERE, words[0]), *words[1:], "--pebble", pebble, "--jobs", jobs, "--data", folder], check=True)
    if anew:
        for name in dict.fromkeys(name for _, name in MEASURES):
            shutil.copy(os.path.join(folder, name), tables.DATA)
        shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--measure", choices=("missing", "all"), help="measure first: what docs/data lacks, or everything anew")
    parser.add_argument("--check", action="store_true", help="write nothing; exit status 1 if something would change")
    parser.add_argument("--jobs", default="2", help="runs at a time, of those whose time does not count")
    arguments = parser.parse_args()
    if arguments.measure:
        measure(os.path.abspath(arguments.pebble), arguments.jobs, arguments.measure == "all")
    results, changed = tables.Results(), []
    for document in DOCUMENTS:
        path = os.path.join(ROOT, "docs", document)
        if not os.path.exists(path):
            continue
        with open(path) as file:
            old = file.read()
        new = render(old, results)
        if new != old:
            changed.append(document)
            if not arguments.check:
                with open(path, "w") as file:
                    file.write(new)
    print("\n".join(f"docs/{document} {'is not what the data say' if arguments.check else 'renewed'}" for document in changed) or "the documents are what the data say")
    if arguments.check:
        sys.exit(1 if changed else 0)
    import figures  # it needs matplotlib
    figures.draw(results)


if __name__ == "__main__":
    main()
