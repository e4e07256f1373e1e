# Part of enfilade.sh: what the machine lacks, and getting it from its package manager.
# shellcheck shell=bash

# What each job needs: job, package on Debian 12 and 13, and how to see that it is there
# on any other system (a command on the PATH, or a header that the compiler finds). A `wish` makes builds
# faster, or reads rare files: it is installed where that needs no password, and never missed.
readonly needs='
build g++                command c++
build cmake              command cmake
build ninja-build        command ninja
build mold               wish    -
build libsimdjson-dev    header  simdjson.h
build nlohmann-json3-dev header  nlohmann/json.hpp
build libtbb-dev         header  oneapi/tbb/parallel_for.h
build libfmt-dev         header  fmt/format.h
build libcli11-dev       header  CLI/CLI.hpp
build libnanoflann-dev   header  nanoflann.hpp
build zlib1g-dev         header  zlib.h
build pkg-config         command pkg-config
build libhwy-dev         header  hwy/highway.h
build libembree-dev      package -
build libtinygltf-dev    header  tiny_gltf.h
build libdraco-dev       wish    -
build libmeshoptimizer-dev wish  -
build libwebp-dev        wish    -
build librecast-dev      package -
build libkainjow-mustache-dev header kainjow/mustache.hpp
build libturbojpeg0-dev  header  turbojpeg.h
build libjpeg-dev        header  jpeglib.h
build libspng-dev        header  spng.h
build libzip-dev         header  zip.h
build libzstd-dev        header  zstd.h
build libxxhash-dev      header  xxhash.h
build libutf8proc-dev    header  utf8proc.h
build libepoxy-dev       header  epoxy/egl.h
build libegl-dev         header  EGL/egl.h
build libegl1            package -
build libegl-mesa0       package -
build libgl1-mesa-dri    package -
build node-d3            package -
build libtorch-dev       package -
build libgloo-dev        package -
build libopenblas0-pthread package -
build libhdf5-dev        package -
web   libcpp-httplib-dev header  httplib.h
web   libsqlitecpp-dev   header  SQLiteCpp/SQLiteCpp.h
web   libsqlite3-dev     header  sqlite3.h
web   libssl-dev         header  openssl/ssl.h
web   libpq-dev          package -
web   python3-venv       package -
test  libgtest-dev       header  gtest/gtest.h
test  libgmock-dev       header  gmock/gmock.h
python python3-venv      package -
python python3-dev       package -
python python3-torch     package -
docs  doxygen          command doxygen
docs  python3-venv     package -
bench libbenchmark-dev   header  benchmark/benchmark.h
cross cmake              command cmake
cross ninja-build        command ninja
cross pkg-config         command pkg-config
cross g++-aarch64-linux-gnu command aarch64-linux-gnu-g++
cross qemu-user          command qemu-aarch64
fuzz  clang-16           command clang++-16
fuzz  libclang-rt-16-dev package -
lint  clang-format-16    command clang-format-16
lint  clang-tidy-16      command clang-tidy-16
'

needs_of() {  # the rows of the jobs given
  local job
  for job in "$@"; do
    awk -v job="$job" '$1 == job' <<<"$needs"
  done
}

have_header() {
  printf '#if !__has_include(<%s>)\n#error missing\n#endif\n' "$1" |
    "${CXX:-c++}" -std=c++20 -x c++ -E - >/dev/null 2>&1
}

# Debian has these; where a system's lists do not (Ubuntu 24.04), what needs them is left out.
readonly wished='libtorch-dev libgloo-dev python3-torch mold libdraco-dev libmeshoptimizer-dev libwebp-dev'

lists_have() {
  # Not grep -q, which would end first and so fail the pipe.
  LC_ALL=C apt-cache policy "$1" 2>/dev/null | grep '^  Candidate: [^(]' >/dev/null
}

# Without any lists, as on a fresh machine, nothing is known.
is_out_of_reach() {
  [[ " $wished " == *" $1 "* ]] && lists_have g++ && ! lists_have "$1"
}

have_package() {
  [[ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" == installed* ]]
}

# A program counts wherever it comes from: CMake from PyPI, or clang as c++, need no root.
missing_packages() {
  local package kind name
  needs_of "$@" | while read -r _ package kind name; do
    have_package "$package" || { [[ $kind == command ]] && command -v "$name" >/dev/null; } ||
      is_out_of_reach "$package" || { [[ $kind == wish ]] && ! can_install; } || printf '%s\n' "$package"
  done
}

missing_elsewhere() {
  local kind name
  needs_of "$@" | while read -r _ _ kind name; do
    case $kind in
      command) command -v "$name" >/dev/null || printf '%s\n' "$name" ;;
      header) have_header "$name" || printf '<%s>\n' "$name" ;;
    esac
  done
}

can_install() {  # without a password
  [[ $(id -u) == 0 ]] || sudo -n true 2>/dev/null
}

as_root() {  # runs the command as root, without ever asking for a password
  if [[ $(id -u) == 0 ]]; then "$@"; else sudo -n "$@"; fi
}

apt_get() {
  # A lock held by the machine's own updates is waited for; a mirror may drop a connection.
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -q -y -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" </dev/null
}

install_packages() {  # install_packages LOG PACKAGE...
  local log=$1 attempt package packages
  shift
  for attempt in 1 2 3; do
    if apt_get update >"$log" 2>&1; then
      packages=()
      for package in "$@"; do
        is_out_of_reach "$package" || packages+=("$package")
      done
      apt_get install --no-install-recommends "${packages[@]}" >>"$log" 2>&1 && return 0
    fi
    # apt-get update only warns of a mirror out of reach, and then the lists lack everything.
    if ! grep -q 'Failed to fetch' "$log" &&
      grep -qE 'Unable to locate package|no installation candidate' "$log"; then
      say "some of these packages are not in this system's lists (on Ubuntu they need 'universe')"
      return 1
    fi
    [[ $attempt == 3 ]] || { say "apt-get failed; trying again"; sleep $((attempt * 5)); }
  done
  return 1
}

# ensure_packages WHY JOB...: makes the machine ready for these jobs, silent if it is so already.
ensure_packages() {
  local why=$1 missing line log
  shift
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    ensure_elsewhere "$why" "$@"
    return
  fi
  missing=$(missing_packages "$@" | sort -u | tr '\n' ' ')
  missing=${missing% }
  [[ -n $missing ]] || return 0
  line="apt-get install --no-install-recommends $missing"
  if ! can_install; then
    say "to $why, this machine lacks packages, and installing them needs root. Please run:"
    die 3 "  sudo $line"
  fi
  say "installing with apt-get, to $why: $missing"
  mkdir -p build
  log=build/packages.log
  # Word splitting makes the list of names one argument each.
  # shellcheck disable=SC2086
  if ! install_packages "$log" $missing; then
    tail -n 20 "$log" >&2
    say "apt-get could not install them (all of its output: $log). Please see to:"
    die 3 "  $line"
  fi
}

ensure_elsewhere() {
  local why=$1 missing
  shift
  missing=$(missing_elsewhere "$@" | tr '\n' ' ')
  [[ -n $missing ]] || return 0
  say "to $why, Enfilade needs these (by their names in Debian and Ubuntu):" \
    "$(needs_of "$@" | awk '{ printf "%s ", $2 }')"
  die 3 "this is neither Debian nor Ubuntu, so nothing is installed here; not found: $missing"
}

ensure_cmake_version() {
  local have
  have=$(cmake --version | awk 'NR == 1 { print $3 }')
  [[ "$(printf '%s\n' 3.25 "$have" | sort -V | head -n 1)" == 3.25 ]] ||
    die 3 "CMake 3.25 or newer is needed; $(command -v cmake) is $have"
}
