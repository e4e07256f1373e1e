#!/usr/bin/env bash
# A machine without our libraries is told of all of them at once, with one line that installs them.
#   tests/install/missing.sh SOURCE
set -euo pipefail
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
# What CMake's own files and pkg-config would find is hidden.
if PKG_CONFIG_LIBDIR=/nonexistent PKG_CONFIG_PATH='' cmake -S "$1" -B "$build" -G Ninja \
  -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON -DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON -DEN_BUILD_TESTS=OFF \
  -DEN_WITH_TORCH=OFF -DEN_WITH_WEB=ON >"$build/log" 2>&1; then
  echo "configuring did not fail"
  exit 1
fi
for wanted in 'not on this machine: fmt, ' 'CLI11' 'libzip, ' 'httplib' \
  'apt-get install --no-install-recommends libfmt-dev .*libzip-dev .*libcpp-httplib-dev .*libcli11-dev'; do
  tr -s '\n ' ' ' <"$build/log" | grep -qE -- "$wanted" || {
    cat "$build/log"
    echo "the message has no '$wanted'"
    exit 1
  }
done
