#!/bin/sh
# On a bare Debian, as root: installs the source distribution that lies here, with the packages that the file
# `packages` names, and checks it. Prints how long that took.
set -eu
start=$(date +%s)
export DEBIAN_FRONTEND=noninteractive
apt-get -qq update
# shellcheck disable=SC2046  # several words
apt-get -qq install -y --no-install-recommends $(cat packages) >/tmp/apt.log 2>&1 || {
  tail -n 20 /tmp/apt.log
  exit 1
}
python3 --version
packages=$(date +%s)
python3 -m venv /tmp/env
/tmp/env/bin/pip install -q ./enfilade-*.tar.gz
echo "packages: $((packages - start)) s; pip install of the source distribution: $(($(date +%s) - packages)) s"
cd /tmp
exec /tmp/env/bin/python /given/check_wheel.py
