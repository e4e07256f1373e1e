#!/usr/bin/env bash
# The unit of docs/service_operating.md is one that systemd takes: unit.sh docs/service_operating.md PROGRAM
set -euo pipefail

if ! command -v systemd-analyze >/dev/null; then
  echo "no systemd-analyze on this machine"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
awk '/^\[Unit\]/ {inside = 1} /^```/ {if (inside) exit} inside' "$1" |
  sed "s|/usr/local/bin/enfilade|$2|" >"$folder/enfilade.service"
grep -q "^ExecStart=$2 serve" "$folder/enfilade.service"
said=$(systemd-analyze verify "$folder/enfilade.service" 2>&1) || {
  echo "$said"
  exit 1
}
# It warns, and succeeds, where it ignores a line.
if grep -F "$folder" <<<"$said"; then exit 1; fi
