"""links: links of the documents lead to files and sections that exist, and README.md leads to every document.
words: codespell finds no misspelling in documents, scenes and sources, and what users read is in British spelling.

usage: test_documents.py PEBBLE SOURCE MPIEXEC links|words
"""
import collections
import glob
import os
import re
import subprocess
import sys

import check

(part,) = check.arguments(__doc__, 1)
HERE = os.getcwd()
os.chdir(check.source)
DOCUMENTS = sorted(glob.glob("*.md") + glob.glob("docs/**/*.md", recursive=True) + ["output/README.md"])


def read(path):
    with open(path) as file:
        return file.read()


def prose(text):
    """A document without code: no blocks of code, and nothing in backticks."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    text = re.sub(r"(?<=\n\n)(?:(?: {4}|\t).*\n+)+", "", text)
    return re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", "code", text, flags=re.S)


# ---- Links

def anchors(text):
    """Names of the sections, as GitHub makes them of the headings, and of HTML elements."""
    names, seen = set(re.findall(r'\b(?:id|name)="([^"]+)"', text)), collections.Counter()
    for heading in re.findall(r"^#{1,6} +(.*?) *#*$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M):
        heading = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        names.add(name + (f"-{seen[name]}" if seen[name] else ""))
        seen[name] += 1
    return names


def links(path, text):
    """Targets of the links and pictures of a document."""
    if path.endswith(".html"):
        return re.findall(r'\b(?:href|src)="([^"]+)"', text)
    text = prose(text)
    return re.findall(r"\]\(\s*<?([^)\s>]+)", text) + re.findall(r"^ {0,3}\[[^]]+\]: *(\S+)", text, re.M) + re.findall(r'\b(?:href|src)="([^"]+)"', text)


def wrong_links(path, text):
    """The links that lead nowhere."""
    lost = []
    for target in links(path, text):
        if re.match(r"(https?|mailto|data):", target):
            continue
        place, _, section = target.partition("#")
        file = os.path.normpath(os.path.join(os.path.dirname(path), place)) if place else path
        inside = file == path or not os.path.isabs(place) and not file.startswith("..") and os.path.exists(file)
        if not inside or section and section not in anchors(text if file == path else read(file)):
            lost.append(target)
    return lost


def all_links():
    number, leads = 0, {}
    for path in DOCUMENTS:
        text = read(path)
        leads[path] = {os.path.normpath(os.path.join(os.path.dirname(path), target.partition("#")[0])) for target in links(path, text)}
        number += len(links(path, text))
        lost = wrong_links(path, text)
        check.fault(lost and f"{path}: {' '.join(lost)}")
    check.that(number > 200, f"{number} links of {len(leads)} documents")
    reached, new = set(), {"README.md"}
    while new:
        reached |= new
        new = set().union(*(leads.get(path, ()) for path in new)) - reached
    for path in [*DOCUMENTS, *glob.glob("docs/*.png")]:
        check.fault(None if path in reached or path.startswith(("output/", "docs/data/")) else f"no link leads from README.md to {path}")
    text = "# One: `a_b` (c)\n# One\n# One\n\n[a](#one-a_b-c) [b](#one-1) `[code](nosuch.md)`\n\n    [code](nosuch.md)\n\n```\n[code](nosuch.md)\n```\n"
    check.that(not wrong_links("x.md", text), f"links that are right are taken: {wrong_links('x.md', text)}")
    wrong = ["nosuch.md", "docs/nosuch.png", "README.md#nosuch", "#one-2", "../README.md", "/etc/passwd", "docs"]
    found = wrong_links("x.md", "# One\n# One\n" + " ".join(f"[a]({target})" for target in wrong) + "\n\n[b]: nosuch.html\n")
    check.that(found == wrong[:-1] + ["nosuch.html"], f"links that are wrong are found: {found}")


# ---- Words

def codespell(*words):
    """What codespell finds, a line each."""
    command = [sys.executable, "-m", "codespell_lib", "--ignore-words", "tests/words.txt", *words]
    done = subprocess.run(command, capture_output=True, text=True)
    check.need(done.returncode in (0, 65) and not done.stderr, f"codespell: {done.stderr}")
    return done.stdout.splitlines()


def read_by_users():
    """What users read: documents without quotations and addresses, comments of scenes, texts of the program, usages of tools."""
    for path in DOCUMENTS:
        yield path, re.sub(r'\]\([^)]*\)|https?://\S+|"[^"]*"', "]", prose(read(path)))
    for path in glob.glob("options/*.opts") + glob.glob("tools/*/*.opts"):
        yield path, "\n".join(re.findall(r"#\s(?!.*(?:\./pebble|\.venv))(.*)", read(path)))
    for path in glob.glob("src/*/*.c") + glob.glob("src/*/*.h") + glob.glob("src/*/*.def"):
        yield path, "\n".join(re.findall(r'"((?:[^"\\\n]|\\.)*[a-z]{2} [a-z](?:[^"\\\n]|\\.)*)"', read(path)))
    for path in glob.glob("tools/*.py") + glob.glob("lab/**/*.py", recursive=True):
        yield path, "\n".join(re.findall(r'"""(.*?)"""', read(path), re.S) + re.findall(r'help="([^"]*)"', read(path)))


def american():
    """A dictionary of codespell from American to British spelling, from its own of the other way."""
    import codespell_lib
    pairs = {}
    for line in read(os.path.join(os.path.dirname(codespell_lib.__file__), "data", "dictionary_en-GB_to_en-US.txt")).splitlines():
        british, _, there = line.partition("->")
        for word in there.strip(" ,").split(","):
            pairs.setdefault(word.strip(), british)
    return check.write(os.path.join(HERE, "american.txt"), "".join(f"{word}->{british}\n" for word, british in pairs.items()))


def all_words():
    sources = DOCUMENTS + ["makefile", "CITATION.cff"] + [path for folder in ("options", "src", "examples", "tests", "tools", "lab", ".ci") for path in glob.glob(f"{folder}/**", recursive=True)
                           if os.path.isfile(path) and not path.endswith((".csv", ".stl", ".pyc", ".npz"))]
    found = [line for line in codespell("--builtin", "clear", *sources) if not line.startswith("tests/test_documents.py:")]
    check.that(not found, f"words of {len(sources)} files: {found}")
    dictionary, copies = american(), os.path.join(HERE, "copies")
    check.folder(copies)
    for path, text in read_by_users():
        check.write(os.path.join(copies, path.replace("/", ":")), text)
    found = codespell("-D", dictionary, copies)
    check.that(not found and len(os.listdir(copies)) > 100, f"British spelling in {len(os.listdir(copies))} files: {found}")
    check.write(os.path.join(copies, "wrong.md"), "The colour is seperate from the neighbor\n")
    found = codespell("--builtin", "clear", os.path.join(copies, "wrong.md")) + codespell("-D", dictionary, os.path.join(copies, "wrong.md"))
    check.that([re.search(r": (\w+) ==>", line)[1] for line in found] == ["seperate", "neighbor"], f"words that are wrong are found: {found}")


{"links": all_links, "words": all_words}[part]()
check.end()
