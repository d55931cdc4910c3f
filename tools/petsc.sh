#!/usr/bin/env bash
# This script builds a PETSc of Pebble's own, once; it is silent and quick when that PETSc is there already.
#   petsc.sh mpi       into build/petsc/petsc, with the system's MPI, HDF5 and LAPACK, PETSC_ARCH=opt: make test-petsc
#   petsc.sh simulate  into build/simulate/petsc, static, with SimGrid in place of an MPI, PETSC_ARCH=smpi: make simulate
# It takes about six minutes on two cores. The source is the release below, which pip downloads. Instead PETSC_SRC may
# name a folder or a .tar.gz with the source of a release: of another one, or where nothing can be downloaded.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
version=3.26.1
sha256=a4dc46c1b4403545ac2274741ce10801366c4a9a7b2683b678d18f6663b93496
source=${PETSC_SRC:-build/petsc/petsc-$version.tar.gz}

say() { echo "petsc.sh: $*" >&2; }
# Runs a command with its output in the log, whose end is shown if it fails.
logged() { "$@" >>"$log" 2>&1 || { tail -n 20 "$log" >&2; say "failed: see $log"; exit 1; }; }

common=(--with-cxx=0 --with-fc=0 --with-debugging=0 COPTFLAGS=-O3 --with-strict-petscerrorcode=0
        --with-x=0 --with-python=0 --with-ssl=0 --with-valgrind=0)
case ${1:-} in
mpi)
  folder=build/petsc/petsc arch=opt
  pkgconfig=${PKG_CONFIG:-pkg-config}
  for module in hdf5-openmpi hdf5-mpich hdf5; do "$pkgconfig" --exists $module && break; done
  # The first word of pkg-config's answer is HDF5's own; the others are the MPI's, which mpicc knows.
  hdf5() { PKG_CONFIG_ALLOW_SYSTEM_CFLAGS=1 PKG_CONFIG_ALLOW_SYSTEM_LIBS=1 "$pkgconfig" "$1" $module | cut -d ' ' -f 1; }
  include=$(hdf5 --cflags-only-I)
  with=(--with-cc=mpicc --with-hdf5-include="${include#-I}" --with-hdf5-lib="$(hdf5 --libs-only-L) -lhdf5")
  tools="$(mpicc --version | head -n 1), $(mpiexec --version | head -n 1)" ;;
simulate)
  folder=build/simulate/petsc arch=smpi
  # SMPI_PRETEND_CC: configure runs what it compiles, and a program of SMPI does not run by itself.
  # SMPI_NO_OVERRIDE_MALLOC: PETSc's own malloc does not compile with SMPI's in its place.
  # --with-shared-libraries=0: the simulator gives each process its own copy of the globals of the program, not of a
  # library. So PETSc is static, and it is position-independent since SMPI loads the program as a library.
  export SMPI_PRETEND_CC=1
  with=(--with-cc=smpicc --with-shared-libraries=0 --with-mpiexec=/bin/false --with-hdf5=0 --with-pthread=0
        CFLAGS='-fPIC -DSMPI_NO_OVERRIDE_MALLOC')
  tools=$(smpirun -version) ;;
*) echo "usage: tools/petsc.sh mpi|simulate" >&2; exit 2 ;;
esac

# ---- Is it there already? A folder with a source is known by its path and version.
if [ -z "${PETSC_SRC:-}" ]; then release="$version $sha256"
elif [ -f "$source/include/petscversion.h" ]; then release="$source $(md5sum <"$source/include/petscversion.h")"
elif [ -f "$source" ]; then release="$source $(md5sum <"$source")"
else say "PETSC_SRC=$source is no source of PETSc: neither a folder with include/petscversion.h nor a .tar.gz"; exit 1; fi
wanted="$release, $tools"
[ "$(cat "$folder/built" 2>/dev/null)" = "$wanted" ] && exit 0
rm -rf "$folder"
mkdir -p "$folder" build/petsc
log=$(dirname "$folder")/petsc.log
: >"$log"

# ---- The source
if [ -z "${PETSC_SRC:-}" ]; then
  sound() { echo "$sha256  $source" | sha256sum --check --status 2>/dev/null; }
  if ! sound; then
    echo "downloading the source of PETSc $version"
    logged .venv/bin/python -m pip download --no-deps --no-binary :all: --disable-pip-version-check --dest build/petsc \
      "petsc==$version"
    sound || { say "$source is not the file that this was written for: its checksum differs"; exit 1; }
  fi
fi
if [ -d "$source" ]; then tar -cf - -C "$source" --exclude-vcs . | tar -xf - -C "$folder"
else tar -xzf "$source" -C "$folder" --strip-components 1; fi

# ---- Configure and build
echo "building PETSc from $source, about six minutes: $log"
log=$PWD/$log
cd "$folder"
unset PETSC_DIR PETSC_ARCH
logged nice -n 19 ./configure PETSC_ARCH=$arch "${common[@]}" "${with[@]}"
logged nice -n 19 make PETSC_DIR="$PWD" PETSC_ARCH=$arch libs MAKE_NP="$(nproc)"
echo "$wanted" >built
