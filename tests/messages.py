"""Every message of the program's own is printed by some test. `make test` keeps the lines that the runs of its tests print
(mpi.keep), and this script looks for each message of src among them.

usage: messages.py SOURCE SAID

SOURCE  root of the checkout
SAID    folder of what the tests' runs printed

A message is a text of at least two words in src/*/*.c; its conversions, such as %g, stand for anything. These are none:
texts of PetscCheck and its like, which tell of a defect, and those that NONE lists, with the reason.
"""
import pathlib
import re
import sys

DEFECTS = {"PetscCheck", "SETERRQ", "_Static_assert", "Stage"}
# Texts that are no message, or that no test of `make test` can print: a part of the text, and why.
NONE = {
    "needs a PETSc with HDF5": "PETSc has HDF5 where the tests run",
    "checkpoints need a PETSc with HDF5": "the same",
    "of them need %.3g GB": "a machine with more memory than PETSc's 32-bit integers can number",
    "nodes of the grid": "the same",
    "-output_name: cannot read": "the tests may run as root, who can read every folder",
    "max number of options": "a text of PETSc",
    "options are given, and this PETSc takes": "the newer PETSc takes as many as there is memory for",
    "PETSc does not start": "PETSc gives a text with each error",
    "found at position ": "ends of muParser's messages, which are cut off",
    "at expression position": "the same",
    " at position ": "the same",
    "DataItem": "a line of an .xdmf file, as are the next ones",
    "<Grid Name": "",
    "<Topology": "",
    "</Topology>": "",
    "<Attribute": "",
    "</Grid>": "",
    "more sums": "a name for PETSc",
    "more node sums": "a name for PETSc, where a scene has more sums than a line of a record has room for",
    "<?xml": "",
    "<Xdmf Version": "",
    "pebble checkpoint ": "the start of a checkpoint",
    "time and dt in s": "an attribute in a file of snapshots",
    "# constants of pebble's model": "a line of a model file",
    "# rate <part of the step>": "the same",
    "needs a period > 0": "the range of its option is checked before; unit_reference.c tests it",
    "needs a mode >= 1": "the same",
    "simulated  %.9g s a step": "the program that `make simulate` builds",
    "more than %d facets": "a file of 2.5 GB",
    "the results are complete up to here": "a PETSc without HDF5, so that no checkpoint is written",
    "it cannot be read": "a file of particles that vanishes between two readings of it",
    "eos fit": "the start of a list of options",
    "material ppc offset": "the same",
    "xx xy xz yx yy yz zx zy zz": "an attribute in a file of snapshots",
    "</Attribute>": "a line of an .xdmf file",
    "it has not been measured up to which time step": "every method has been; test_recipes.py adds others, whose runs it reads",
}
WORDS = re.compile(r"\b[A-Za-z]{2,}\b.* .*\b[A-Za-z]{2,}\b", re.S)
TOKEN = re.compile(r"""
    (?P<comment>/\*.*?\*/|//[^\n]*)
  | (?P<line>^\#(?!\s*(?:el)?if|\s*end|\s*else)(?:[^\n\\]|\\.)*)
  | (?P<text>"(?:[^"\\]|\\.)*")
  | (?P<char>'(?:[^'\\]|\\.)*')
  | (?P<name>[A-Za-z_]\w*)
  | (?P<mark>[^\s\w])""", re.X | re.S | re.M)
LABELS = {"MPMWarn": "warning    ", "MPMNote": "note       "}  # what these functions print before the first text that they get
CONVERSION = re.compile(r"%[-+ #0]*(?:\d+|\*)?(?:\.(?:\d+|\*))?(?:hh|h|ll|l|z)?[a-zA-Z]|%%")


def texts(path):
    """(line, text) of the messages of a file; \\0 stands where a macro such as PetscInt_FMT does."""
    code = path.read_text()
    calls, before, parts, begin, label = [], "", [], 0, ""
    for token in TOKEN.finditer(code):
        kind, what = token.lastgroup, token[0]
        if kind in ("comment", "line"):
            continue
        if kind == "text":
            if not parts:
                begin = code.count("\n", 0, token.start()) + 1
            parts.append(what[1:-1])
            continue
        if parts and kind == "name" and re.fullmatch(r"\w*_FMT|PRI\w+", what):
            parts.append("\0")
            continue
        if parts:
            if not DEFECTS.intersection(calls):
                yield begin, label + "".join(parts)
            parts, label = [], ""
        if what == "(":
            calls.append(before)
            label = LABELS.get(before, label)
        elif what == ")" and calls and calls.pop() in LABELS:
            label = ""
        before = what


def patterns(text):
    """(its longest part, pattern) of each line of a message."""
    text = CONVERSION.sub(lambda found: "%" if found[0] == "%%" else "\0", text.replace("%\0", "\0"))
    for line in re.split(r"\\[nr]", text.replace(r"\033[K", "")):
        parts = re.sub(r"\\(.)", r"\1", line).split("\0")
        yield max(parts, key=len), re.compile(".*?".join(map(re.escape, parts)))


def printed(text, said):
    """Is every line of a message in what was said?"""
    for part, pattern in patterns(text):
        at = said.find(part)
        while part and at >= 0:
            end = said.index("\n", at)
            if pattern.search(said, said.rfind("\n", 0, at) + 1, end):
                break
            at = said.find(part, end)
        if part and at < 0:
            return False
    return True


def main():
    source, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    said = {line for path in folder.glob("*") for line in path.read_text(errors="replace").splitlines()}
    said = "\n".join(["", *sorted(said), ""])
    missing = number = 0
    unused = set(NONE)
    for path in sorted(source.glob("src/*/*.c")):
        for line, text in texts(path):
            if not WORDS.search(CONVERSION.sub("", text)):
                continue
            none = {part for part in NONE if part in text}
            unused -= none
            if none:
                continue
            number += 1
            if not printed(text, said):
                missing += 1
                print(f"{path.relative_to(source)}:{line}: no test prints: " + text.replace("\0", ""))
    for part in sorted(unused):
        print(f"messages.py: no text of src has {part!r}, which NONE names")
    print(f"{number} messages, {missing} that no test prints")
    sys.exit(bool(missing or unused) or not number)


if __name__ == "__main__":
    main()
