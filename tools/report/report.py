#!/usr/bin/env python3
"""Makes the tables, numbers and figures of docs/report.md, docs/model.md and docs/performance.md from docs/data, and report.html and, where
Chromium is installed, report.pdf: `make report`. Nothing is measured. The text between the marks (tools/marks.py) is
written by hand; tables.py makes what is at the marks, and claims.py checks the sentences that compare numbers.

    report.py            documents and figures, after constants.py
    report.py --check    says what in the documents is not what the data say, and writes nothing (seconds)
"""

import argparse
import os
import re
import sys

import data

sys.path.insert(0, os.path.join(data.ROOT, "tools"))
import claims  # noqa: E402 (after the path)
import marks  # noqa: E402
import tables  # noqa: E402

DOCUMENTS = "report.md", "model.md", "performance.md"


def made(text, numbers):
    """The document as the data say it is."""
    for name in marks.names(text):
        text = marks.renew(text, name, getattr(tables, f"table_{name}")())
    return marks.numbers(text, lambda name: numbers[name])


def captions(text):
    """What is wrong with the numbers of tables and figures: each has a caption with the next number."""
    for what, place in (("Table", r"^\|(?:.*)\n\| ---"), ("Figure", r"^!\[")):
        found = [int(n) for n in re.findall(rf"^\*\*{what} (\d+)\.\*\*", text, re.M)]
        if found != list(range(1, len(re.findall(place, text, re.M)) + 1)):
            yield f"docs/report.md: the captions of the {what.lower()}s have the numbers {found}"


def faults(name, text, numbers):
    """What in a document is not what the data say."""
    new = made(text, numbers)
    for a, b in zip(text.splitlines(), new.splitlines()):
        if a != b:
            yield f"docs/{name} says {a!r}, the data {b!r}"
    if name == "report.md":
        yield from claims.wrong(text)
        yield from captions(text)


def read(name):
    with open(os.path.join(data.ROOT, "docs", name)) as f:
        return f.read()


def check():
    """What is wrong with the documents."""
    numbers = tables.numbers()
    return [fault for name in DOCUMENTS for fault in faults(name, read(name), numbers)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only say what is wrong")
    args = parser.parse_args()
    if not args.check:
        import figures

        docs, numbers = os.path.join(data.ROOT, "docs"), tables.numbers()
        for name in DOCUMENTS:
            text = made(read(name), numbers)
            with open(os.path.join(docs, name), "w") as f:
                f.write(text)
            print(f"  docs/{name}")
        figures.draw(docs)
        try:
            import page

            page.make(read("report.md"), docs, "report")
        except ModuleNotFoundError as missing:
            print(f"  no report.html: {missing}; `make report` installs it")
    wrong = check()
    for fault in wrong:
        print(f"report.py: {fault}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
