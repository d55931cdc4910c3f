#!/usr/bin/env bash
# For make install and make uninstall. `package.sh install PROGRAM` copies the program, the scenes, the tools that draw and
# the documents to these places below PREFIX (/usr/local), `package.sh uninstall` removes them:
#
#   bin/pebble
#   bin/pebble-plot, bin/pebble-movie, bin/pebble-study   links to tools/plot.py, tools/movie.py and lab/study.py
#   share/pebble/                       the rest, in the folders of the checkout, so that links between documents hold
#   share/pebble/installed              the list of the files and of the folders that were made for them
#
# DESTDIR, a folder where packagers collect the files, stands before PREFIX. An install first removes an earlier one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
umask 022
mode=${1:-}
PREFIX=${PREFIX:-/usr/local}
case $PREFIX in
  \~/*) PREFIX=$HOME/${PREFIX#\~/} ;; # a shell may leave the ~
  /*) ;;
  *) PREFIX=$PWD/$PREFIX ;;
esac
root=${DESTDIR:-}$PREFIX
list=$root/share/pebble/installed
made=()

fail() { echo "make $mode: $*" >&2; exit 1; }

# Makes what is missing of a folder's path below the prefix.
folder() {
  [ ! -d "$root/$1" ] || return 0
  [ "$1" = . ] || folder "$(dirname "$1")"
  mkdir -p "$root/$1"
  made+=("$1")
}

# put MODE FILE PLACE
put() {
  folder "$(dirname "$3")"
  install -m "$1" "$2" "$root/$3"
  made+=("$3")
}

# Removes the files of the list, what Python compiled of them, and the folders that are empty then; the others stay listed.
remove() {
  local name
  rm -rf "$root/share/pebble/tools/__pycache__" "$root/share/pebble/lab/__pycache__" "$root/share/pebble/lab/pebble_study/__pycache__"
  while read -r name; do
    if [ ! -d "$root/$name" ] || [ -L "$root/$name" ]; then rm -f "$root/$name"
    elif [ "$name" = . ]; then rmdir "$root" 2>/dev/null || made=(. "${made[@]}")
    else rmdir "$root/$name" 2>/dev/null || made=("$name" "${made[@]}"); fi
  done < <(tac "$list")
}

# Whoever installs needs the right to write to the nearest folder that exists.
writable() {
  local at=$root
  while [ ! -e "$at" ]; do at=$(dirname "$at"); done
  [ -d "$at" ] && [ -w "$at" ]
}

case $mode-$# in install-2 | uninstall-1) ;; *) echo "usage: tools/package.sh install PROGRAM | uninstall" >&2; exit 2 ;; esac
[ "$mode" = install ] || [ -f "$list" ] || fail "Pebble is not installed in $root"
writable || fail "cannot write to $root: use sudo make $mode, or a PREFIX of your own, such as \$HOME/.local"

[ ! -f "$list" ] || remove
[ "$mode" = install ] || { echo "Pebble was removed from $root"; exit 0; }

trap '[ ! -d "$root/share/pebble" ] || printf "%s\n" "${made[@]}" >"$list"' EXIT # also of an install that fails half-way
folder share/pebble
made+=(share/pebble/installed)
put 755 "$2" bin/pebble
for tool in tools/plot tools/movie lab/study; do
  put 755 "$tool.py" "share/pebble/$tool.py"
  ln -sf "../share/pebble/$tool.py" "$root/bin/pebble-${tool#*/}"
  made+=("bin/pebble-${tool#*/}")
done
while read -r file; do put 644 "$file" "share/pebble/$file"; done < <(
  printf '%s\n' tools/drawing.py tools/requirements.txt src/step/stable.def lab/pebble_mpm.py lab/pebble_study/*.py README.md LICENSE CITATION.cff CHANGELOG.md CONTRIBUTING.md
  find options docs tools/cluster -type f | sort)
echo "Pebble is in $root: bin/pebble, bin/pebble-plot, bin/pebble-movie, bin/pebble-study and share/pebble"
