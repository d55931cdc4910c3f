#!/usr/bin/env python3
"""Makes the tables, numbers and figures of docs/report.md, model.md and performance.md from docs/data, and report.html:
`make report`. Nothing is measured. The text between the marks (tools/marks.py) is written by hand; tables.py makes what
is at the marks, and claims.py checks the sentences that compare numbers. --check only says what is wrong (seconds)."""

import os
import re
import sys

import data

sys.path.insert(0, os.path.join(data.ROOT, "tools"))
import claims  # noqa: E402 (after the path)
import marks  # noqa: E402
import tables  # noqa: E402

DOCUMENTS = "report.md", "model.md", "performance.md"
DOCS = os.path.join(data.ROOT, "docs")


def read(name):
    with open(os.path.join(DOCS, name)) as f:
        return f.read()


def made(text, numbers):
    """The document as the data say it is."""
    for name in marks.names(text):
        text = marks.renew(text, name, getattr(tables, f"table_{name}")())
    return marks.numbers(text, lambda name: numbers[name])


def faults(name, text, numbers):
    """What in a document is not what the data say."""
    for a, b in zip(text.splitlines(), made(text, numbers).splitlines()):
        if a != b:
            yield f"docs/{name} says {a!r}, the data {b!r}"
    if name == "report.md":
        yield from claims.wrong(text)
        for what, place in (("Table", r"^\|(?:.*)\n\| ---"), ("Figure", r"^!\[")):
            found = [int(n) for n in re.findall(rf"^\*\*{what} (\d+)\.\*\*", text, re.M)]
            if found != list(range(1, len(re.findall(place, text, re.M)) + 1)):
                yield f"docs/report.md: the captions of the {what.lower()}s have the numbers {found}"


def check():
    """What is wrong with the documents."""
    numbers = tables.numbers()
    return [fault for name in DOCUMENTS for fault in faults(name, read(name), numbers)]


def main():
    if sys.argv[1:] != ["--check"]:
        import figures

        numbers = tables.numbers()
        for name in DOCUMENTS:
            text = made(read(name), numbers)
            with open(os.path.join(DOCS, name), "w") as f:
                f.write(text)
        figures.draw(DOCS)
        try:
            import page

            page.make(read("report.md"), os.path.join(DOCS, "report.html"))
        except ModuleNotFoundError as missing:
            print(f"  no report.html: {missing}; `make report` installs it")
    wrong = check()
    print("".join(f"report.py: {fault}\n" for fault in wrong), end="", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
