# Part of enfilade.sh: what ctest's output comes to.
# shellcheck shell=bash

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
      told = last = ""
      reasons = 0
    }
    /^Output:$/ { inside = 1; next }
    /^<end of output>$/ {
      if (name in skipped) print reasons ? why[1] : told != "" ? told : gtest ? "no reason given" : last
      else for (k = 1; k <= reasons; ++k) print why[k]  # of a program that is one test of ctest
      inside = gtest = after = 0
    }
    !inside || /^-+$/ { next }
    /^\[  SKIPPED \]/ { gtest = 1; after = 0 }
    after && NF { after = 0; why[++reasons] = reason_of($0) }
    /: Skipped$/ { after = 1 }
    / are skipped: / && told == "" { told = $0; sub(/.* are skipped: /, "", told) }
    NF { last = $0 }
  ' "$1" "$2"
}

# tests_inside LAST_TEST_LOG: tests, failed and skipped ones of programs that ctest runs as one test, beyond that one.
tests_inside() {
  awk '
    /^\[==========\] Running/ { count = $3 }
    /^\[  SKIPPED \] all$/ { count = 0 }  # by tests/support/until.cpp: none of them ran
    /^\[  FAILED  \] [0-9]+ tests?, listed below/ { bad = $4 }
    /^\[  SKIPPED \] [0-9]+ tests?, listed below/ { left = $4 }
    /^<end of output>$/ {
      if (count > 1) { total += count - 1; failed += bad > 1 ? bad - 1 : 0; skipped += left }
      count = bad = left = 0
    }
    END { print total + 0, failed + 0, skipped + 0 }
  ' "$1"
}

# summarize CTEST_OUTPUT LAST_TEST_LOG: nothing if ctest ran no test (as with -N).
summarize() {
  local counts total failed skipped disabled reasons more_tests more_failed more_skipped
  counts=$(sed -n 's/^[0-9]*% tests passed, \([0-9]*\) tests* failed out of \([0-9]*\).*/\1 \2/p' \
    "$1" | tail -n 1)
  [[ -n $counts ]] || return 0
  read -r failed total <<<"$counts"
  read -r more_tests more_failed more_skipped < <(tests_inside "$2")
  reasons=$(skip_reasons "$1" "$2")
  skipped=$(grep -c '^'$'\t'' *[0-9]* - .* (Skipped)$' "$1") || true
  disabled=$(grep -c '^'$'\t'' *[0-9]* - .* (Disabled)$' "$1") || true
  total=$((total + more_tests)) failed=$((failed + more_failed)) skipped=$((skipped + more_skipped))
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
