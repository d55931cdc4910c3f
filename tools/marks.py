"""Marked blocks of documents: what stands between the lines <!-- table NAME --> and <!-- end --> is made by a program."""

import re


def markdown(head, lines):
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def names(text):
    """The blocks of a document, in order."""
    return re.findall(r"^<!-- table (\w+) -->$", text, flags=re.M)


def renew(text, name, block):
    """The document with the block of that name replaced; ValueError unless it has exactly one."""
    found, count = re.subn(
        rf"(<!-- table {name} -->\n).*?(<!-- end -->)", lambda m: f"{m[1]}\n{block}\n\n{m[2]}", text, flags=re.S
    )
    if count != 1:
        raise ValueError(f"the document must have one table {name}, not {count}")
    return found
