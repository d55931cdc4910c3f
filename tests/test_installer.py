"""tools/install.sh --dry-run on systems that are made up: it names the packages that are missing, and says which are too old, absent
or, without apt-get, what to look for.

usage: test_installer.py PEBBLE SOURCE MPIEXEC
"""
import os
import shutil
import subprocess

import check

check.arguments(__doc__, 0)
TOOLS = "bash env cut dirname echo grep head id mktemp rm sed sort tail xargs".split()
RUN = "gcc libc6-dev make pkg-config libpetsc-real-dev libopenmpi-dev openmpi-bin libhdf5-openmpi-dev libmuparser-dev"
# What apt-cache tells: versions that these systems have, and one with a second Python.
DEBIAN13 = {"libpetsc-real-dev": "3.22.5+dfsg1-2", "python3": "3.13.5-1"}
UBUNTU24 = {"libpetsc-real-dev": "3.19.6+dfsg1-2.2ubuntu2", "python3": "3.12.3-0ubuntu2"}
UBUNTU22 = {"libpetsc-real-dev": "3.15.5+dfsg1-1build2", "python3": "3.10.6-1~22.04"}


def system(name, versions, mode="run", root=True):
    """The installer on a system of this name with nothing installed. versions: of packages (None: there is none; packages that are
    not named have one), or no apt-get at all."""
    folder = check.folder("system")
    for path in ("etc", "bin", "pebble/tools"):
        os.makedirs(os.path.join(folder, path))
    for tool in TOOLS:
        os.symlink(shutil.which(tool), os.path.join(folder, "bin", tool))
    for file in ("install.sh", "requirements.txt", "requirements-test.txt"):
        shutil.copy(os.path.join(check.source, "tools", file), os.path.join(folder, "pebble", "tools"))
    check.write(os.path.join(folder, "etc", "os-release"), f'PRETTY_NAME="{name}"\n')
    programs = {}
    if versions is not None:
        told = "".join(f'{package}) echo "  Candidate: {version or "(none)"}" ;; ' for package, version in versions.items())
        programs["apt-cache"] = f'case $2 in {told} *) echo "  Candidate: 1:2.0-1" ;; esac'
        programs["apt-get"] = "exit 9"  # a dry run must not call it
    if not root:
        programs["id"] = "echo 1000"
    for program, text in programs.items():
        path = os.path.join(folder, "bin", program)
        if os.path.exists(path):
            os.remove(path)
        check.write(path, f"#!{shutil.which('bash')}\n{text}\n")
        os.chmod(path, 0o755)
    folder = os.path.abspath(folder)
    done = subprocess.run([os.path.join(folder, "pebble/tools/install.sh"), mode, *(["--dry-run"] if root else [])], capture_output=True, text=True,
                          env={"PATH": os.path.join(folder, "bin"), "SYSTEM": folder, "HOME": folder})
    return check.Run(done.returncode, done.stdout, done.stderr)


def installs(run, packages):
    check.that(run.status == 0 and not run.err and run.out.splitlines()[0] == f"would install with apt-get: {packages}", f"{run.said.strip()}")


def refuses(run, *wanted):
    check.that(run.status == 1 and not run.out and all(want in run.err for want in wanted), f"{run.err.strip()}")


installs(system("Debian GNU/Linux 13 (trixie)", DEBIAN13), f"{RUN} python3 python3-venv")
installs(system("Ubuntu 24.04.1 LTS", UBUNTU24, mode="test"), f"{RUN} python3 python3-venv cmake clang")
installs(system("Ubuntu 24.04.1 LTS", UBUNTU24, mode="fuzz"), f"{RUN} python3 python3-venv clang libclang-rt-dev")
installs(system("a system with two Pythons", DEBIAN13 | {"python3": "3.10.6-1", "python3.13": None, "python3.12": None, "python3.11": "3.11.0-1"}),
         f"{RUN} python3.11 python3.11-venv")
refuses(system("Ubuntu 22.04.4 LTS", UBUNTU22), "install.sh: libpetsc-real-dev of Ubuntu 22.04.4 LTS is 3.15.5; Pebble needs PETSc 3.18 or newer", "PETSC_DIR")
old = dict.fromkeys(("python3.13", "python3.12", "python3.11"))
refuses(system("Debian GNU/Linux 11", DEBIAN13 | {"python3": "3.9.2-3"} | old), "python3 of Debian GNU/Linux 11 is 3.9.2; Pebble needs Python 3.11 to 3.14")
refuses(system("Ubuntu without universe", UBUNTU24 | {"libmuparser-dev": None}), "knows no package libmuparser-dev (muParser", "add-apt-repository universe")
run = system("Fedora Linux 43", None)
refuses(run, "Fedora Linux 43 has no apt-get", "libpetsc-real-dev", "pkg-config: petsc or PETSc", "Python 3.11 to 3.14")
check.that(len(run.err.splitlines()) == 1 + len(RUN.split()) + 2, f"{len(run.err.splitlines())} lines: a package each")
refuses(system("Debian GNU/Linux 13 (trixie)", DEBIAN13, root=False), f"sudo apt-get install --no-install-recommends {RUN} python3 python3-venv")
check.end()
