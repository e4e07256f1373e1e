#!/usr/bin/env bash
# Installs a build into a new folder, and builds and runs the project beside this script against it.
# usage: run.sh BUILD_DIR     where BUILD_DIR is a finished build of Enfilade
# ENFILADE_HEADERS_ALONE=1: each header is compiled alone too.
set -euo pipefail

(($# == 1)) || { echo "usage: run.sh BUILD_DIR" >&2; exit 2; }
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cached() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log" ||
  { cat "$work/install.log"; exit 1; }

# A static library with sanitizers wants them in the program too.
sanitize=$(cached EN_SANITIZE)

# Compiled for another machine, the project is too, and runs emulated.
cross=() run=()
toolchain=$(cached CMAKE_TOOLCHAIN_FILE)
if [[ -n $toolchain ]]; then
  sysroot=$(cached EN_SYSROOT)
  cross=(-DCMAKE_TOOLCHAIN_FILE="$toolchain" -DEN_SYSROOT="$sysroot" -DCMAKE_FIND_ROOT_PATH="$work/prefix")
  run=("$(cached EN_QEMU)" -L "$sysroot")
fi
cmake -S "$here" -B "$work/build" -G "$(cached CMAKE_GENERATOR)" \
  -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_BUILD_TYPE="$(cached CMAKE_BUILD_TYPE)" -DEACH_ALONE="${ENFILADE_HEADERS_ALONE:-0}" \
  -DCMAKE_CXX_COMPILER="$(cached CMAKE_CXX_COMPILER)" \
  -DCMAKE_CXX_FLAGS="${sanitize:+-fsanitize=$sanitize}" ${cross[@]+"${cross[@]}"}
cmake --build "$work/build"

if grep -rlF -e "$build" "$work/prefix" --include='*.cmake'; then
  echo "these files of the installed package name the build folder, which its users do not have"
  exit 1
fi

expected=$'a b c 7.0 m\n1 fault'
output=$(${run[@]+"${run[@]}"} "$work/build/consumer")
if [[ $output != "$expected" ]]; then
  printf 'expected:\n%s\nbut the program printed:\n%s\n' "$expected" "$output"
  exit 1
fi
printf '%s\n' "$output"

mkdir "$work/graphs"
output=$(${run[@]+"${run[@]}"} "$work/build/old_code" "$work/graphs")
if [[ $output != 'c after 2 steps' ]]; then
  printf 'expected: c after 2 steps\nbut the program printed:\n%s\n' "$output"
  exit 1
fi
