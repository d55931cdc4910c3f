"""Broken scenes are refused in one line that names what is broken, with exit status 2. They are made from the scenes of
options/, as .opts and as YAML, each by one fault that makes the scene wrong by construction: a name that is misspelt, a
value of the wrong type or out of range, a required option that is missing, one that contradicts others, a name twice
with different values, faults of syntax, and files that are no text. The scenes themselves are taken in both forms, and
so is a file that includes another one and overrides it.

usage: test_broken.py PEBBLE SOURCE MPIEXEC some|third|all|mutations

some       60 of them
third      every third
all        all; with these and with a third the processor time of each counts, which has to be less than a second
mutations  random changes of scenes, which may leave them valid, and of the file of the performance model: a scene is
           refused in one line, or taken without a word on standard error
"""
import collections
import glob
import gzip
import os
import random
import re
import subprocess
import tempfile
import threading
import time

import check
import mpi
from mutate import mutate

PART, = check.arguments(__doc__, 1)
LONG = 10_000_000  # characters of the longest line
Broken = collections.namedtuple("Broken", "label name data expected")  # expected: a pattern that the line has
Row = collections.namedtuple("Row", "name type allowed default")


# ---- Scenes and the vocabulary

def vocabulary():
    with open(os.path.join(check.source, "src/run/options.def"), encoding="utf-8") as file:
        rows = re.findall(r'^MPM_OPTION\("([^"]+)", (\w+), (.*?), "[^"]*", "([^"]*)", "', file.read(), re.M)
    return {name: Row(name, kind, allowed.strip('"'), default) for name, kind, allowed, default in rows}


def lines_of(path):
    """Names in full, and values, of an options file."""
    prefixes, entries = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split("#")[0].split(None, 1)
            if not words:
                continue
            name, value = words[0], words[1].strip().strip('"') if len(words) > 1 else ""
            if name == "-prefix_push":
                prefixes.append(value)
            elif name == "-prefix_pop":
                prefixes.pop()
            else:
                beside = os.path.join(os.path.dirname(path), value)  # the copy of the scene will lie elsewhere
                entries.append(("".join(prefixes) + name[1:], beside if name.endswith("file") and os.path.isfile(beside) else value))
    return entries


def opts(entries):
    return "".join(f'-{name} "{value}"\n' if re.search(r"\s", value) or not value else f"-{name} {value}\n" for name, value in entries)


def yaml(entries):
    return "".join(f'{name}: "{value}"\n' for name, value in entries)


class Scene:
    def __init__(self, path, rows):
        self.name = os.path.splitext(os.path.basename(path))[0]
        with open(path, encoding="utf-8") as file:
            self.text = file.read()
        self.entries = lines_of(path)
        self.value = dict(self.entries)
        self.dim = int(self.value["dim"])
        self.rows = rows
        names = {"m": self.value["materials"].split(","), "b": self.value["bodies"].split(","),
                 "l": self.value.get("loads", "").split(","), "p": self.value.get("probes", "").split(","), "s": self.value.get("stages", "").split(","), "f": [f"{axis}{side}" for axis in "xyz" for side in ("min", "max")]}
        self.legal = {}
        for row in rows.values():
            kind = re.search(r"<(\w)>", row.name)
            for word in names.get(kind[1], []) if kind else [""]:
                self.legal[re.sub(r"<\w>", word, row.name)] = row

    def row(self, name):
        """The row of an option; any option may be of a stage."""
        return self.legal.get(name) or self.legal[re.sub(r"^stage_[a-z0-9]+_", "", name)]


# ---- Faults. Each function yields (label, entries, pattern of the line) for a scene.

def named(name):
    return rf"(?<![\w-])-{re.escape(name)}(?!\w)"


def changed(scene, name, value):
    return [(n, value if n == name else v) for n, v in scene.entries]


def misspelt(scene, rng):
    for name, value in scene.entries:
        for _ in range(20):
            at = rng.randrange(1, len(name))
            other = rng.choice([name[:at] + name[at + 1:], name[:at] + rng.choice("abcxyz_") + name[at:],
                                name[:at - 1] + name[at] + name[at - 1] + name[at + 1:]])
            if other.lower() not in map(str.lower, scene.legal) and other[0].isalpha():
                break
        else:
            continue
        # What a misspelt declaration declared is unknown then, and a required option may be named as missing first.
        yield "misspelt", [(other if n == name else n, v) for n, v in scene.entries], named(other)


def wrong_type(scene, rng):
    number = ["many", "1.2.3", "1e", "--3", "0x", "3s", "1;2", "1,5", "\u22125", "nan", "inf", "1e999"]
    for name, value in scene.entries:
        row = scene.row(name)
        if row.type in ("REAL", "INT"):
            words = [rng.choice(number)] + (["2.5"] if row.type == "INT" else [])
        elif row.type in ("REALS", "INTS"):
            parts = value.split(",")
            at = rng.randrange(len(parts))
            words = [",".join(parts[:at] + [rng.choice([word for word in number if word != "1,5"])] + parts[at + 1:]), value + ",1"]
            words += [" ".join(parts), ",".join(parts[1:])] if len(parts) > 1 else []
        elif row.type == "BOOL":
            words = ["maybe", "2"]
        elif row.type == "ENUM":
            words = ["qqq", value + "," + value]
        elif row.type == "NAMES":
            words = [value + ",", value + ",a-b", "a b"]
        elif name.endswith("_velocity") or name in ("acceleration",) or name.endswith("_value"):
            words = [value + "+", "q" + value[1:] + "q", "sin(" + value, value + "=1"]
        else:
            continue
        for word in words:
            yield "wrong type", changed(scene, name, word), named(name)


def out_of_range(scene, rng):
    for name, value in scene.entries:
        row = scene.row(name)
        interval = re.fullmatch(r"([\[(])(.*),(.*)([\])])", row.allowed)
        if row.type not in ("REAL", "INT", "REALS", "INTS") or not interval:
            continue
        low, high, parts = float(interval[2]), float(interval[3]), value.split(",")
        outside = ([low - 1, low - 1e6] + ([low] if interval[1] == "(" else []) if low > -1e300 else []) + \
            ([high + 1, high * 1e3] + ([high] if interval[4] == ")" else []) if high < 1e300 else [])
        for word in rng.sample(outside, min(2, len(outside))):
            at = rng.randrange(len(parts))
            text = f"{word:.17g}"
            yield "out of range", changed(scene, name, ",".join(parts[:at] + [text] + parts[at + 1:])), named(name)


def missing(scene, rng):
    for name, value in scene.entries:
        row = scene.row(name)
        corner = re.fullmatch(r"body_(\w+)_(lower|upper)", name)  # only a box needs them
        if row.default.startswith("required") and not (corner and scene.value[f"body_{corner[1]}_shape"] != "box"):
            yield "missing", [(n, v) for n, v in scene.entries if n != name], rf"{named(name)} is required|is required.* or {named(name)}"
        if value and row.type not in ("BOOL",):
            yield "no value", changed(scene, name, ""), named(name) + " has no value"


def contradictory(scene, rng):
    def add(*more):
        return scene.entries + list(more)

    words = {"model": ["E", "K", "yield", "friction_angle"], "shape": ["radius", "lower", "inner_radius"]}
    for group, choice in (("material", "model"), ("body", "shape")):
        for one in scene.value["materials" if group == "material" else "bodies"].split(","):
            with open(os.path.join(check.source, "src/physics", "material.def" if group == "material" else "region.def"), encoding="utf-8") as file:
                table = re.search(rf'^MPM_\w+\({scene.value[f"{group}_{one}_{choice}"]}, .*?, "([^"]*)"', file.read(), re.M)
            for word in words[choice]:
                if word not in table[1].split():
                    value = ",".join(["1"] * scene.dim) if word == "lower" else "1"
                    yield "contradictory", add((f"{group}_{one}_{word}", value)), named(f"{group}_{one}_{word}")
            yield "undeclared", add((f"{group}_{one}x_{choice}", scene.value[f"{group}_{one}_{choice}"])), named(f"{group}_{one}x_{choice}")
    if "grid_cells" in scene.value:
        yield "contradictory", add(("grid_h", ",".join(["1"] * scene.dim))), "-grid_cells and -grid_h"
        yield "contradictory", changed(scene, "grid_lower", scene.value["grid_upper"]), "-grid_upper must be above -grid_lower"
    if scene.dim != 2:
        yield "contradictory", add(("geometry", "plane_strain")), "-geometry plane_strain"
    other = scene.dim % 3 + 1
    yield "contradictory", changed(scene, "dim", str(other)), r"-dim \d|-bc_[yz]\w+_type is not an option"
    yield "contradictory", add(("bc_xmin_mu", "0.3")) if scene.value.get("bc_xmin_type") != "friction" else add(("bc_xmin_type", "slip")), "-bc_xmin_"
    yield "contradictory", add(("dt_size", "1e-6")) if "dt_cfl" in scene.value and "dt_size" not in scene.value else changed(scene, "dt_size", "1e-6") if "dt_cfl" in scene.value else add(("study_levels", "3")), "-dt_cfl|-study_levels|-dt_size"
    yield "contradictory", add(("method_lock_cells", "2")) if "method_locking" not in scene.value else add(("method_locking", "all")), "-method_lock"
    yield "undeclared", add((f"body_{scene.value['bodies'].split(',')[0]}_material_", "x")), "_material_"
    yield "unknown word", changed(scene, f"body_{scene.value['bodies'].split(',')[0]}_material", "unobtainium"), "unobtainium is not declared"


def twice(scene, rng):
    for name, value in rng.sample(scene.entries, min(6, len(scene.entries))):
        other = rng.choice([value + "1", "7", ""])
        if other == value or not value:
            continue
        second = rng.choice([name, name.upper()])
        entries = list(scene.entries)
        entries.insert(rng.randrange(len(entries)), (second, other))
        yield "twice", entries, rf"(?i){named(name)}.* contradicts {named(name)}.* of line \d+; remove one of them"


FAULTS = [misspelt, wrong_type, out_of_range, missing, contradictory, twice]


def syntax(scene):
    """Faults of an options file's text: label, bytes, pattern."""
    text = scene.text
    at = re.search(r"\n-(time_end|stages)", text).start() + 1
    line = 1 + text[:at].count("\n")

    def put(words):
        return (text[:at] + words + "\n" + text[at:]).encode()

    place = rf"^scene\.opts:{line}: "
    for words in ("-scene_title a -dry_run", "-gravity 0, -9.81", "-gravity 0 -9.81", "dry_run", "- dry_run", "\u2212dry_run", "-dry_run = true",
                  "-dry_run=true", "// comment", "% comment", "/* comment */", "! comment", "; comment", '-scene_title "a', "-scene_title 'a b'",
                  '-scene_title a"b', "-prefix_pop", "-time_end 3 s", "dry_run: true", "-2dry_run", "-prefix_push", "-options_file",
                  "-dry_run\x01", "-dry_run \x00", "-prefix_push a_"):
        yield "syntax", put(words), place
    if "-prefix_pop" in text:
        first = 1 + text[:text.index("-prefix_push")].count("\n")
        yield "syntax", text.replace("-prefix_pop", "").encode(), rf"^scene\.opts:{first}: -prefix_push \w+ without -prefix_pop"
    data = text.encode()
    yield "binary", b"\x7fELF\x02\x01\x01\x00" + data, r"^scene\.opts:1: not a text file"
    yield "binary", gzip.compress(data, mtime=0), r"^scene\.opts:\d+: "
    yield "binary", text.encode("utf-16"), r"^scene\.opts:1: "
    yield "binary", random.Random(scene.name).randbytes(5000), r"^scene\.opts:\d+: "
    yield "byte-order mark", b"\xef\xbb\xbf" + data, r"^scene\.opts:1: starts with a byte-order mark"


def long_lines(scene):
    data = scene.text.encode()
    yield "long line", data + b"-scene_" + b"x" * LONG + b" 1\n", r"^scene\.opts:\d+: -scene_x+\.\.\.: this name is too long"
    yield "long line", data.replace(b"-scene_title", b"-scene_title " + b"x" * LONG + b"\n#"), r"^scene\.opts:\d+: -scene_title: its value is too long"
    yield "long line", b"x" * LONG, r"^scene\.opts:1: 'x+' is not an option"


def syntax_yaml(scene):
    text = yaml(scene.entries)
    yield "syntax", ("\tdim: 2\n" + text).encode(), r"^scene\.yaml:1: YAML is indented with blanks"
    yield "syntax", (text + "grid: {lower: [0, 0\n").encode(), r"^scene\.yaml(: not valid YAML|:\d+: -grid_lower .* contradicts)"
    yield "syntax", (text + "a: [b\n").encode(), r"^scene\.yaml: not valid YAML"
    yield "syntax", (text + 'scene: "x\n').encode(), r"^scene\.yaml: not valid YAML"
    yield "syntax", b"just words\n", r"^scene\.yaml: not valid YAML"
    yield "binary", text.encode().replace(b"dim", b"d\x00im", 1), r"^scene\.yaml:\d+: not a text file"
    yield "binary", b"\x89PNG\r\n\x1a\n\x00" + text.encode(), r"^scene\.yaml"
    yield "long line", b"x" * LONG, r"^scene\.yaml: not valid YAML"


def broken(scenes):
    """All broken scenes, as bytes."""
    for number, scene in enumerate(scenes):
        rng = random.Random(scene.name)
        for fault in FAULTS:
            for k, (label, entries, expected) in enumerate(fault(scene, rng)):
                if (number + k) % 4:
                    yield Broken(f"{scene.name}: {label}", "scene.opts", opts(entries).encode(), expected)
                else:
                    yield Broken(f"{scene.name}, yaml: {label}", "scene.yaml", yaml(entries).encode(), expected)
        for k, (label, data, expected) in enumerate(syntax(scene)):
            if (number + k) % 3 == 0:
                yield Broken(f"{scene.name}: {label}", "scene.opts", data, expected)
    for label, data, expected in long_lines(scenes[0]):
        yield Broken(label, "scene.opts", data, expected)
    for label, data, expected in syntax_yaml(scenes[0]):
        yield Broken(f"yaml: {label}", "scene.yaml", data, expected)


# ---- Runs

def start(folder, name, *options):
    """Runs a dry run; returns exit status, standard output, lines on standard error, processor time in s."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen([check.program, "-options_file", name, "-dry_run", *options], cwd=folder, stdout=out, stderr=err)
        timer = threading.Timer(check.TIMEOUT, process.kill)
        timer.start()
        _, status, used = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        out, err = mpi.keep(out.read().decode(errors="replace"), err.read().decode(errors="replace"))
        return process.returncode, out, err.splitlines(), used.ru_utime + used.ru_stime


def clean(folder):
    for file in os.listdir(folder):
        path = os.path.join(folder, file)
        os.rmdir(path) if os.path.isdir(path) else os.remove(path)
    os.rmdir(folder)


def write(folder, name, data):
    with open(os.path.join(folder, name), "wb") as file:
        file.write(data)


def refuse(job):
    """What is wrong with the answer to a broken scene, or None, and its processor time."""
    number, case = job
    folder = check.folder(f"broken{number}")
    write(folder, case.name, case.data)
    status, out, lines, seconds = start(folder, case.name)
    files = sorted(os.listdir(folder))
    fault = None
    if status != 2:
        fault = f"exit status {status}, not 2"
    elif len(lines) != 1 or out:
        fault = f"{len(lines)} lines on standard error, {len(out)} characters on standard output"
    elif not re.search(case.expected, lines[0]) or len(lines[0]) > 2048:
        fault = "another message"
    elif files != [case.name]:
        fault = f"left files {files}"
    if fault:
        return f"{case.label} ({folder}): {fault}\n  expected  {case.expected}\n" + "\n".join(f"  got       {line[:300]}" for line in lines[:4] or [""]), seconds
    clean(folder)
    return None, seconds


def accept(scenes):
    """The scenes are good, in both forms and when they are included and overridden."""
    for scene in scenes:
        folder = check.folder("good_" + scene.name)
        write(folder, "scene.opts", opts(scene.entries).encode())
        write(folder, "scene.yaml", yaml(scene.entries).encode())
        end = f"stage_{scene.value['stages'].split(',')[0]}_time" if "stages" in scene.value else "time_end"
        write(folder, "over.opts", f"-options_file scene.opts\n-scene_title other\n-{end} 1e-9\n".encode())
        digest = set()
        for name in ("scene.opts", "scene.yaml", "over.opts") if PART != "some" else ("scene.opts", "over.opts"):
            status, out, lines, _ = start(folder, name, "-output_name", "s")
            check.fault(f"{scene.name} as {name}: exit status {status} {lines[:2]}" if status or lines else None)
            if name != "over.opts":
                digest.add(re.sub(r"\d\S* *(s|ns|GB|MB)\b", "", "\n".join(line for line in out.splitlines() if line.startswith(("scene", "grid", "particles", "method")))))
        check.fault(f"{scene.name}: the two forms say {digest}" if len(digest) > 1 else None)


def mutations(scenes, each):
    counts = collections.Counter()

    def one(job):
        scene, seed = job
        rng = random.Random(f"{scene.name}{seed}")
        text = mutate(rng, scene.text if seed % 3 else yaml(scene.entries) if seed % 2 else opts(scene.entries))
        name = "scene.yaml" if not seed % 3 and seed % 2 else "scene.opts"
        folder = check.folder(f"mutation_{scene.name}_{seed}")
        write(folder, name, text.encode("latin-1", errors="replace"))
        status, _, lines, _ = start(folder, name)
        counts[status] += 1
        if status not in (0, 2) or len(lines) != (status == 2):
            return f"{folder}/{name}: exit status {status}\n" + "\n".join(line[:300] for line in lines[:5])
        for path in glob.glob(os.path.join(folder, "output", "*")):
            os.remove(path)
        clean(folder)
        return None

    for wrong in check.at_once(one, [(scene, seed) for scene in scenes for seed in range(each)]):
        check.fault(wrong)
    check.that(counts[2] > counts[0] > 0, f"{sum(counts.values())} mutations of {len(scenes)} scenes: {counts[2]} refused in one line, {counts[0]} taken")


def models(number):
    """The file of the performance model, damaged: it is refused, not used with a word about it, or still good."""
    scene = check.scene("disks")
    names = ["exchange", "message", "post", "wire", "copy", "kept", "reduction", "job", "pool"]
    names += [f"migration[{k}].{what}" for k in (0, 1) for what in ("call", "particle", "leaver")] + ["flop", "byte"]
    text = "# constants\nmethod 2-D:0:1:8\nfrom here\nrate P2G 1e-6 1 1e-8 100 1e-8 1000 1e-8\n" + "".join(f"{name} 1e-6\n" for name in names)
    counts = collections.Counter()
    for seed in range(number):
        folder = check.folder(f"model{seed}")
        write(folder, "m.model", mutate(random.Random(seed), text).encode("latin-1"))
        status, out, lines, _ = start(folder, scene, "-model_file", "m.model")
        counts[status] += 1
        check.fault(f"{folder}: exit status {status} {lines[:3]}" if status not in (0, 2) or len(lines) != (status == 2) else None)
    check.that(counts[0] + counts[2] == number, f"{number} damaged model files: {counts[2]} refused, {counts[0]} with a run that goes on")


def main():
    rows = vocabulary()
    scenes = [Scene(path, rows) for path in sorted(glob.glob(os.path.join(check.source, "options", "*.opts")))]
    check.need(len(scenes) > 10 and len(rows) > 80, f"{len(scenes)} scenes, {len(rows)} options")
    if PART == "mutations":
        mutations(scenes, 30)
        models(100)
        check.end()
    cases = list(broken(scenes))
    check.need(len(cases) >= 500, f"{len(cases)} broken scenes, 500 are promised")
    if PART == "third":
        cases = cases[::3]
    if PART == "some": # five of each kind of fault, but one line of 10 MB
        kinds = collections.defaultdict(list)
        for case in cases:
            kinds[case.label.split(": ")[-1]].append(case)
        rng = random.Random(5)
        cases = [case for kind, same in kinds.items() for case in rng.sample(same, min(len(same), 1 if kind == "long line" else 5))]
        scenes = scenes[:3]
    accept(scenes)
    before = time.monotonic()
    wrong, seconds = zip(*check.at_once(refuse, enumerate(cases)))
    if PART != "some":
        check.that(max(seconds) < 1, f"the slowest refusal took {max(seconds):.2f} s of processor time, the mean is {sum(seconds) / len(seconds):.3f} s")
    for fault in wrong:
        check.fault(fault)
    kinds = collections.Counter(case.label.split(": ")[-1] for case in cases)
    good = sum(fault is None for fault in wrong)
    check.that(good == len(cases), f"{good} of {len(cases)} broken scenes refused in one line that names the fault, {time.monotonic() - before:.0f} s: "
               + ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())))
    check.end()


main()
