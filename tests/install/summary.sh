#!/usr/bin/env bash
# The summary of a test run counts the tests inside programs that ctest runs as one test, and gives each reason.
#   tests/install/summary.sh SOURCE
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# shellcheck source=/dev/null
source "$1/tools/summary.sh"

# alone_test: one of one is skipped. whole_test: of five, one is skipped and two fail. late_test: none of four began.
printf '%s\n' '33% tests passed, 1 tests failed out of 3' >"$work/output"
printf '\t  1 - Alone.IsSkipped (Skipped)\n\t  3 - late_test (Skipped)\n' >>"$work/output"
cat >"$work/log" <<'LOG'
1/3 Testing: Alone.IsSkipped
Output:
----------------------------------------------------------
[==========] Running 1 test from 1 test suite.
alone_test.cpp:1: Skipped
no card
[  SKIPPED ] Alone.IsSkipped (0 ms)
[  SKIPPED ] 1 test, listed below:
<end of output>
2/3 Testing: whole_test
Output:
----------------------------------------------------------
[==========] Running 5 tests from 1 test suite.
whole_test.cpp:1: Skipped
no disk
[  SKIPPED ] Whole.WantsADisk (0 ms)
all others are skipped: no, they are not
[  SKIPPED ] 1 test, listed below:
[  FAILED  ] 2 tests, listed below:
<end of output>
3/3 Testing: late_test
Output:
----------------------------------------------------------
[==========] Running 4 tests from 1 test suite.
until.cpp: Skipped
the time is over
[  SKIPPED ] all
until.cpp:1: Skipped
the time is over
<end of output>
LOG
expected='
Summary
  passed       2
  failed       2
  skipped      3
        1 the time is over
        1 no disk
        1 no card
2 passed, 2 failed, 3 skipped'
found=$(summarize "$work/output" "$work/log")
if [[ $found != "$expected" ]]; then
  printf 'expected: %s\nbut it says: %s\n' "$expected" "$found"
  exit 1
fi
