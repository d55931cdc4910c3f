#!/usr/bin/env python3
"""Makes the tables, numbers and figures of docs/report.md, model.md and performance.md from docs/data: `make report`.
Nothing is measured. The text between the marks (tools/marks.py) is written by hand; tables.py makes what is at the marks,
and claims.py checks the sentences that compare numbers."""

import os
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


def check():
    """What is wrong with the documents."""
    numbers = tables.numbers()
    return [fault for name in DOCUMENTS for fault in faults(name, read(name), numbers)]


def main():
    import figures

    texts = {name: made(read(name), tables.numbers()) for name in DOCUMENTS}
    for name, text in texts.items():
        with open(os.path.join(DOCS, name), "w") as f:
            f.write(text)
    figures.draw(DOCS)
    sys.exit("".join(f"report.py: {fault}\n" for fault in check()) or 0)


if __name__ == "__main__":
    main()
