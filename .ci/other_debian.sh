#!/usr/bin/env bash
# Builds everything that ./enfilade.sh test builds on the Debian that this machine is not (12 or 13), in a bare root
# of its own, and runs the quick tests there. Skipped, with the reason, where no root can be made. Called by .ci/run,
# or by hand.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

skip() { echo "the other Debian is skipped: $*"; exit 0; }

[[ $(id -u) == 0 ]] || skip "a root of it needs root"
command -v debootstrap >/dev/null || apt-get install -y -q debootstrap >/dev/null 2>&1 || skip "no debootstrap here"
suite=trixie
! grep -q '^VERSION_CODENAME=trixie' /etc/os-release || suite=bookworm

# What outlives the run: the bare root, and compiled objects by their input.
kept=${XDG_CACHE_HOME:-$HOME/.cache}/enfilade-ci
clone=$(mktemp -d)
trap 'rm -rf "$clone"' EXIT
git clone -q . "$clone/enfilade"
echo "testing on a bare $suite"
export ROOTS=$kept/roots CACHE=$kept/$suite CI=
exec_in() { packaging/bare_root.sh "$suite" "$clone/enfilade" "$@"; }
exec_in apt-get update -q >/dev/null || skip "no root of $suite can be made, or it reaches no mirror"
exec_in sh -c 'apt-get update -q >/dev/null && apt-get install -q -y ccache >/dev/null 2>&1
  ccache --max-size 3G >/dev/null; ./enfilade.sh test --quick --web'
