"""Bad input is refused with one line, good input is not: the cases of refusals.txt, a few with -help, on two processes
and 60 random mutations of options/disks.opts. Options without effect and crowded cores get a note.

usage: test_refusals.py PEBBLE SOURCE MPIEXEC
"""
import os
import random
import re
import shlex
import shutil

import check
from mutate import mutate

check.arguments(__doc__, 0)
DISKS = check.scene("disks")
FILLED = """\
-dim 2
-grid_lower 0,0
-grid_upper 1,1
-grid_cells 8,8
-bc_xmin_type slip
-bc_xmax_type slip
-bc_ymin_type slip
-bc_ymax_type slip
-materials m
-material_m_model neohookean
-material_m_rho 1000
-material_m_E 1e7
-material_m_nu 0.3
-bodies b
-body_b_shape box
-body_b_lower 0,0
-body_b_upper 1,1
-body_b_material m
-time_end 0.005
"""
TOOL = FILLED.replace("-bodies b\n", "-bodies b,r\n").replace("-body_b_upper 1,1", "-body_b_upper 0.5,1") + """\
-body_r_shape box
-body_r_lower 0.6,0.2
-body_r_upper 0.8,0.4
"""


def run(command, folder, **more):
    """Runs in an empty folder; returns status, stdout, stderr's lines and the files that there are then."""
    told = check.run(command, cwd=folder, **more)
    return told.status, told.out, told.err.splitlines(), sorted(os.listdir(folder))


def refused(status, lines):
    """What is wrong with a refusal, or None."""
    if status != 2:
        return f"exit status {status}, not 2"
    if len(lines) != 1 or not lines[0].strip():
        return f"{len(lines)} lines on stderr, not 1"
    return None


def cases():
    with open(os.path.join(check.source, "tests", "refusals.txt"), encoding="utf-8") as f:
        for line in f:
            if line.strip() and not line.startswith("#"):
                label, arguments, message = (part.strip() for part in re.split(r"(?:^|\s)::(?=\s)", line))
                yield label, arguments, message


def unescape(text):
    """Resolves escapes as in C; characters are bytes."""
    return text.encode("latin-1").decode("unicode_escape")


def prepare(arguments, folder):
    """The command of a case; writes its file."""
    words, bare, name = [], False, None
    with open(DISKS, encoding="latin-1") as f:
        text = f.read()
    for word in shlex.split(arguments.replace("{long}", "x" * 3000).replace("\\", "\\\\").replace('\\\\"', '\\"')):
        key, _, value = word.partition(":")
        if key == "bare":
            bare = True
        elif key in ("filled", "tool"):
            text, name = FILLED if key == "filled" else TOOL, "scene.opts"
        elif key == "drop":
            text, name = re.sub(rf"^{value}\b.*\n", "", text, flags=re.M), name or "scene.opts"
        elif key == "add":
            text, name = text + unescape(value), name or "scene.opts"
        elif key in ("only", "yaml"):
            text, name = unescape(value), "scene.yaml" if key == "yaml" else name or "scene.opts"
        elif key == "file":
            name = value
        else:
            words.append(unescape(word).replace("DISKS", DISKS).encode("latin-1").decode())
    if name:
        with open(os.path.join(folder, name), "wb") as f:
            f.write(text.encode("latin-1"))
    return [check.program] + ([] if bare else ["-options_file", name or DISKS]) + words, name


def check_case(case):
    number, (label, arguments, message) = case
    folder = check.folder(f"case{number}")
    command, name = prepare(arguments, folder)
    status, out, lines, files = run(command + (["-dry_run"] if message == "ok" else []), folder)
    files = [f for f in files if f not in (name, "log.txt") and not (os.path.isdir(os.path.join(folder, f)) and not os.listdir(os.path.join(folder, f)))]
    shutil.rmtree(folder)
    if message == "ok":
        fault = None if status == 0 and not lines else f"exit status {status}"
    else:
        fault = refused(status, lines)
        message = re.sub(r"\\(\d{3})", lambda byte: chr(int(byte[1], 8)), message).encode("latin-1").decode()
        if not fault and not (re.fullmatch(message[1:], lines[0]) if message[0] == "~" else message == lines[0]):
            fault = "another message"
        if not fault and out:
            fault = f"stdout: {out}"
    if not fault and files:
        fault = f"left files: {files}"
    return fault and "\n".join([f"{label}: {fault}", f"  arguments  {arguments[:300]}", f"  expected   {message}"] + [f"  got        {line[:300]}" for line in lines[:5]])


def check_fuzz(seed):
    with open(DISKS, encoding="utf-8") as f:
        text = mutate(random.Random(seed), f.read())
    folder = check.folder(f"fuzz{seed}")
    with open(os.path.join(folder, "scene.opts"), "w", encoding="latin-1") as f:
        f.write(text)
    status, _, lines, files = run([check.program, "-options_file", "scene.opts", "-dry_run"], folder)
    fault = refused(status, lines) if status else None if not lines else "stderr although it is accepted"
    if not fault and files != ["scene.opts"]:
        fault = f"left files: {files}"
    if fault:
        return "\n".join([f"mutation {seed}: {fault}; the scene is {folder}/scene.opts"] + [f"  got        {line[:300]}" for line in lines[:8]])
    shutil.rmtree(folder)
    return None


def check_help(arguments, status, pattern):
    got, out, lines, files = run([check.program] + arguments, check.folder("help"))
    if got != status or lines or files or not re.search(pattern, out):
        return f"{arguments}: exit status {got}, stderr {lines[:3]}, stdout does not have {pattern}"
    return None


def check_two_processes(arguments, message):
    """The line comes once. mpiexec adds its own words about the exit status."""
    status, _, lines, _ = run([check.program] + arguments, check.folder("two"), n=2, plain=True)
    if status != 2 or lines.count(message) != 1 or any("PETSC ERROR" in line for line in lines):
        return f"mpiexec -n 2 {arguments}: exit status {status}, stderr:\n" + "\n".join(lines[:20])
    return None


def check_notes(n, arguments, expected, core=None):
    """The notes of a short run; that on processes that take turns counts where all share one core."""
    command = ["taskset", "-c", str(core)] if core is not None else []
    command += [check.program, "-options_file", DISKS, "-time_max_steps", "1", "-output_format", "none"] + arguments
    status, out, _, _ = run(command, check.folder("notes"), n=n)
    notes = [line[11:] for line in out.splitlines() if line.startswith("note ")]
    if core is None:
        notes = [note for note in notes if "take turns" not in note]
    if status or notes != expected:
        return f"{n} processes, {arguments}: exit status {status}, notes {notes}, not {expected}"
    return None


def main():
    rows = list(cases())
    labels = [label for label, _, _ in rows]
    check.need(len(set(labels)) == len(labels), "a label is there twice")
    faults = check.at_once(check_case, enumerate(rows)) + check.at_once(check_fuzz, range(60))
    faults += [
        check_help(["-help"], 0, r"(?s)^Pebble: .*-help petsc.*-dim <required>: .*-time_end <required> s: "),
        check_help(["-options_file", DISKS, "--help"], 0, r"^Pebble: .*\n"),
        check_help(["-help", "petsc"], 0, r"(?s)^Pebble: .*Options for all PETSc programs"),
        check_help(["-version"], 0, r"^pebble \S+ \(\S+\), PETSc 3\.\d+"),
        check_two_processes(["-options_file", DISKS, "-dim", "4"], "-dim 4 is outside the allowed range 1 <= dim <= 3"),
        check_two_processes(["-options_file", "nowhere"], "nowhere: No such file or directory"),
        check_two_processes(["-options_file", DISKS, "-options_string_yaml", "a: [b"],
                            "-options_string_yaml: not valid YAML, or not names with values"),
    ]
    pool, spatial = ["-parallel_strategy", "pool"], ["-pool_cells", "8"]
    both = ["-parallel_migrate", "direct", "-parallel_balance", "auto"]
    core = min(os.sched_getaffinity(0))
    faults += [
        check_notes(1, [], []),
        check_notes(1, pool + spatial + both, [f"-{name} has no effect on one process" for name in
                    ("parallel_strategy", "parallel_balance", "parallel_migrate", "pool_cells")]),
        check_notes(1, ["-dry_run", "-report_processes", "-report_path", "-report_limits", "-report_phases"] + pool + spatial + both,
                    [f"-report_{name} has no effect with -dry_run" for name in ("limits", "phases", "path")]),
        check_notes(1, ["-dry_run"] + pool, ["-parallel_strategy has no effect on one process"]),
        check_notes(1, ["-report_processes"], ["-report_processes has no effect without -dry_run"]),
        check_notes(2, spatial + both, ["-pool_cells has no effect without -parallel_strategy pool"]),
        check_notes(2, pool + spatial + both, [f"-parallel_{name} has no effect with -parallel_strategy pool" for name in
                    ("balance", "migrate")]),
        check_notes(2, [], ["2 processes share 1 core of this computer: they take turns, and more than 1 are no faster"], core),
        check_notes(2, ["-dry_run"], [], core),
        check_notes(1, [], [], core),
    ]
    for wrong in faults:
        check.fault(wrong)
    check.end()


main()
