#!/usr/bin/env bash
# This script installs what is missing: `install.sh run` for building and running, `install.sh test` for the tests too,
# `install.sh viewers` for the tests and ParaView, `install.sh simulate` for running and for the simulator,
# `install.sh fuzz` for make fuzz, `install.sh petsc` for the tests with a PETSc that is built from source. With --dry-run behind it, it only says what it would install.
# It is silent and quick when nothing is missing. It installs system packages where there is apt-get, as root or with a sudo
# that asks no password; elsewhere it says what to install. The names are the same in Debian 12 and 13 and in Ubuntu 24.04
# and 26.04; apt-cache tells whether a system's versions are new enough. The Python packages go to .venv.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mode=${1:-run}
dry=${2:-}
usage() { echo "usage: tools/install.sh run|test|viewers|simulate|fuzz|petsc [--dry-run]" >&2; exit 2; }
case $mode in run | test | viewers | simulate | fuzz | petsc) ;; *) usage ;; esac
case $dry in '' | --dry-run) ;; *) usage ;; esac
pkgconfig=${PKG_CONFIG:-pkg-config}

has()    { command -v "$1" >/dev/null 2>&1; }
module() { local m; for m; do "$pkgconfig" --exists "$m" 2>/dev/null && return; done; return 1; }
say()    { echo "install.sh: $*" >&2; }

# Can clang link libFuzzer with the sanitizers?
fuzzes() {
  has clang && echo 'int LLVMFuzzerTestOneInput(const char *d, unsigned long n); int LLVMFuzzerTestOneInput(const char *d, unsigned long n) { return d && n > 1u << 31; }' |
    clang -x c -fsanitize=fuzzer,address,undefined -o /dev/null - 2>/dev/null
}

# Finds the first Python of 3.11 to 3.14 (the pinned packages have wheels for these) that can make a venv.
usable_python() {
  local p
  for p in python3 python3.{13,12,11,14} "${SYSTEM:-}/usr/bin/python3"; do
    "$p" -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null || continue
    command -v "$p" && return
  done
  return 1
}

# The version of a package that apt-get would install, without epoch and revision; nothing where it knows none.
candidate() { LC_ALL=C apt-cache policy "$1" 2>/dev/null | sed -n 's/^ *Candidate: \([0-9]*:\)\{0,1\}\([0-9][0-9.]*\).*/\2/p'; }
older()     { [ "$1" != "$2" ] && [ "$(printf '%s\n' "$1" "$2" | sort -V | head -n 1)" = "$1" ]; }

# Prints the packages of a Python that usable_python takes.
python_packages() {
  local p v
  for p in python3 python3.{13,12,11}; do
    v=$(candidate "$p")
    if [ -n "$v" ] && ! older "$v" 3.11 && older "$v" 3.15; then break; fi
    p=python3
  done
  printf '%s\n' "$p" "$p-venv"
}

# What a package is, for whoever looks for it on another system.
what() {
  case $1 in
  gcc) echo "a C compiler" ;;
  libc6-dev) echo "the headers of the C library" ;;
  make) echo "GNU make 4" ;;
  pkg-config) echo "pkg-config" ;;
  libpetsc-real-dev) echo "PETSc 3.18 or newer with its headers, real scalars in double precision (pkg-config: petsc or PETSc); or set PETSC_DIR and PETSC_ARCH" ;;
  libopenmpi-dev) echo "the MPI that PETSc was built with: its compiler wrapper mpicc" ;;
  openmpi-bin) echo "the same MPI's mpiexec" ;;
  libhdf5-openmpi-dev) echo "HDF5, built with that MPI (pkg-config: hdf5-openmpi, hdf5-mpich or hdf5)" ;;
  libmuparser-dev) echo "muParser (pkg-config: muparser)" ;;
  python3*-venv) echo "its modules venv and ensurepip" ;;
  python3 | python3.*) echo "Python 3.11 to 3.14" ;;
  cmake) echo "CMake 3.18 or newer" ;;
  clang) echo "the compiler clang" ;;
  libclang-rt*) echo "libFuzzer and the sanitizers of clang" ;;
  paraview) echo "ParaView" ;;
  python3-paraview) echo "its pvpython" ;;
  xvfb) echo "Xvfb, a screen in memory" ;;
  libsimgrid-dev) echo "SimGrid with SMPI: smpicc and smpirun" ;;
  liblapack-dev) echo "LAPACK (pkg-config: lapack)" ;;
  libblas-dev) echo "BLAS (pkg-config: blas)" ;;
  esac
}

venv_works() { [ -x .venv/bin/python ] && [ -d .venv/installed ]; }

# Prints the packages that are missing, by their names in Debian and Ubuntu, one a line.
missing() {
  has gcc || printf '%s\n' gcc libc6-dev
  has make || echo make
  has "$pkgconfig" || echo pkg-config
  if [ -z "${PETSC_DIR:-}" ]; then
    [ "$mode" = petsc ] || module "petsc >= 3.18" "PETSc >= 3.18" || echo libpetsc-real-dev
    has mpicc || echo libopenmpi-dev
    has mpiexec || echo openmpi-bin
    module hdf5-openmpi hdf5-mpich hdf5 || echo libhdf5-openmpi-dev
  else # use that PETSc's own MPI, and its own HDF5 if it has one
    local pc=$PETSC_DIR/${PETSC_ARCH:-}/lib/pkgconfig/petsc.pc cc lib
    cc=$("$pkgconfig" --variable=ccompiler "$pc" 2>/dev/null) || cc=
    lib=$("$pkgconfig" --variable=libdir "$pc" 2>/dev/null) || lib=
    has "${cc:-mpicc}" || echo libopenmpi-dev
    has "$(dirname "${cc:-.}")/mpiexec" || has mpiexec || echo openmpi-bin
    [ -e "$lib/libhdf5.so" ] || module hdf5-openmpi hdf5-mpich hdf5 || echo libhdf5-openmpi-dev
  fi
  module muparser || echo libmuparser-dev
  venv_works || usable_python >/dev/null || python_packages
  if [ "$mode" = test ] || [ "$mode" = viewers ] || [ "$mode" = petsc ]; then
    has ctest || echo cmake
    has clang || echo clang
  fi
  if [ "$mode" = fuzz ]; then # libFuzzer and the sanitizers of clang are a package of the same version
    if ! has clang; then printf '%s\n' clang libclang-rt-dev
    elif ! fuzzes; then echo "libclang-rt-$(clang -dumpversion | cut -d. -f1)-dev"; fi
  fi
  if [ "$mode" = viewers ] && ! has pvpython; then
    printf '%s\n' paraview python3-paraview xvfb
  fi
  if [ "$mode" = simulate ]; then
    has smpicc && has smpirun || echo libsimgrid-dev
  fi
  if [ "$mode" = simulate ] || [ "$mode" = petsc ]; then
    module lapack || echo liblapack-dev
    module blas || echo libblas-dev
  fi
}

# ---- system packages
if [ -n "${PETSC_DIR:-}" ] && has "$pkgconfig" && ! module "$PETSC_DIR/${PETSC_ARCH:-}/lib/pkgconfig/petsc.pc"; then
  say "PETSC_DIR=$PETSC_DIR with PETSC_ARCH=${PETSC_ARCH:-} has no lib/pkgconfig/petsc.pc;" \
      "correct them, or unset both to use the system's PETSc"
  exit 1
fi

# shellcheck disable=SC1091 # a file of the system
system=$(. "${SYSTEM:-}/etc/os-release" 2>/dev/null && echo "${PRETTY_NAME:-}") || true
system=${system:-this system}
packages=$(missing | xargs)
if [ -n "$packages" ]; then
  if [ "$(id -u)" = 0 ]; then root=(env)
  elif has sudo && sudo -n true 2>/dev/null; then root=(sudo -n env)
  else root=(); fi
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  apt() {
    "${root[@]}" DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 "$@" </dev/null >>"$log" 2>&1 ||
      { tail -n 20 "$log" >&2; say "apt-get $1 failed; it was to install $packages"; exit 1; }
  }
  if ! has apt-get; then
    say "$system has no apt-get. Install these, here with the names that they have in Debian and Ubuntu, then try again:"
    for package in $packages; do printf '  %-20s %s\n' "$package" "$(what "$package")" >&2; done
    exit 1
  fi
  if [ -z "$dry" ] && [ ${#root[@]} -gt 0 ]; then
    apt update
    packages=$(missing | xargs)
  fi
  for package in $packages; do
    version=$(candidate "$package")
    if [ -z "$version" ]; then
      say "apt-get of $system knows no package $package ($(what "$package"));" \
          "sudo apt-get update renews its lists, and in Ubuntu sudo add-apt-repository universe adds the section that has it"
      exit 1
    fi
    case $package in
    libpetsc-real-dev) older "$version" 3.18 || continue ;;
    python3) older "$version" 3.11 || ! older "$version" 3.15 || continue ;;
    *) continue ;;
    esac
    say "$package of $system is $version; Pebble needs $(what "$package")"
    exit 1
  done
  if [ -n "$dry" ]; then
    echo "would install with apt-get: $packages"
  elif [ ${#root[@]} = 0 ]; then
    say "sudo asks for a password here, or is not there; install what is missing, then try again:"
    say "sudo apt-get install --no-install-recommends $packages"
    exit 1
  else
    echo "installing $packages"
    # shellcheck disable=SC2086 # one word a package
    apt install -y --no-install-recommends $packages
    hash -r
    packages=$(missing | xargs)
    if [ -n "$packages" ]; then
      say "installed, but still missing or too old: $packages (PETSc must be 3.18 or newer, Python 3.11 to 3.14)"
      exit 1
    fi
  fi
fi

# ---- Python packages; .venv/installed/ keeps the lists of packages that .venv has
lists=(tools/requirements.txt)
[ "$mode" = test ] || [ "$mode" = viewers ] || [ "$mode" = petsc ] && lists+=(tools/requirements-test.txt)
[ "$mode" = viewers ] && lists+=(tools/requirements-viewers.txt)
for list in "${lists[@]}"; do
  venv_works && cmp -s "$list" ".venv/installed/${list##*/}" && continue
  if [ -n "$dry" ]; then
    echo "would install in .venv the Python packages of $list"
    continue
  fi
  if ! venv_works; then
    echo "making .venv"
    rm -rf .venv
    "$(usable_python)" -m venv .venv
    mkdir .venv/installed
  fi
  echo "installing the Python packages of $list"
  .venv/bin/python -m pip install --quiet --disable-pip-version-check -r "$list" ||
    { say "pip could not install the packages of $list"; exit 1; }
  cp "$list" .venv/installed/
done
