"""Every row of a table that a user chooses from is reachable: -help lists its name among the values of its option, and its
parameters as options. And options files that name other files: which value counts, and that results overwrite none of
them.

usage: test_options.py PEBBLE SOURCE MPIEXEC
"""
import os
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
    known = [columns(row) for row in table("physics/reference.def", "MPM_REFERENCE")]
    for option, flag, more in (("mms_type", "PETSC_TRUE", []), ("reference_type", "PETSC_FALSE", ["expression", "finest"])):
        named = ["none"] + [row[0] for row in known if row[1] == flag] + more
        check.that(sorted(named) == sorted(values(text, option)), f"-{option} takes {' '.join(named)}")
    check.need(len(known) == len(values(text, "mms_type")) + len(values(text, "reference_type")) - 4,
               "a known solution is of neither kind")
    words = [row[2] for row in map(columns, table("output/diagnostics.def", "MPM_PARTICLE_QUANTITY")) if row[2]]
    check.that(sorted(words + ["grid"]) == sorted(values(text, "output_fields")), f"-output_fields takes {' '.join(words)} grid")


def scene(name, *lines):
    return check.write(name, [f"-options_file {check.scene('disks')}", *lines])


def included():
    """A file may change what a file that it names has set; two lines of one file may not contradict each other."""
    check.must("-options_file", scene("over.opts", "-time_end 0.01"))
    end = check.rows("output/over.csv")[-1]["time"]
    check.that(float(end) == 0.01, f"the file that names another overrides it: time_end {end}")
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
        run = check.pebble(*words, *([] if "-study_type" in words else ["-time_max_steps", "1"]))
        check.that(run.status == 2 and "would overwrite the options file" in run.err and len(run.lines) == 1 and check.content(path) == before,
                   f"{what}: {run.lines}")

    check.folder("kept")
    shutil.copy(check.scene("disks"), "kept/inner.h5")
    with open("kept/main.opts", "w", encoding="utf-8") as file:
        file.write("-options_file kept/inner.h5\n")
    refused("a file that another names", "kept/inner.h5", "-options_file", "kept/main.opts", "-output_dir", "kept", "-output_name", "inner")
    os.symlink("inner.h5", "kept/link.csv")
    refused("a file by a link", "kept/inner.h5", "-options_file", "kept/main.opts", "-output_dir", "kept", "-output_name", "link")
    shutil.copy(check.scene("mms"), "kept/mms_study.csv")
    refused("the table of a study", "kept/mms_study.csv", "-options_file", "kept/mms_study.csv", "-output_dir", "kept", "-output_name", "mms",
            "-study_type", "convergence")
    run = check.must("-options_file", "kept/main.opts", "-output_dir", "kept", "-time_max_steps", "1")
    check.that(run.good and os.path.exists("kept/main.h5"), "other names beside it are free")


if __name__ == "__main__":
    check.arguments(__doc__, 0)
    vocabulary()
    included()
    kept()
    check.end()
