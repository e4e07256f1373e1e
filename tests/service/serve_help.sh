#!/usr/bin/env bash
# `./enfilade.sh serve --help` says what the program says, without building or installing anything:
# serve_help.sh SOURCES PROGRAM. After a change of the options:
#   enfilade serve --help >tools/serve_help.txt
set -euo pipefail

tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
for name in cmake ninja npm node apt-get sudo python3; do
  printf '#!/bin/sh\necho "%s was run" >&2\nexit 9\n' "$name" >"$tools/$name"
  chmod +x "$tools/$name"
done
"$2" serve --help >"$tools/program.txt"
# By its version, CLI11 writes a default as "TEXT=8080" or "TEXT [8080]".
plain() {
  sed -E 's/ \[([^][ ]+)\]/=\1/; s/ +/ /g; s/ $//' "$1"
}
for option in --help -h; do
  PATH=$tools:$PATH "$1/enfilade.sh" serve "$option" >"$tools/script.txt"
  diff -u <(plain "$tools/program.txt") <(plain "$tools/script.txt")
done
