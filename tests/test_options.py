"""Every row of a table that a user chooses from is reachable: -help lists its name among the values of its option, and its
parameters as options. -help <word> prints those lines that have the word. Formulas have just the functions that -help and
docs/reference.md list. And options files that name other files: which value counts, and that results overwrite none of
them.

usage: test_options.py PEBBLE SOURCE MPIEXEC
"""
import math
import os
import random
import re
import shutil

import check

# A table, the macro of its rows, the option that chooses one, and where the parameters of a row are options.
CHOICES = [
    ("physics/material.def", "MPM_MATERIAL", "material_<m>_model", "material_<m>_"),
    ("physics/region.def", "MPM_REGION", "body_<b>_shape", "body_<b>_"),
    ("physics/wall.def", "MPM_WALL", "bc_<f>_type", "bc_<f>_"),
    ("physics/basis.def", "MPM_BASIS", "method_basis", None),
    ("step/scheme.def", "MPM_SCHEME", "method_update", None),
    ("step/transfer.def", "MPM_TRANSFER", "method_transfer", None),
]


def table(path, macro):
    """Rows of a .def file: the text of each between its brackets."""
    with open(os.path.join(check.source, "src", path), encoding="utf-8") as file:
        text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
    return re.findall(rf"^{macro}\((.*)\)$", text, re.M)


def columns(row):
    """Name and columns of a row; commas in quotes do not part."""
    return [column.strip().strip('"') for column in re.findall(r'(?:"[^"]*"|[^,"])+', row)]


def values(text, option):
    """The values in brackets at the end of an option's line of -help."""
    line = re.search(rf"^  -{re.escape(option)} .*\(([^()]*)\)$", text, re.M)
    return re.split(r"[|,]", line[1].removeprefix("all, or a list of ")) if line else []


def vocabulary():
    text = check.must("-help").out
    options = set(re.findall(r"^  -([^\s:]+)", text, re.M))
    for path, macro, option, parameters in CHOICES:
        rows = [columns(row) for row in table(path, macro)]
        check.need(rows, f"no rows in {path}")
        named = values(text, option)
        check.that(sorted(row[0] for row in rows) == sorted(named), f"-{option} takes {' '.join(named)}, the rows of {path}")
        place = 1 if path.endswith("wall.def") else 2
        for row in rows if parameters else []:
            missing = [word for word in row[place].split() if parameters + word not in options]
            check.fault(f"{row[0]} of {path}: -help has no option of {missing}" if missing else None)
    ways = [row[0] for row in map(columns, table("parallel/exchange.def", "MPM_EXCHANGE")) if row[1] == "PETSC_TRUE"]
    check.that(sorted(ways) == sorted(values(text, "parallel_strategy")), f"-parallel_strategy takes {' '.join(ways)}")
    known = [columns(row) for row in table("known/reference.def", "MPM_REFERENCE")]
    for option, flag, more in (("mms_type", "PETSC_TRUE", []), ("reference_type", "PETSC_FALSE", ["expression"])):
        named = ["none"] + [row[0] for row in known if row[1] == flag] + more
        check.that(sorted(named) == sorted(values(text, option)), f"-{option} takes {' '.join(named)}")
    check.need(len(known) == len(values(text, "mms_type")) + len(values(text, "reference_type")) - 3,
               "a known solution is of neither kind")
    words = [row[2] for row in map(columns, table("results/diagnostics.def", "MPM_PARTICLE_QUANTITY")) if row[2]]
    check.that(sorted(words + ["grid"]) == sorted(values(text, "output_fields")), f"-output_fields takes {' '.join(words)} grid")


def groups_of(text):
    """{title: lines} of what -help prints below its head, with an empty line before each title."""
    found = {}
    for part in text.split("\n\n"):
        title, *lines = part.rstrip("\n").split("\n")
        if lines and not title.startswith("Pebble"):
            found[title] = lines
    return found


def matches(word, title, line):
    """Has a line of -help, or the name of its group, a word that begins so? One of one or two letters is whole."""
    end = r"(?![a-z0-9])" if len(word) < 3 else ""
    return re.search(rf"(?<![a-z0-9]){re.escape(word)}{end}", f"{title.partition(':')[0]}\n{line}", re.I)


def others_words():
    """(words, option or None, text) of the rows of run/words.def: of MPM_ALIAS the option is None and the text the end of a name."""
    with open(os.path.join(check.source, "src/run/words.def"), encoding="utf-8") as file:
        for kind, words, rest in re.findall(r'^MPM_(WORD|ALIAS)\("([^"]*)", (.*)\)$', file.read(), re.M):
            rest = [text.replace('\\"', '"') for text in re.findall(r'"((?:[^"\\]|\\.)*)"', rest)]
            yield words.split(), rest[0] if kind == "WORD" else None, rest[-1]


DISK = {"material_<m>_": "material_soft_", "body_<b>_": "body_disk1_", "bc_<f>_": "bc_ymax_", "load_<l>_": "load_l_"}


def judge_word(row):
    """What is wrong with a row of words.def: its first word and another one in -help, the last one in a refusal."""
    words, option, text = row
    if option is None:
        lines = [check.pebble("-help", word) for word in words[-1:]]
        return next((f"-help {words}: {run.err}" for run in lines if run.status or f"{text} <" not in run.out), None)
    for word in {words[0], random.Random(words[0]).choice(words)}:
        said = check.pebble("-help", word)
        if said.status or f"  {word}{', of -' * bool(option)}{option}: {text}\n" not in said.out:
            return f"-help {word}: {said.out[-300:]} {said.err}"
    more = ["-loads", "l", "-load_l_body", "disk1", "-load_l_type", "pressure", "-load_l_value", "1"]
    for word in words[-1:]:
        name = f"new_{word}"
        if option:
            name = next((option.replace(group, here) for group, here in DISK.items() if group in option), option)
        run = check.pebble("-options_file", check.scene("disks"), *(more if "load_" in option else []), f"-{name}", word)
        if run.status != 2 or len(run.lines) != 1 or (not run.lines[0].endswith("; " + text) and not (not option and "did you mean" in run.lines[0])):
            return f"-{name} {word}: {run.status} {run.err[:300]}"
    return None


def words_of_others():
    """Each word of another program is answered by -help, and where it is refused."""
    rows = list(others_words())
    each = [(word, option) for words, option, _ in rows if option is not None for word in words]
    check.that(len(set(each)) == len(each) > 500, f"{len(each)} words in {len(rows)} rows, twice: {sorted({one for one in each if each.count(one) > 1})}")
    taken = [option for _, option, _ in rows if option and not re.search(rf"^  -{re.escape(option)} ", check.must("-help", option.split("_")[0]).out, re.M)]
    check.that(not taken, f"options that words.def names are there: {taken}")
    for wrong in check.at_once(judge_word, rows):
        check.fault(wrong)
    whole = check.must("-help", "words").out
    check.that(all(" ".join(words) in whole for words, option, _ in rows if option is not None), "-help words lists all")


def asked_for(words):
    """-help with words prints the lines of -help that have all of them, below the titles of their groups, and no other."""
    run = check.pebble("-help", *words)
    expected = {title: [line for line in lines if all(matches(word, title, line) for word in words)] for title, lines in WHOLE.items()}
    expected = {title: lines for title, lines in expected.items() if lines}
    if not expected:
        return None if run.status == 2 and len(run.lines) == 1 and not run.out else f"-help {words}: status {run.status}, {run.lines[:2]}"
    found = groups_of("\n\n" + run.out.lstrip("\n"))
    found.pop("words of other programs", None)
    return None if run.status == 0 and not run.err and found == expected else f"-help {words}: {run.out[:300]}"


def help_of_words():
    """-help <word>, against what -help prints whole."""
    global WHOLE
    WHOLE = groups_of(check.must("-help").out)
    check.need(sum(map(len, WHOLE.values())) > 150, "-help has its groups")
    lines = [line for group in WHOLE.values() for line in group]
    others = {word for words, *_ in others_words() for word in words}
    words = sorted({word.lower() for line in lines for word in re.findall(r"[A-Za-z0-9]+", line)} - others - {"petsc", "words"})
    some = random.Random(22).sample(words, 60) + ["wall", "dt", "e", "WALLS", "body_", "checkpoint_every", "s^2", "-dry"]
    pairs = [(a, b) for a, b in zip(some[::2], some[1::2])]
    for wrong in check.at_once(asked_for, [(word,) for word in some if word[0] != "-"] + pairs[:10] + [("wall", "friction"), ("cell", "pool")]):
        check.fault(wrong)

    def says(words, lines, n=1):
        run = check.pebble("-help", *words, n=n, plain=n > 1)
        check.that(run.status == 2 and not run.out and run.lines[:1] == lines, f"-help {' '.join(words)}: {run.status} {run.lines[:2]}")

    says(["viscositty"], ["-help viscositty: no option has this word; did you mean viscosity ?"])
    says(["wal1"], ["-help wal1: no option has this word; did you mean wall ?"])
    says(["hocus_pocus_fidibus"], ["-help hocus_pocus_fidibus: no option has this word; pebble -help lists all options, pebble -help petsc also PETSc's"])
    says(["gruneisen", "tait"], ["-help gruneisen tait: no option has all of these words; pebble -help lists all options, pebble -help petsc also PETSc's"])
    says(["wall", "viscositty"], ["-help wall viscositty: no option has one of these words; did you mean viscosity ?"])
    says(["viscositty"], ["-help viscositty: no option has this word; did you mean viscosity ?"], n=2)
    # A name as a scene has it, and another program's word.
    for word, name in (("body_disk1_radius", "body_<b>_radius"), ("bc_xmin_mu", "bc_<f>_mu"), ("youngs", "material_<m>_E"), ("scheme", "method_update")):
        run = check.pebble("-help", word)
        check.that(run.status == 0 and re.search(rf"^  -{name} ", run.out, re.M), f"-help {word} finds -{name}")
    run = check.pebble("-help", "body_disk1_radius")
    check.that(run.out.count("\n  -") == 1, "and no other")
    # Once on several processes; wherever it stands; an option after -help is no word.
    run = check.pebble("-help", "gruneisen", n=2, plain=True)
    check.that(run.status == 0 and run.out == check.must("-help", "gruneisen").out, "two processes print it once")
    check.that(check.must("-options_file", check.scene("disks"), "-help", "gruneisen").out == run.out, "behind an options file")
    check.that(check.must("-help", "-dim", "2").out == check.must("-help").out, "an option behind -help is no word")
    check.that(not os.listdir("."), "nothing is written")


# What muParser's functions and operators shall be, in Python's words.
MEANS = {"sign": lambda a: math.copysign(1, a) if a else 0, "rint": lambda a: math.floor(a + 0.5), "log": math.log, "ln": math.log, "abs": abs, "min": min, "max": max,
         "sum": lambda *a: sum(a), "avg": lambda *a: sum(a) / len(a)}


def formulas():
    """Each function, operator and constant that -help lists, by a run: start velocities of bodies of one particle."""
    title, = (title for title in WHOLE if title.startswith("formulas"))
    entries = dict(re.split(r"(?<! ): ", line[2:], maxsplit=1) for line in WHOLE[title])
    with open(os.path.join(check.source, "docs", "reference.md"), encoding="utf-8") as file:
        section = file.read().partition("## Formulas\n")[2].partition("\n## ")[0]
    check.that(re.findall(r"^\| `(.*?)` \|", section, re.M) == [what.replace("|", r"\|") for what in entries], "docs/reference.md lists what -help does")
    calls = [what for what in entries if re.fullmatch(r"\w+\([\w, .]+\)", what)]
    check.need(len(calls) > 20, f"functions: {calls}")
    asked = []  # (formula, value)
    for what in calls:
        name, arguments = re.match(r"(\w+)\((.*)\)", what).groups()
        if name == "table":
            continue  # test_tables.py has it
        function = MEANS.get(name) or getattr(math, name)
        for values in ([0.3, 0.75, 0.5], [0.6, 0.2, 0.9]) if name != "acosh" else ([1.3], [2.6]):
            values = values + [0.1] if "..." in arguments else values[:arguments.count(",") + 1]
            asked.append((f"{name}({','.join(map(str, values))})", float(function(*values))))
    asked += [("sign(-0.3)", -1), ("sign(0)", 0), ("rint(-1.5)", -1), ("rint(2.5)", 3), ("abs(0-0.3)", 0.3), ("max(0.5)", 0.5)]
    asked += [("0.3 + 2*0.5 - 0.7/4", 0.3 + 2 * 0.5 - 0.7 / 4), ("-2^2", -4), ("2^3^2", 512), ("2^-1", 0.5), ("(1 + 2)*3", 9), ("1 < 2", 1), ("2 <= 1", 0),
              ("1 > 2", 0), ("2 >= 2", 1), ("1 == 2", 0), ("1 != 2", 1), ("1 && 0", 0), ("1 || 0", 1), ("0 ? 3 : 4", 4), ("1 < 2 ? 3 : 4", 3),
              ("1.5e1", 15), ("pi", math.pi), ("_pi", math.pi), ("_e", math.e)]
    asked += [("0", 0)] * (-len(asked) % 3)
    names = [f"b{k}" for k in range(len(asked) // 3)]
    lines = ["-dim 3", "-grid_lower 0,0,0", f"-grid_upper {len(names)},1,1", "-grid_h 0.25,0.25,0.25", "-materials m", "-material_m_model elastic", "-material_m_rho 1", "-material_m_E 1e4",
             "-material_m_nu 0.3", f"-bodies {','.join(names)}", "-time_end 1", "-time_max_steps 0"]
    for k, name in enumerate(names):
        lines += [f"-body_{name}_shape box", f"-body_{name}_lower {k},0,0", f"-body_{name}_upper {k + 0.25},0.25,0.25", f"-body_{name}_material m", f"-body_{name}_ppc 1,1,1",
                  f'-body_{name}_velocity "{", ".join(text for text, _ in asked[3 * k:3 * k + 3])}"']
    check.must("-options_file", check.write("formulas.opts", lines))
    found = check.particles("output/formulas.h5")["v"].ravel()
    for (text, value), v in zip(asked, found):
        check.fault(None if abs(v - value) < 1e-14 * max(1, abs(value)) else f"{text} is {v}, not {value}")
    check.that(len(found) == len(asked), f"{len(asked)} formulas")
    examples = re.findall(r'^    -(\w+) "(.*)"$', section, re.M)
    run = check.pebble("-options_file", check.scene("disks"), "-time_max_steps", "1", "-loads", "push", "-load_push_body", "disk1", "-load_push_type", "pressure", "-check_momentum", "0",
                       *(word for name, text in examples for word in (f"-{name}", text)))
    check.that(len(examples) == 2 and run.good, f"the examples of docs/reference.md: {run.lines}")
    # What muParser has beside that is not understood, so the list is whole.
    for text, said in (("cot(0.5)", "cot"), ("e", "e"), ("tgamma(1)", "tgamma"), ("E", "E")):
        run = check.pebble("-options_file", check.scene("disks"), "-body_disk1_velocity", f"{text},0", "-dry_run")
        check.that(run.status == 2 and f'Unexpected token "{said}' in run.err, f"{text} is no formula: {run.lines}")


def scene(name, *lines):
    return check.write(name, [f"-options_file {check.scene('disks')}", *lines])


def included():
    """A file may change what a file that it names has set; two lines of one file may not contradict each other."""
    check.must("-options_file", scene("over.opts", "-time_end 0.01"))
    end = check.rows("output/over.csv")[-1]["time"]
    check.that(float(end) == 0.01, f"the file that names another overrides it: time_end {end}")
    check.write("first.opts", ["-time_end 0.01"])
    check.write("second.opts", ["-time_end 0.02"])
    for words, right in ((["first.opts", "second.opts"], 0.02), (["second.opts", "first.opts"], 0.01)):
        check.must("-options_file", check.scene("disks"), *(word for name in words for word in ("-options_file", name)), "-output_name", "two")
        check.that(float(check.rows("output/two.csv")[-1]["time"]) == right, f"of two files the second counts: {words}")
    check.must("-options_file", check.write("late.opts", ["-time_end 0.02", "-options_file over.opts"]), "-output_name", "late")
    check.that(float(check.rows("output/late.csv")[-1]["time"]) == 0.01, "lines of a file that another names override the lines above that")
    check.folder("sub")
    run = check.pebble("-options_file", check.write("sub/outer.opts", ["-options_file inside.opts"]))
    check.that(run.status == 2 and run.lines == ["sub/outer.opts:1: -options_file inside.opts: No such file or directory; this path starts at the folder in which the program was started"], f"paths of files: {run.lines}")
    run = check.pebble("-options_file", scene("twice.opts", "-time_end 0.01", "-time_end 0.02"), "-dry_run")
    check.that(run.status == 2 and run.lines == ["twice.opts:3: -time_end 0.02 contradicts -time_end 0.01 of line 2; remove one of them"],
               f"two lines of a file that contradict each other: {run.lines}")
    run = check.pebble("-options_file", scene("same.opts", "-time_end 0.01", "-time_end 0.01"), "-dry_run")
    check.that(run.status == 0, "two lines of a file that say the same")
    check.write("inner.opts", ["-body_disk1_radius 0.1", "-prefix_push body_disk1_", "-radius 0.15", "-prefix_pop"])
    run = check.pebble("-options_file", scene("outer.opts", "-options_file inner.opts"), "-dry_run")
    check.that(run.status == 2 and run.lines == ["inner.opts:3: -body_disk1_radius 0.15 contradicts -body_disk1_radius 0.1 of line 1; remove one of them"],
               f"a contradiction in a file that another names: {run.lines}")


def kept():
    """Results never take the place of an options file, by whatever name it was given."""
    def refused(what, path, *words):
        before = check.content(path)
        run = check.pebble(*words, "-time_max_steps", "1")
        check.that(run.status == 2 and "would overwrite the options file" in run.err and len(run.lines) == 1 and check.content(path) == before,
                   f"{what}: {run.lines}")

    check.folder("kept")
    shutil.copy(check.scene("disks"), "kept/inner.h5")
    with open("kept/main.opts", "w", encoding="utf-8") as file:
        file.write("-options_file kept/inner.h5\n")
    refused("a file that another names", "kept/inner.h5", "-options_file", "kept/main.opts", "-output_dir", "kept", "-output_name", "inner")
    os.symlink("inner.h5", "kept/link.csv")
    refused("a file by a link", "kept/inner.h5", "-options_file", "kept/main.opts", "-output_dir", "kept", "-output_name", "link")
    run = check.must("-options_file", "kept/main.opts", "-output_dir", "kept", "-time_max_steps", "1")
    check.that(run.good and os.path.exists("kept/main.h5"), "other names beside it are free")


if __name__ == "__main__":
    check.arguments(__doc__, 0)
    check.folder("help")
    os.chdir("help")
    help_of_words()
    os.chdir("..")
    words_of_others()
    formulas()
    vocabulary()
    included()
    kept()
    check.end()
