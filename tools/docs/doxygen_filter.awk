# Doxygen takes the word after \file for a file's name, and reads no Markdown in that line. In this house the comment follows
# at once: so the name is put there, and code in backticks becomes HTML.
FNR == 1 && /\\file / {
  n = split(FILENAME, part, "/")
  sub(/\\file +/, "\\file " part[n - 2] "/" part[n - 1] "/" part[n] " ")
  while (match($0, /`[^`]*`/)) {
    code = substr($0, RSTART + 1, RLENGTH - 2)
    gsub(/</, "\\&lt;", code)
    gsub(/>/, "\\&gt;", code)
    $0 = substr($0, 1, RSTART - 1) "<code>" code "</code>" substr($0, RSTART + RLENGTH)
  }
}
{ print }
