#!/usr/bin/env bash
# Each verb and each option is explained in at most twelve words: help_lines.sh PROGRAM.
# "(default: ...)" does not count, and a list of values ("a, b or c") counts as one word.
set -euo pipefail

program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Prints "text<TAB>name" of the verb itself, "option ..." and "verb ..." lines of a help page.
cat >"$folder/entries.awk" <<'AWK'
function flush() {
  sub(/^ +/, "", text)
  if (name != "") print kind "\t" name "\t" text
  name = ""
}
/^Usage:/ { print "itself\t\t" about; begun = 1; next }
!begun { about = about " " $0; next }
/^[A-Z][A-Za-z ]*:$/ {
  flush()
  section = $0
  kind = section ~ /^(Positionals|Options):$/ ? "option" : "verb"
  next
}
/^$/ || section ~ /^(|Examples:|Forms:)$/ { next }
/^  [^ ]/ {  # a name of up to 33 columns has its text beside it, a longer one below
  flush()
  name = $0
  text = ""
  if (length($0) > 34 && substr($0, 34, 1) == " ") {
    name = substr($0, 1, 34)
    text = substr($0, 35)
  }
  gsub(/^ +| +$/, "", name)
  next
}
/^                    / { text = text " " $0; next }
/^[^ ]/ { flush(); section = "" }
END { flush() }
AWK

cat >"$folder/count.awk" <<'AWK'
BEGIN { FS = "\t" }
function count(text,    from, at, depth, parts, n, i, words) {
  while ((from = index(text, "(default")) > 0) {
    depth = 0
    for (at = from; at <= length(text); at++) {
      depth += (substr(text, at, 1) == "(") - (substr(text, at, 1) == ")")
      if (depth == 0) break
    }
    text = substr(text, 1, from - 1) substr(text, at + 1)
  }
  gsub(/[^ ,;:()]+(, [^ ,;:()]+)+,? (or|and) [^ ,;:()]+/, "LIST", text)
  gsub(/[^ ,;:()]+, [^ ,;:()]+(, [^ ,;:()]+)+/, "LIST", text)
  n = split(text, parts, " ")
  for (i = 1; i <= n; i++) words += parts[i] ~ /[A-Za-z]/
  return words + 0
}
count($3) > 12 {
  print "enfilade" verb " --help: " $2 ": " count($3) " words, at most 12: " $3
}
$3 ~ /^ *$/ { print "enfilade" verb " --help: " $2 ": no text" }
AWK

pages=0
check() {
  local page
  if ! page=$("$program" "$@" --help 2>"$folder/error"); then
    grep -q enfilade-learn "$folder/error" && return  # a build without libtorch
    echo "enfilade $* --help fails: $(cat "$folder/error")"
    return
  fi
  pages=$((pages + 1))
  printf '%s\n' "$page" | awk -f "$folder/entries.awk" >"$folder/entries"
  awk -v verb="${*:+ $*}" -f "$folder/count.awk" "$folder/entries"
  local names name
  names=$(awk -F '\t' '$1 == "verb" { print $2 }' "$folder/entries")
  for name in $names; do check "$@" "$name"; done
}
check >"$folder/faults"
cat "$folder/faults"
if [[ $pages -lt 30 ]]; then
  echo "$pages pages of help were found, 30 or more are expected"
  exit 1
fi
[[ ! -s $folder/faults ]]
