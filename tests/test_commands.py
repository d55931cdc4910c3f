"""The documents are true: every command in a block of README.md, the other *.md beside it and docs/*.md is run in a copy of the
project's folder, in the sequence of the document, and prints what the document shows.

usage: test_commands.py PEBBLE SOURCE MPIEXEC PART [--write]

PART     names      without running anything but -help: each command is one that is run or one of NOT_RUN, and what all commands
                    and words in backticks name is there: make targets, scripts, scenes, options
         a document README or tutorial, say: its commands are run
         others     those of all documents but README and tutorial
--write  the documents get what the commands print now; docs/tutorial-*.png are drawn anew

A block is what stands between ``` and ```, or is indented by four blanks:

* After "... file `NAME`:" it is that file, and is written.
* If its first line is a command (COMMAND), all its lines are. If that line begins with $, those that do are commands, and the
  others what the command before them prints; nothing is compared if there are none. A line `...` stands for any lines, and
  `$ echo $?` shows the exit status of the command before it. A command that is not followed by that has to end with 0.
* ```python without a file name is a program, which has to end with 0.
* Other blocks are text.

Printed numbers have to be the same digit by digit, but for what VARIES lists: times, speeds, memory, and what depends on the
processor.
"""
import glob
import os
import re
import shlex
import shutil
import sys

import check
import mpi

PROGRAMS = r"\./pebble(?:-study)?|mpicc|(?:\.venv/bin/)?python3?|mpiexec|make|mkdir|cp|ctest|valgrind|module|srun|sbatch|smpirun|pvpython|(?:build|tools)/\S+"
COMMAND = re.compile(rf"\$ |(?:[A-Z_]+=\S+ )*(?:{PROGRAMS})(?: |$)")
HIDDEN = re.compile(r"\$ |\./pebble(?:-study)? |mpiexec |make [a-z]+$")  # in a block that does not begin with a command
FILE = re.compile(r"file `([\w.-]+)`[^`]*:$")

# What pvpython needs in front of it here; None: it is missing, or there is no screen, not even a false one.
SCREEN = "" if os.environ.get("DISPLAY") else "xvfb-run -a " if shutil.which("xvfb-run") else None
SCREEN = SCREEN if shutil.which("pvpython") else None

# Commands that are not run here, and why. What they name has to exist all the same.
NOT_RUN = [
    (r"make (run|test|format)\b|mkdir -p build/commands", "they run the tests, this one, or change the sources"),
    (r"make PETSC_DIR", "needs another PETSc"),
    (r"make DEBUG=1", "a minute of compiling; `make debug` does it"),
    (r"make calibrate", "the test `model` runs it"),
    (r"(\S+ |mpiexec -n \d+ )?build/", "programs beside ./pebble: the tests that need them build and run them"),
    (r"make bench", "eleven minutes to an hour, on two free cores"),
    (r"make paper", "minutes"),
    (r"(make|NP=\d+ make) (simulate|scaling|report)", "minutes to hours; the first needs another PETSc"),
    (r"(module|srun|sbatch) ", "needs a cluster"),
    (r"mpiexec -n \d+ --bind-to", "needs a machine with that many cores"),
    (r"mpiexec --oversubscribe -n 32", "32 processes with millions of particles"),
    (r"GLIBC_TUNABLES=|.* \[-name value \.\.\.\]$", "a sketch: ... stands for a scene or for options"),
    (r"ctest --test-dir", "a test cannot run the tests"),
    *([(r"pvpython ", "needs ParaView and a screen")] if SCREEN is None else []),
]
# What differs from run to run, or from machine to machine: of a printed line, what is left of it (None: nothing), and why.
VARIES = [
    (r"^(phase|  [A-Z_0-9]+|  (other|all|phase)|output|speed|memory)\b.* .*", None, "measured times and memory"),
    (r"^model .*", None, "whether there is a calibration"),
    (r"^note .*\b(cores|processes take turns)\b.*", None, "said on machines with few cores only"),
    (r"^predict +after .*", None, "by measured times"),
    (r"^(predict +\d+ steps).*", r"\1", "the predicted time"),
    (r"^(done .*), in .*", r"\1", "the measured time"),
    (r"^(checkpoint .*), .* to write.*", r"\1", "the measured time"),
    (r"^(files .*); the disk .*", r"\1", "the room on the disk"),
    (r"^(kernels .*), \d lanes$", r"\1", "the width of the processor's vectors"),
    (r"^(output/\S+)\.(?:gif|mp4)( .*? s)\b.*", r"\1\2", "GIF where there is no ffmpeg"),
    (r"^(  *\d+ .*) +[\d.e+-]+$", r"\1", "the seconds at the end of a row of a study"),
]
# What a document takes for granted: commands before its first one.
BEFORE = {"scenes": "sed /damping_time/d options/slope.opts >my.opts"}  # a scene of the reader's, which has to settle
SOLVERS = ("snes_", "ksp_", "pc_", "mg_", "mat_")  # options of PETSc's solvers begin so, of which -help petsc lists none
OTHER_OPTIONS = ("reference.md", "report.md", "petsc.md", "CHANGELOG.md")  # made by programs; options of PETSc, and of earlier versions
MISSPELT = {"body_disk_raduis"}  # on purpose


class Block:
    """A block of a document: kind (file, commands, python or text), name of the file, and lines: (number in the document, text)."""

    def __init__(self, lines, language, before):
        indent = min((len(text) - len(text.lstrip()) for _, text in lines if text.strip()), default=0)
        self.indent, self.lines = indent, [(number, text[indent:]) for number, text in lines]
        name = FILE.search(before)
        self.name = name and name[1]
        first = self.lines[0][1] if self.lines else ""
        self.kind = "file" if name else "commands" if COMMAND.match(first) else "python" if language == "python" else "text"

    @property
    def text(self):
        return "".join(text + "\n" for _, text in self.lines)


def blocks(text):
    """The blocks of a document."""
    found, lines, paragraph = [], [], []  # paragraph: the words before a block
    language = None  # of a block between ```; None outside of one
    empty = True  # whether the line before is

    def close(language):
        while lines and not lines[-1][1].strip():
            lines.pop()
        if lines:
            found.append(Block(list(lines), language, " ".join(paragraph)))
            lines.clear()
            paragraph.clear()

    for number, line in enumerate(text.split("\n")):
        if language is None and line.lstrip().startswith("```"):
            close("")
            language = line.strip()[3:]
        elif language is not None and line.strip() == "```":
            close(language)
            language = None
        elif language is not None or line.startswith("    ") and (lines or empty) or lines and not line.strip():
            lines.append((number, line))
        else:
            close("")
            if empty and line.strip():
                paragraph.clear()
            paragraph += line.split()
        empty = not line.strip()
    close("")
    return found


def commands(block):
    """(number of its first line, command, its printed lines as (number, text)) of a block. Lines that end in \\ go on."""
    found, dollars, goes_on = [], block.lines[0][1].startswith("$ "), False
    for number, line in block.lines:
        if goes_on:
            found[-1][1] += "\n" + line
        elif not dollars or line.startswith("$ "):
            if not line.strip():
                continue
            found.append([number, line.removeprefix("$ "), []])
        else:
            found[-1][2].append((number, line))
            continue
        goes_on = line.endswith("\\")
    return found


def why_not(command):
    """Why a command is not run; None if it is."""
    return next((why for pattern, why in NOT_RUN if re.match(pattern, command)), None)


# ---- Comparison

def lasting(line):
    """What of a printed line is the same in every run; None if nothing is."""
    for pattern, left, _ in VARIES:
        if re.match(pattern, line):
            return left and re.sub(pattern, left, line)
    return line.rstrip()


def agree(shown, printed):
    """None if the printed lines are those shown, else what is wrong."""
    shown = [line.strip() if line.strip() == "..." else lasting(line) for line in shown]
    shown = [line for line in shown if line is not None]
    printed = [line for line in map(lasting, printed) if line is not None]
    at, free = 0, False
    for k, line in enumerate(shown):
        if line == "...":
            free = True
            continue
        ahead = printed[at:] if free else printed[at:at + 1]
        if line not in ahead:
            return f"not printed: {line}" + ("" if free else f"\n     but: {ahead[0] if ahead else 'nothing'}")
        at, free = at + ahead.index(line) + 1, False
    if at < len(printed) and not free:
        return f"printed, but not shown: {printed[at]}"
    return None


def renewed(shown, printed):
    """The lines shown, with what is printed now. Where lines are left out, a line is found by its first word; where they agree the
    old ones stay."""
    old = {lasting(line): line for line in shown}
    now = [old.get(lasting(line), line) if lasting(line) is not None else line for line in printed]
    if not any(line.strip() == "..." for line in shown):
        return now
    lines, at = [], 0
    for line in shown:
        if line.strip() != "..." and lasting(line) is not None:
            word = line.split()[0]
            at = next((k for k in range(at, len(now)) if now[k].split()[:1] == [word]), None)
            check.need(at is not None, f"no printed line begins with {word}: edit this block by hand")
            line, at = now[at], at + 1
        lines.append(line)
    return lines


# ---- Running

def copy():
    """A folder in which the documents' commands can be run: the program, the tools and the scenes, and an empty output/."""
    folder = check.folder("copy")
    for name in (".venv", "tools", "lab", "pebble-study", "options", "docs", "src", "examples", "tests", "makefile"):
        os.symlink(os.path.join(check.source, name), os.path.join(folder, name))
    os.symlink(check.program, os.path.join(folder, "pebble"))
    os.mkdir(os.path.join(folder, "output"))
    return folder


def run(command, folder):
    """Exit status and printed lines of a command; standard error last."""
    where = os.path.dirname(check.mpiexec)
    env = {"PATH": f"{where}:{os.environ['PATH']}"} if where else {}
    env |= {"MPLCONFIGDIR": os.path.join(check.source, ".venv", "matplotlib")}
    command = SCREEN + command if command.startswith("pvpython ") else command
    status, out, err = mpi.run(1, ["bash", "-c", command], timeout=600, plain="mpiexec" in command, cwd=folder, env=env)
    return status, out.rstrip("\n").split("\n") * bool(out.strip()) + mpi.own_lines(err)


def ends(status, what, printed):
    """Checks the status with which a command ended."""
    check.that(status == 0, what if status == 0 else f"{what} ends with {status}" + "".join(f"\n     {line}" for line in printed[-3:]))


def follow(name, write):
    """Follows a document; with write it is renewed. Returns how many commands were run."""
    path = next(path for path in documents() if os.path.basename(path) == name + ".md")
    text, folder, changes, count = check.content(path).decode(), copy(), [], 0
    check.need(run(BEFORE.get(name, "true"), folder)[0] == 0, f"{name}: {BEFORE.get(name)}")
    for block in blocks(text):
        if block.kind == "file":
            check.write(os.path.join(folder, block.name), block.text)
        elif block.kind == "python":
            check.write(os.path.join(folder, "block.py"), block.text)
            status, printed = run(".venv/bin/python block.py", folder)
            ends(status, f"{name}:{block.lines[0][0] + 1}: this program", printed)
            count += 1
        elif block.kind == "commands":
            todo, status = commands(block), 0
            for (number, command, output), following in zip(todo, todo[1:] + [(0, "", [])]):
                what = f"{name}:{number + 1}: {command}"
                if why_not(command):
                    continue
                if command == "echo $?":
                    printed = [str(status)]
                else:
                    status, printed = run(command, folder)
                    count += 1
                    ends(0 if following[1] == "echo $?" else status, what, printed)
                shown = [line for _, line in output]
                wrong = agree(shown, printed) if shown else None
                if wrong and write:
                    changes.append((output[0][0], output[-1][0] + 1, [" " * block.indent + line for line in renewed(shown, printed)]))
                else:
                    check.fault(f"{what}\n     {wrong}" if wrong else None)
    pictures(name, text, folder, write)
    lines = text.split("\n")
    for start, end, new in reversed(changes):
        lines[start:end] = new
    if changes:
        check.write(path, "\n".join(lines))
        print(f"     {len(changes)} blocks of {path} are new")
    return count


def pictures(name, text, folder, write):
    """Each picture of the tutorial is there, and drawn by one of its commands. (Others are made by make scenes, report and the like.)"""
    commands_of = {drawn[2]: drawn[1] for drawn in re.finditer(r"^\$ (\S*python tools/plot\.py output/([\w.-]+)\.h5.*)", text, re.M)}
    for picture, run_name in re.findall(r"\((tutorial-([\w-]+)\.png)\)", text):
        place = os.path.join(check.source, "docs", picture)
        if write and run_name in commands_of:
            run(f"{commands_of[run_name]} --small --out {place}", folder)
        check.that(run_name in commands_of and os.path.exists(place), f"{name}: {picture} is drawn by a command")


# ---- Names

def options_known():
    """Names of all options, with those of PETSc that pebble -help petsc lists, as patterns: <b> stands for any name."""
    said = check.must("-help").out + check.must("-help", "petsc").out
    names = set(re.findall(r"(?<![\w-])-([a-z]\w*(?:<\w>\w*)*)", said)) | {"options_file", "prefix_push", "prefix_pop"}
    return {name: re.compile(re.sub(r"<\w>", r"(?:<\\w+>|[a-z0-9]+)", name)) for name in names}


def strange(text, known):
    """Words that look like options of a scene (-two_words) but are none; -word_* stands for several."""
    lost = []
    for word in dict.fromkeys(re.findall(r"(?<![\w/.-])-([a-z]+_[\w<>]*\*?)", text)):
        if word.startswith(SOLVERS):
            continue
        if word.endswith(("*", "_")):
            found = any(name.startswith(word.rstrip("*_")) for name in known)
        else:
            own = re.sub(r"^stage_[a-z0-9]+_", "", word)  # any option may be of a stage
            found = word in MISSPELT or any(pattern.fullmatch(word) or pattern.fullmatch(own) for pattern in known.values())
        if not found:
            lost.append(word)
    return lost


def missing(command, targets):
    """What a command names that is not there: make targets, scripts, scenes."""
    words = shlex.split(command, comments=True) if command.count('"') % 2 == 0 and "'" not in command else command.split()
    lost = []
    if words[0] == "make":
        lost += [word for word in words[1:] if re.fullmatch(r"[a-z][a-z-]*", word) and word not in targets]
    for word in words:
        if re.match(r"(tools|options|tests|examples)/[\w./-]+$", word) and not os.path.exists(os.path.join(check.source, word)):
            lost.append(word)
    return lost


def labels():
    """The first words of the lines that a run or a study prints."""
    sources = [check.content(path).decode() for pattern in ("src/*/*.c", "lab/pebble_study/*.py") for path in glob.glob(os.path.join(check.source, pattern))]
    found = {label for source in sources for label in re.findall(r'"([a-z]+) {2,}', source)}
    return sorted(found - {"simulated"})  # of the program of `make simulate`, docs/cluster.md


def part_names():
    targets = set(re.findall(r"^([a-z-]+):", check.content(os.path.join(check.source, "makefile")).decode(), re.M))
    known, used, count = options_known(), set(), 0
    for path in documents():
        name, text = os.path.relpath(path, check.source), check.content(path).decode()
        for block in blocks(text):
            if block.kind == "commands":
                for number, command, _ in commands(block):
                    count += 1
                    used |= {pattern for pattern, _ in NOT_RUN if re.match(pattern, command)}
                    wrong = [f"there is no {word}" for word in missing(command, targets)]
                    if not block.lines[0][1].startswith("$ ") and not COMMAND.match(command):
                        wrong.append("this is no command")
                    check.fault(f"{name}:{number + 1}: {command}: {wrong}" if wrong else None)
            for number, line in block.lines if block.kind == "text" else ():
                check.fault(f"{name}:{number + 1}: a command below other lines: {line}" if HIDDEN.match(line) else None)
        for words in filter(COMMAND.match, re.findall(r"`([^`]+)`", text)):
            lost = missing(words, targets)
            check.fault(f"{name}: {words}: there is no {' '.join(lost)}" if lost else None)
        if not name.endswith(OTHER_OPTIONS):
            lost = strange(" ".join(re.findall(r"`([^`]+)`", text) + [block.text for block in blocks(text)]), known)
            check.fault(f"{name}: no options: {' '.join(lost)}" if lost else None)
    count_lines = len(check.content(documents()[0]).splitlines())
    check.that(count_lines <= 150, f"README.md has {count_lines} lines, at most 150")
    results = check.content(os.path.join(check.source, "docs", "results.md")).decode()
    lost = [label for label in labels() if f"`{label}`" not in results]
    check.that(not lost, f"docs/results.md explains each of the {len(labels())} lines that a run can print {' '.join(lost)}")
    unused = [pattern for pattern, _ in NOT_RUN if pattern not in used]
    check.that(not unused, f"each of the {len(NOT_RUN)} reasons not to run a command is needed {' '.join(unused)}")
    check.that(count > 50, f"{count} commands in {len(documents())} documents")
    self_test(known, targets)


def self_test(known, targets):
    """What is wrong is noticed."""
    found = strange("-grid_h -grid_g -bc_* -nosuch_* -body_disk_radius", known)
    check.that(found == ["grid_g", "nosuch_*"], "options that are not there are noticed")
    found = missing("make nosuch", targets) + missing("python tools/nosuch.py", targets)
    check.that(found == ["nosuch", "tools/nosuch.py"], "targets and scripts too")
    found = blocks("Text in a file `a.opts`:\n\n    -dim 2\n\n```console\n$ ./pebble -a \\\n  -b\nout 1\n...\n$ echo $?\n0\n```\n")
    check.that([block.kind for block in found] == ["file", "commands"] and found[0].text == "-dim 2\n", "blocks of a document are found")
    told = [(command, [line for _, line in output]) for _, command, output in commands(found[1])]
    check.that(told == [("./pebble -a \\\n  -b", ["out 1", "..."]), ("echo $?", ["0"])], "and their commands")
    printed = ["scene a", "done 3 steps, t=1 s, in 0.2 s", "speed 3", "digest 12"]
    check.that(agree(["scene a", "done 3 steps, t=1 s, in 9 s", "digest 12"], printed) is None, "times are not compared")
    check.that(agree(["...", "digest 12"], printed) is None and agree(["scene a", "..."], printed) is None, "lines may be left out")
    for wrong in (["scene a"], ["...", "digest 13"], ["scene a", "done 4 steps, t=1 s, in 0.2 s", "digest 12"],
                  ["...", "digest 12", "more"], ["digest 12"]):
        check.that(agree(wrong, printed), f"a difference is noticed: {wrong[-1]}")
    new = renewed(["...", "digest 13"], printed)
    check.that(new == ["...", "digest 12"] and renewed(["?"], printed) == printed, "and renewed")


def documents():
    """Paths of all documents, README.md first."""
    paths = [path for folder in ("", "docs") for path in glob.glob(os.path.join(check.source, folder, "*.md"))]
    return sorted(paths, key=lambda path: (os.path.dirname(path), not path.endswith("README.md"), path))


def main():
    part, *more = check.arguments(__doc__, None) or sys.exit(__doc__)
    write = more == ["--write"]
    if more and not write:
        sys.exit(__doc__)
    if part == "names":
        part_names()
    else:
        names = [os.path.splitext(os.path.basename(path))[0] for path in documents()]
        chosen = [name for name in names if name not in ("README", "tutorial")] if part == "others" else [part]
        check.need(set(chosen) <= set(names), f"no such document: {part}")
        count = sum(follow(name, write) for name in chosen)
        check.that(count, f"{count} commands were run")
    check.end()


main()
