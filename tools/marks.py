"""Finds and renews the parts of documents that a program makes: tables between the lines <!-- table NAME --> and <!-- end -->,
and numbers in the text, <!-- number NAME -->3.14<!-- end -->."""

import re


def markdown(head, lines):
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def pivot(head, cells):
    """The table of {(beginning of its line ..., column): text}; lines and columns are in the sequence in which they come."""
    lines, columns = (dict.fromkeys(some) for some in zip(*((key[:-1], key[-1]) for key in cells)))
    return markdown([*head, *columns], [[*line, *(cells.get((*line, c), "") for c in columns)] for line in lines])


def names(text):
    """The names of the tables of a document, in sequence."""
    return re.findall(r"^<!-- table (\w+) -->$", text, flags=re.M)


def renew(text, name, block):
    """The document with the table of that name replaced by `block`; ValueError unless it has exactly one."""
    found, count = re.subn(
        rf"(<!-- table {name} -->\n).*?(<!-- end -->)", lambda m: f"{m[1]}\n{block}\n\n{m[2]}", text, flags=re.S
    )
    if count != 1:
        raise ValueError(f"the document must have one table {name}, not {count}")
    return found


NUMBER = r"(<!-- number (\w+) -->)([^<\n]*)(<!-- end -->)"


def numbers(text, make):
    """The document with each number replaced by make(NAME)."""
    if begins := re.search(r"^<!-- number (\w+)", text, flags=re.M):
        raise ValueError(f"the number {begins[1]} begins a line, which Markdown takes for the end of a paragraph")
    return re.sub(NUMBER, lambda m: m[1] + make(m[2]) + m[4], text)


def without(text):
    """The document without the marks of its numbers."""
    return re.sub(NUMBER, r"\3", text)
