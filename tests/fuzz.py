"""Gives random inputs to the readers of options and of model files, by libFuzzer with sanitizers (make fuzz): no input may
crash, hang for 20 s, leak, or be answered otherwise than in one line. The first inputs are made from the scenes of options/,
the words from src/run/options.def. An input that fails is kept as build/fuzz/<harness>/crash-*, leak-* or timeout-*; the
harness repeats it, given that file.

usage: fuzz.py FOLDER SOURCE INPUTS      the folder of the harnesses; so many options, and a tenth of that model files
"""
import glob
import os
import re
import shutil
import subprocess
import sys

FOLDER, SOURCE, INPUTS = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), int(sys.argv[3])


def write(path, text):
    with open(path, "wb") as file:
        file.write(text if isinstance(text, bytes) else text.encode())


def flat(text):
    """Lines `-name value` of an options file, with prefixes."""
    prefixes = []
    for line in text.splitlines():
        words = line.split("#")[0].split(None, 1)
        if words[:1] == ["-prefix_push"]:
            prefixes.append(words[1].strip())
        elif words[:1] == ["-prefix_pop"]:
            prefixes.pop()
        elif words:
            yield "-" + "".join(prefixes) + words[0][1:], words[1].strip().strip('"') if len(words) > 1 else ""


def option_seeds(folder):
    scenes = sorted(glob.glob(os.path.join(SOURCE, "options", "*.opts")))
    for path in scenes:
        with open(path, encoding="utf-8") as file:
            text = re.sub(r"^#.*\n", "", file.read(), flags=re.M)
        name, lines = os.path.basename(path), list(flat(text))
        write(os.path.join(folder, "F" + name), "F" + text)
        write(os.path.join(folder, "Y" + name), "Y" + "".join(f'{key[1:]}: "{value}"\n' for key, value in lines))
        write(os.path.join(folder, "A" + name), "A" + "".join(f"{key}\n{value}\n" for key, value in lines))
        for k, (key, value) in enumerate(lines):
            key = re.sub(r"^-(material|body|load)_[a-z0-9]+_", lambda group: f"-{group[1]}_{group[1][0]}_", key)
            write(os.path.join(folder, f"S{k}{name}"), f'S{key} "{value}"\n')
    for k, text in enumerate(["Ygrid: {lower: [0, 0], upper: [1, 1]}\nbody:\n  b:\n    shape: box\n", "A-options_file\nscene.opts\n-dim\n2\n",
                              "S-options_file scene.opts\n", 'S-acceleration "(-y)*(t<0.1 ? 1 : 0), max(x,X)^2"\n']):
        write(os.path.join(folder, f"own{k}"), text)


def option_words():
    with open(os.path.join(SOURCE, "src/run/options.def"), encoding="utf-8") as file:
        rows = re.findall(r'^MPM_OPTION\("([^"]+)", \w+, "?([^",]*)', file.read(), re.M)
    words = {"-" + re.sub("<[mb]>", lambda group: group[0][1], name) for name, _ in rows}
    words |= {value for _, allowed in rows for value in re.split(r"[| ]", allowed) if value.isalpha()}
    for table in ("physics/material.def", "physics/region.def", "physics/wall.def", "physics/basis.def", "step/transfer.def", "known/reference.def"):
        with open(os.path.join(SOURCE, "src", table), encoding="utf-8") as file:
            words |= set(re.findall(r"^MPM_\w+\((\w+),", file.read(), re.M))
    return sorted(words | {"-prefix_push ", "-prefix_pop\\x0a", "-options_file ", "\\x0a-", "\\xe2\\x88\\x92", "\\xef\\xbb\\xbf", "nan", "1e999", "sin(", "pi", "{", "[", ": "})


def model_seeds(folder):
    names = ["exchange", "message", "post", "wire", "copy", "kept", "reduction", "job", "pool", "flop", "byte"]
    names += [f"migration[{k}].{what}" for k in (0, 1) for what in ("call", "particle", "leaver")]
    text = "from here\n" + "".join(f"rate {phase} 1e-6 1 1e-8 100 1e-8 1000 1e-8\n" for phase in model_phases()) + "".join(f"{name} 1e-06\n" for name in names)
    write(os.path.join(folder, "all"), text)
    write(os.path.join(folder, "one"), "rate P2G 1e-6 1 1e-8 100 1e-8 1000 1e-8\n")
    return names


def model_phases():
    with open(os.path.join(SOURCE, "src/step/phases.c"), encoding="utf-8") as file:
        phases = sorted(set(re.findall(r'"([A-Z][A-Z0-9_]+)"', file.read())))
    return phases + ["FORCES", "REDUCE", "MIGRATE", "SORT", "SETTLE"]


def run(name, runs, words, seeds):
    """One harness; returns whether nothing was found."""
    folder = os.path.join(FOLDER, name + ".runs")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(os.path.join(folder, "corpus"))
    seeds(os.path.join(folder, "corpus"))
    write(os.path.join(folder, "words"), "".join('"' + word.replace('"', '\\"') + '"\n' for word in words))
    environment = dict(os.environ, ASAN_OPTIONS="detect_leaks=1", UBSAN_OPTIONS="print_stacktrace=1:halt_on_error=1",
                       OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_btl="self", PETSC_OPTIONS="")
    # The harness writes its input to a file of this folder.
    with open(os.path.join(folder, "log"), "w", encoding="utf-8") as log:
        status = subprocess.run([os.path.join(FOLDER, name), "corpus", f"-runs={runs}", "-seed=20", "-max_len=4000", "-dict=words", "-timeout=20", "-rss_limit_mb=3000",
                                 "-close_fd_mask=3", "-print_final_stats=1"], cwd=folder, env=environment, stderr=log, stdout=log, check=False).returncode
    with open(os.path.join(folder, "log"), encoding="utf-8", errors="replace") as log:
        text = log.read()
    figures = dict(re.findall(r"^stat::(\w+): +(\d+)", text, re.M))
    reached = re.findall(r"cov: (\d+)", text)
    found = [os.path.basename(path) for path in glob.glob(os.path.join(folder, "*-*"))]
    good = status == 0 and not found and int(figures.get("number_of_executed_units", 0)) >= runs
    print(f"{name}: {figures.get('number_of_executed_units')} inputs, {figures.get('average_exec_per_sec')} a second, {reached[-1] if reached else 0} branches reached, "
          f"peak {figures.get('peak_rss_mb')} MB, " + ("nothing found" if good else f"found {found}, exit status {status}: see {folder}/log"), flush=True)
    if not good:
        print("".join(line + "\n" for line in text.splitlines()[-60:] if re.search(r"ERROR|SUMMARY|runtime error|#\d+ |not one line|src/", line)))
    return good


names = []
good = [run("fuzz_options", INPUTS, option_words(), option_seeds),
        run("fuzz_model", max(1, INPUTS // 10), ["rate ", "method ", "from ", "migration[0].call", "1e-6", "inf", "nan", "-1"] + model_phases(), model_seeds)]
sys.exit(not all(good))
