"""The claims of docs/report.md: every sentence of it that compares two numbers is a row here, with the data that it
reads and a condition. `make report` fails where a row does not hold, or where its sentence is not in the text.

The rows are in claims_first.py and claims_results.py. A row is a function under @claim(sentence, data): it yields
comparisons (of what, number, relation, number), all of which must hold. In a sentence {name} stands for a number
that the text has as <!-- number name -->.
"""

import operator
import re

from data import Missing

RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq}
CLAIMS = {}
RUNS, SIMULATED = "docs/data/scaling/runs.csv", "docs/data/simulated/strong.csv"


def claim(sentence, data):
    def add(condition):
        CLAIMS[condition.__name__] = (" ".join(sentence.split()), data, condition)
        return condition

    return add


def plain(text):
    """The text in one line, with {name} for each number that is made."""
    return " ".join(re.sub(r"<!-- number (\w+) -->[^<\n]*<!-- end -->", r"{\1}", text).split())


def fault(name, report, text=None):
    """What is wrong with a claim, or None."""
    sentence, data, condition = CLAIMS[name]
    if text is not None and sentence not in text:
        return f"claim {name}: docs/report.md has no sentence {sentence!r}"
    number = 0
    for number, (what, a, relation, b) in enumerate(condition(report), 1):
        if not RELATIONS[relation](a, b):
            return (
                f"claim {name} does not hold ({data}): {what}: {a:.6g} {relation} {b:.6g} is false; the text says"
                f" {sentence!r}"
            )
    return None if number else f"claim {name} compares nothing ({data})"


def wrong(report, text=None):
    """What is wrong with the claims, a line each."""
    out, text = [], plain(text) if text is not None else None
    for name in CLAIMS:
        try:
            out.append(fault(name, report, text))
        except Missing as m:
            report.note(f"claim {name}", str(m))
    return [line for line in out if line]
