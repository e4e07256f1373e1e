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

for part in packages environments sysroot summary; do
  # shellcheck source=/dev/null
  source "tools/$part.sh"
done

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
                                (none: two model homes are made and served, if ENFILADE_DATA
                                is not set); `serve --help` needs no build
  build [--preset P] [--web]    build; programs are left in build/P/bin/ (P is release);
                                --web: with the web server, as serve does
  test  [--preset P] [ARGS]     build and run the tests; ARGS go to ctest, as in -R NavGraph
        --quick [--web]         unit tests only: no Python, browser, training, documentation;
                                --web: with the web server's
  docs  [ARGS]                  build the documentation: build/docs/index.html; with the examples'
                                output where a build has them; ARGS go to tools/docs/site.py
  bench [ARGS]                  build and run the benchmarks; ARGS go to each of them
  lint  [--fix] [FILES]         clang-format, clang-tidy, shell scripts, commit subjects (all, or FILES);
                                --fix lays the sources out instead of complaining
  help                          this text

Each command first installs what it needs and the machine lacks, from the packages of Debian 12 or 13
(Ubuntu 24.04: untested); it asks for nothing. Presets (CMakePresets.json):
release, dev, ci, asan, tsan, fuzz, and aarch64, which compiles for 64-bit ARM on another machine and
tests in qemu-user.

environment:
  ENFILADE_DATA                 folder of the real data; demo and test use it where it is set
  CI                            not empty: test takes the preset ci (warnings are errors)
  VERBOSE=1                     show all that the builds print; else it is in build/P/build.log
  CMAKE_BUILD_PARALLEL_LEVEL    compilers at a time, instead of as many as cores and memory allow
HELP
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

# Says so where the disk has little room: what a compiler or linker then says has many forms.
tell_space() {
  local preset=$1 needed=6144 folder free
  [[ $preset != release ]] || needed=1024
  for folder in build "${TMPDIR:-/tmp}"; do
    free=$(df -Pk "$folder" 2>/dev/null | awk 'NR == 2 { print int($4 / 1024) }') || free=
    if [[ -n $free ]] && ((free < needed)); then
      say "the disk of $folder has $free MiB left, and a whole build takes up to $needed:" \
        "if it fails, make room there, or set TMPDIR (for /tmp) to a folder on another disk"
    fi
    needed=512  # what two compilers leave in the folder for temporary files, at most
  done
}

# build_preset PRESET [CMAKE ARGS]: configures and builds `targets`, or all if it is empty. Nothing is
# said if all is up to date.
targets=()
build_preset() {
  local preset=$1 directory log jobs steps launcher only=()
  shift
  directory=build/$preset
  log=$directory/build.log
  ensure_cmake_version
  mkdir -p "$directory"
  : >"$log"
  launcher=${CMAKE_CXX_COMPILER_LAUNCHER-$(command -v ccache || true)}
  if command -v apt-cache >/dev/null && is_out_of_reach libtorch-dev && ! have_package libtorch-dev &&
    [[ -z ${Torch_DIR:-}${Torch_ROOT:-}${CMAKE_PREFIX_PATH:-} ]]; then
    grep -qs '^EN_WITH_TORCH:[A-Z]*=OFF' "$directory/CMakeCache.txt" ||
      say "this system's packages have no libtorch-dev: building without networks and training" \
        "(if you have libtorch, name its folder in CMAKE_PREFIX_PATH)"
    set -- -DEN_WITH_TORCH=OFF "$@"
  fi
  log_to "$log" cmake --preset "$preset" "-DCMAKE_CXX_COMPILER_LAUNCHER:STRING=$launcher" "$@" || {
    show_failure "$log"
    die 1 "configuring the preset '$preset' failed (all of its output: $log)"
  }
  # Not of build.ninja itself, whose dry run ends at its first step, the check of cmake's globs.
  steps=$(ninja -C "$directory" -f /dev/stdin -n ${targets[@]+"${targets[@]}"} <<<'include build.ninja' |
    sed -n 's|^\[[0-9]*/\([0-9]*\)\].*|\1|p' | tail -n 1)
  [[ -n $steps ]] || return 0
  jobs=$(job_count)
  tell_space "$preset"
  say "building in $directory ($steps steps, $jobs at a time: $(duration_of "$steps" "$jobs"))"
  ((${#targets[@]} == 0)) || only=(--target "${targets[@]}")
  log_to "$log" cmake --build "$directory" --parallel "$jobs" ${only[@]+"${only[@]}"} || {
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
        (($# > 1)) || die 2 "--preset wants a name: release, dev, ci, asan, tsan, fuzz or aarch64"
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
    release | dev | ci | asan | tsan | fuzz | aarch64) ;;
    *) die 2 "no preset '$preset'; there are release, dev, ci, asan, tsan, fuzz and aarch64" ;;
  esac
}

command_build() {
  local preset rest argument arguments=() server=()
  for argument in "$@"; do
    if [[ $argument == --web ]]; then
      server=(-DEN_WITH_WEB=ON)
    else
      arguments+=("$argument")
    fi
  done
  parse_preset release ${arguments[@]+"${arguments[@]}"}
  ((${#rest[@]} == 0)) || die 2 "build takes no argument '${rest[0]}'; see ./enfilade.sh help"
  case $preset in
    release) ensure_packages "build Enfilade" build ;;
    fuzz) ensure_packages "build Enfilade's fuzzers" build fuzz ;;
    aarch64) ensure_aarch64 ;;
    *) ensure_packages "build Enfilade and its tests" build test ;;
  esac
  ((${#server[@]} == 0)) || ensure_web
  build_preset "$preset" ${server[@]+"${server[@]}"}
}

ensure_aarch64() {
  ensure_packages "build Enfilade for ARM" cross
  ensure_sysroot build/sysroot-aarch64
}

ensure_web() {
  ensure_packages "build Enfilade with its web server" build web
  ensure_pages || die 3 "without Node.js 20.19 or newer, npm and its registry, there can be no pages"
}

command_serve() {
  case ${1:-} in
    -h | --help)  # what the program says, kept here: nobody waits for a build to read it
      cat tools/serve_help.txt
      return
      ;;
  esac
  ensure_web
  build_preset release -DEN_WITH_WEB=ON
  cd "$caller"
  exec "$root/build/release/bin/enfilade" serve "$@"
}

command_demo() {
  targets=(enfilade)  # with what it starts; the tools and benchmarks can wait
  command_build
  cd "$caller"
  exec "$root/build/release/bin/enfilade" demo "$@"
}

# --- testing --------------------------------------------------------------------------------------

command_test() {
  local preset=release rest python=(-DEN_BUILD_PYTHON=OFF) web=OFF
  [[ -z "${CI:-}" ]] || preset=ci
  parse_preset "$preset" "$@"
  [[ $preset != fuzz ]] || die 2 "the preset 'fuzz' has no tests: its programs are run by hand"
  if [[ " ${rest[*]-} " == *" --quick "* ]]; then
    command_test_quick "$preset" "${rest[@]}"
  fi
  if [[ $preset == aarch64 ]]; then
    command_test_aarch64 ${rest[@]+"${rest[@]}"}
  fi
  ensure_packages "build and test Enfilade" build web test python docs
  if ensure_python; then
    python=(-DEN_BUILD_PYTHON=ON "-DPython_EXECUTABLE=$root/build/python/bin/python")
    if ensure_torch_python; then
      python+=("-DEN_TORCH_PYTHON=$root/build/python-torch/bin/python")
    else
      say "the examples in Python that need PyTorch are not tested"
    fi
  fi
  if ensure_docs; then
    python+=("-DEN_DOCS_PYTHON=$root/build/docs-python/bin/python")
  else
    say "the documentation is not built"
  fi
  if ensure_pages; then
    web=ON
  else
    say "the web server and its pages are not tested"
  fi
  build_preset "$preset" -DEN_BUILD_TESTS=ON -DEN_BUILD_EXAMPLES=ON "-DEN_WITH_WEB=$web" "${python[@]}"
  run_tests "$preset" ${rest[@]+"${rest[@]}"}
}

# What was built of Python and the pages stays so; only their tests are left out.
command_test_quick() {
  local preset=$1 argument rest=() server=()
  shift
  for argument in "$@"; do
    case $argument in
      --quick) ;;
      --web) server=(-DEN_WITH_WEB=ON) ;;
      *) rest+=("$argument") ;;
    esac
  done
  if [[ $preset == aarch64 ]]; then
    ensure_aarch64
  else
    ensure_packages "build Enfilade and its unit tests" build test
  fi
  ((${#server[@]} == 0)) || ensure_web
  build_preset "$preset" -DEN_BUILD_TESTS=ON ${server[@]+"${server[@]}"}
  run_tests "$preset" --label-exclude slow ${rest[@]+"${rest[@]}"}
}

# Without the Python package, which this machine's Python could not load.
command_test_aarch64() {
  local web=OFF
  ensure_aarch64
  if ensure_pages; then
    web=ON
  else
    say "the web server is not tested"
  fi
  build_preset aarch64 "-DEN_WITH_WEB=$web"
  run_tests aarch64 "$@"
}

# run_tests PRESET [CTEST ARGS]: exits with ctest's status
run_tests() {
  local preset=$1 status=0
  shift
  say "testing build/$preset${ENFILADE_DATA:+ with the data of $ENFILADE_DATA}"
  # The summary of a run that failed is the one that is wanted most.
  # One more than the cores: tests of servers and processes wait for most of their time.
  # One thread for OpenMP (libtorch, PyTorch): those of several tests would wait for each other, spinning.
  OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} ctest --preset "$preset" --parallel "$(($(job_count) + 1))" "$@" 2>&1 |
    tee "build/$preset/test.log" || status=$?
  summarize "build/$preset/test.log" "build/$preset/Testing/Temporary/LastTest.log"
  exit "$status"
}

# --- documentation --------------------------------------------------------------------------------

command_docs() {
  local build python arguments=(-o build/docs)
  ensure_packages "build the documentation" docs
  ensure_docs || die 3 "without what tools/docs/requirements.txt lists, there can be no site"
  for build in build/ci build/release build/dev; do  # of the first that has examples they are run
    [[ -d $build/examples ]] || continue
    arguments+=(--build "$build")
    for python in build/python{,-torch}/bin/python; do
      [[ ! -x $python ]] || arguments+=(--python "$python")
    done
    break
  done
  build/docs-python/bin/python -B tools/docs/site.py "${arguments[@]}" "$@"
}

# --- benchmarks and lint --------------------------------------------------------------------------

conditions() {  # what a figure is worth nothing without
  local compiler commit=unknown
  compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' build/release/CMakeCache.txt)
  if git rev-parse --git-dir >/dev/null 2>&1; then
    commit=$(git describe --always --abbrev=12 --dirty 2>/dev/null || echo 'none yet')
  fi
  printf 'machine:  %s, %s cores\n' \
    "$(LC_ALL=C lscpu 2>/dev/null | sed -n 's/^Model name: *//p' | head -n 1)" \
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

# Subjects since the first commit under the rule (CONTRIBUTING.md): at most 72 characters.
lint_subjects() {
  local first=14a86d58
  git rev-parse -q --verify "$first^{commit}" >/dev/null 2>&1 || return 0
  ! git log --no-merges --format='%h %s' "$first..HEAD" | awk 'length($0) - length($1) - 1 > 72' | grep .
}

lint_tidy() {  # lint_tidy FILE...: clang-tidy on these sources of the preset ci, or on all of ours
  local log=build/ci/tidy.log ours="^$root/(enfilade|apps|bench|examples|python|tests)/"
  log_to build/ci/build.log cmake --preset ci -DEN_BUILD_BENCH=ON -DEN_UNITY=OFF \
    -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON || {
    show_failure build/ci/build.log
    return 1
  }
  (($# > 0)) || set -- "$ours"  # nanobind is compiled from its sources
  # Flags that only GCC knows are no fault of the source. Nor is what lies outside of it: libtorch's own
  # headers are no C++20 to clang 16 (vectors of incomplete types), after which it reads on.
  run-clang-tidy-16 -quiet -p build/ci -j "$(job_count)" -extra-arg=-Wno-unknown-warning-option \
    "$@" >"$log" 2>&1 || true
  grep -q '^clang-tidy-16 ' "$log" || { tail -n 20 "$log" >&2; return 1; }
  ! grep -E -A 4 "${ours}[^ ]*: (warning|error): |^error: " "$log"
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
  say "commit subjects"
  lint_subjects || status=1
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
    docs) command_docs "$@" ;;
    bench) command_bench "$@" ;;
    lint) command_lint "$@" ;;
    help | --help | -h) show_help ;;
    *) die 2 "no command '$command'; see ./enfilade.sh help" ;;
  esac
}

main "$@"
