#!/usr/bin/env bash
# A module that is removed from the sources cannot be imported from a build any more: cmake/mirror_folder.cmake.
#   tests/install/mirror_folder.sh SOURCE
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mirror() { cmake -DFROM="$work/from" -DTO="$work/to" -DBUILT=_core.so,_eyes.so -P "$1/cmake/mirror_folder.cmake"; }

expect() {  # expect FILE...: what lies in the copy
  local found
  found=$(cd "$work/to" && find . -mindepth 1 | LC_ALL=C sort | tr '\n' ' ')
  if [[ $found != "$* " ]]; then
    printf 'expected: %s\nbut the copy has: %s\n' "$*" "$found"
    exit 1
  fi
}

mkdir -p "$work"/from/{gym,old,__pycache__} "$work/to"
touch "$work"/from/{__init__.py,gone.py,gym/envs.py,old/module.py,__pycache__/gone.pyc} "$work/to/_core.so"
mirror "$1"
expect ./__init__.py ./_core.so ./gone.py ./gym ./gym/envs.py ./old ./old/module.py

mkdir "$work"/to/{,old/}__pycache__  # as Python makes them
touch "$work"/to/{_learn.so,old/__pycache__/module.pyc}
rm -r "$work"/from/{gone.py,old}
echo "new = 1" >"$work/from/gym/envs.py"
mirror "$1"
expect ./__init__.py ./__pycache__ ./_core.so ./gym ./gym/envs.py
cmp "$work"/{from,to}/gym/envs.py
