"""docs/faq.md: each message that it quotes is one of the program's, and each warning of the program has its row there.

usage: test_faq.py PEBBLE SOURCE MPIEXEC

A quotation is a code span between quotation marks, "`left the grid, to ...`". Its parts between `...` must stand in one
text of the source, in this order; a part has no conversion such as %g in it.
"""
import ast
import pathlib
import re

import check
import messages

QUOTE = re.compile(r'"`([^`]+)`"')
FEWEST = 100  # quotations; fewer mean that QUOTE no longer finds them


def spoken(text):
    """A text of the source as it is printed, with \\0 for each conversion."""
    text = messages.CONVERSION.sub(lambda found: "%" if found[0] == "%%" else "\0", text.replace("%\0", "\0"))
    return re.sub(r"\s+", " ", re.sub(r"\\(.)", r"\1", re.sub(r"\\[nr]", " ", text)))


def known(quote, texts):
    parts = [re.escape(part.strip()) for part in quote.split("...") if part.strip()]
    return any(re.search(".*?".join(parts), text, re.S) for text in texts)


def strings(path):
    """The texts of a Python file, with \\0 for what stands in braces."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield "".join(part.value if isinstance(part, ast.Constant) else "\0" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def quotations():
    faq = re.sub(r"\s+", " ", check.content(f"{check.source}/docs/faq.md").decode())
    said = [text for path in sorted(pathlib.Path(check.source).glob("src/*/*.c")) for _, text in messages.texts(path)]
    said += [text for path in sorted(pathlib.Path(check.source).glob("lab/**/*.py")) for text in strings(path)]
    texts, quotes = [spoken(text) for text in said], QUOTE.findall(faq)
    unknown = [quote for quote in quotes if not known(quote, texts)]
    check.that(not unknown and len(quotes) >= FEWEST, f"{len(quotes)} quotations, not in the source: {unknown}")
    short = [quote for quote in quotes if not re.search(r"\w\w+\W+\w\w+", quote)]
    check.that(not short, f"quotations of a single word: {short}")
    changed = [quote for quote in quotes if known(re.sub(r"(\w)(\W*)$", r"\1q\2", quote), texts)]
    check.that(not changed, f"of {len(quotes)} quotations with one letter more the source has: {changed}")
    warnings = [text for text in texts if text.startswith("warning ") and len(text.replace("\0", "")) > 24]
    untold = [text.replace("\0", "...") for text in warnings if not any(known(quote, [text]) for quote in quotes)]
    check.that(not untold and len(warnings) > 30, f"{len(warnings)} warnings, not in docs/faq.md: {untold}")


if __name__ == "__main__":
    check.arguments(__doc__, 0)
    quotations()
    check.end()
