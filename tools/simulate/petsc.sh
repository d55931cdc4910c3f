#!/usr/bin/env bash
# This script builds PETSc for the simulator into build/simulate/petsc: static, with SimGrid's smpicc in place of an MPI.
# It does so once, in about six minutes on two cores; it is silent and quick when PETSc is there already.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
version=3.26.1
sha256=a4dc46c1b4403545ac2274741ce10801366c4a9a7b2683b678d18f6663b93496
folder=build/simulate/petsc
arch=smpi
jobs=$(nproc)

say() { echo "petsc.sh: $*" >&2; }
# Runs a command with its output in a log, whose end is shown if it fails.
logged() {
  local log=$1
  shift
  "$@" >"$log" 2>&1 || { tail -n 20 "$log" >&2; say "failed: see $log"; exit 1; }
}

wanted="$version $sha256 $(smpirun -version)"
[ "$(cat "$folder/built" 2>/dev/null)" = "$wanted" ] && exit 0
rm -rf "$folder"
mkdir -p "$folder"

echo "downloading the source of PETSc $version"
source=build/simulate/petsc-$version.tar.gz
sound() { echo "$sha256  $source" | sha256sum --check --status 2>/dev/null; }
sound || logged build/simulate/download.log .venv/bin/python -m pip download --no-deps --no-binary :all: \
  --disable-pip-version-check --dest build/simulate "petsc==$version"
sound || { say "$source is not the file that this was written for: its checksum differs"; exit 1; }
tar -xzf "$source" -C "$folder" --strip-components 1

echo "building PETSc $version for the simulator, about six minutes: build/simulate/configure.log, make.log"
cd "$folder"
# SMPI_PRETEND_CC: configure runs what it compiles, and a program of SMPI does not run by itself.
# SMPI_NO_OVERRIDE_MALLOC: PETSc's own malloc does not compile with SMPI's in its place.
# --with-shared-libraries=0: the simulator gives each process its own copy of the globals of the program, not of a
# library. So PETSc is static, and it is position-independent since SMPI loads the program as a library.
logged ../configure.log env -u PETSC_DIR -u PETSC_ARCH SMPI_PRETEND_CC=1 nice -n 19 ./configure PETSC_ARCH=$arch \
  --with-cc=smpicc --with-cxx=0 --with-fc=0 --with-debugging=0 --with-shared-libraries=0 --with-mpiexec=/bin/false \
  CFLAGS='-fPIC -DSMPI_NO_OVERRIDE_MALLOC' COPTFLAGS='-O3' --with-strict-petscerrorcode=0 \
  --with-x=0 --with-hdf5=0 --with-python=0 --with-ssl=0 --with-valgrind=0 --with-pthread=0
logged ../make.log nice -n 19 make PETSC_DIR="$PWD" PETSC_ARCH=$arch libs MAKE_NP="$jobs"
echo "$wanted" >built
