#!/usr/bin/env bash
# This script installs what is missing: `install.sh run` for building and running, `install.sh test` for the tests too,
# `install.sh viewers` for the tests and ParaView, `install.sh simulate` for running and for the simulator, `install.sh report` for running and for the report.
# It is silent and quick when nothing is missing. It installs system packages on Debian and systems derived from it, as
# root or with a sudo that asks no password; elsewhere it says what to install. The Python packages go to .venv.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mode=${1:-run}
case $mode in run | test | viewers | simulate | report) ;; *) echo "usage: tools/install.sh run|test|viewers|simulate|report" >&2; exit 2 ;; esac
pkgconfig=${PKG_CONFIG:-pkg-config}

has()    { command -v "$1" >/dev/null 2>&1; }
module() { local m; for m; do "$pkgconfig" --exists "$m" 2>/dev/null && return; done; return 1; }
say()    { echo "install.sh: $*" >&2; }

# Finds the first Python of 3.11 to 3.14 (the pinned packages have wheels for these) that can make a venv.
usable_python() {
  local p
  for p in python3 python3.{13,12,11,14} /usr/bin/python3; do
    "$p" -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null || continue
    command -v "$p" && return
  done
  return 1
}

venv_works() { [ -x .venv/bin/python ] && [ -d .venv/installed ]; }

# Prints the Debian packages that are missing, one a line.
missing() {
  has gcc || printf '%s\n' gcc libc6-dev
  has make || echo make
  has "$pkgconfig" || echo pkg-config
  if [ -z "${PETSC_DIR:-}" ]; then
    module "petsc >= 3.18" "PETSc >= 3.18" || echo libpetsc-real-dev
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
  venv_works || usable_python >/dev/null || printf '%s\n' python3 python3-venv
  if [ "$mode" = test ] || [ "$mode" = viewers ]; then
    has ctest || echo cmake
    has clang || echo clang
  fi
  if [ "$mode" = viewers ] && ! has pvpython; then
    printf '%s\n' paraview python3-paraview
  fi
  if [ "$mode" = simulate ]; then
    has smpicc && has smpirun || echo libsimgrid-dev
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

packages=$(missing | xargs)
if [ -n "$packages" ]; then
  if [ "$(id -u)" = 0 ]; then root=(env)
  elif has sudo && sudo -n true 2>/dev/null; then root=(sudo -n env)
  else root=(); fi
  if ! has apt-get || [ ${#root[@]} = 0 ]; then
    say "missing, by their Debian names: $packages"
    say "install them (PETSc 3.18 or newer, with parallel HDF5; Python 3.11 to 3.14), then try again"
    exit 1
  fi
  echo "installing $packages"
  log=$(mktemp)
  apt() { "${root[@]}" DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 "$@" </dev/null >>"$log" 2>&1; }
  # shellcheck disable=SC2086 # one word a package
  if ! { apt update; apt install -y --no-install-recommends $packages; }; then
    tail -n 20 "$log" >&2
    say "apt-get could not install $packages"
    rm -f "$log"
    exit 1
  fi
  rm -f "$log"
  hash -r
  packages=$(missing | xargs)
  if [ -n "$packages" ]; then
    say "installed, but still missing or too old: $packages (PETSc must be 3.18 or newer, Python 3.11 to 3.14)"
    exit 1
  fi
fi

# ---- Python packages; .venv/installed/ keeps the lists of packages that .venv has
lists=(tools/requirements.txt)
[ "$mode" = test ] || [ "$mode" = viewers ] && lists+=(tools/requirements-test.txt)
[ "$mode" = viewers ] && lists+=(tools/requirements-viewers.txt)
[ "$mode" = report ] && lists+=(tools/requirements-report.txt)
for list in "${lists[@]}"; do
  venv_works && cmp -s "$list" ".venv/installed/${list##*/}" && continue
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
