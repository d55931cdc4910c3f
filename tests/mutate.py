"""Random changes of options files, for tests of what the program does with them."""
import re

LETTERS = "abcxyzABC0123456789.,-+_eE\"'# \t:/*()|=\\~$\x7f\xe9"
NUMBERS = ["-1", "0", "nan", "inf", "1e308", "1e-308", "1e9", "2147483648", "x", ""]


def mutate(rng, text):
    """One to three random changes of names, values and lines."""
    lines = text.splitlines()
    for _ in range(rng.randint(1, 3)):
        k = rng.choice([k for k, line in enumerate(lines) if line and not line.startswith("#")])
        line, at = lines[k], rng.randrange(len(lines[k]))
        what = rng.choice(["insert", "delete", "swap", "replace", "drop", "double", "join", "number"])
        if what == "insert":
            lines[k] = line[:at] + rng.choice(LETTERS) + line[at:]
        elif what == "delete":
            lines[k] = line[:at] + line[at + 1:]
        elif what == "swap":
            lines[k] = line[:at] + line[at + 1: at + 2] + line[at: at + 1] + line[at + 2:]
        elif what == "replace":
            lines[k] = line[:at] + rng.choice(LETTERS) + line[at + 1:]
        elif what == "drop":
            del lines[k]
        elif what == "double":
            lines.insert(rng.randrange(len(lines)), line)
        elif what == "join" and k + 1 < len(lines):
            lines[k: k + 2] = [line + " " + lines[k + 1]]
        elif what == "number":
            lines[k] = re.sub(r"\d+(\.\d+)?", rng.choice(NUMBERS), line, count=1)
    return "\n".join(lines) + "\n"
