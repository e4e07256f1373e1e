#!/usr/bin/env python3
"""Prints enfilade/models/vocabularies/unicode_tables.h from the Unicode data of this Python."""
import unicodedata

LAST = 0x110000
HANGUL = range(0xAC00, 0xD7A4)


def ranges(wanted):
    """First and last code points of runs that are wanted."""
    found, start = [], None
    for code in range(LAST + 1):
        if code < LAST and wanted(unicodedata.category(chr(code))):
            start = code if start is None else start
        elif start is not None:
            found.append((start, code - 1))
            start = None
    return found


def lower_case():
    """(first, last, step, how far down) of runs of letters with a lower case of one character."""
    pairs = [(c, ord(chr(c).lower())) for c in range(LAST)
             if chr(c).lower() != chr(c) and len(chr(c).lower()) == 1]
    runs, at = [], 0
    while at < len(pairs):
        end = {}
        for step in (1, 2):
            end[step] = at
            while end[step] + 1 < len(pairs):
                (a, low_a), (b, low_b) = pairs[end[step]], pairs[end[step] + 1]
                if b != a + step or low_b - b != low_a - a:
                    break
                end[step] += 1
        step = 1 if end[1] >= end[2] else 2
        runs.append((pairs[at][0], pairs[end[step]][0], step, pairs[at][1] - pairs[at][0]))
        at = end[step] + 1
    return runs


def bases():
    """(code, what is left of it without accents, up to three characters)."""
    found = []
    for code in range(LAST):
        whole = unicodedata.normalize('NFD', chr(code))
        rest = [ord(x) for x in whole if unicodedata.category(x) != 'Mn']
        if code in HANGUL or whole == chr(code) or not rest:
            continue
        found.append((code, *rest, *[0] * (3 - len(rest))))
    return found


def table(name, kind, comment, rows):
    print(f'// {comment}\ninline constexpr std::array<{kind}, {len(rows)}> {name}{{{{')
    line = ''
    for row in rows:
        text = '{' + ','.join(str(x) if x < 0 else f'0x{x:x}' for x in row) + '},'
        if len(line) + len(text) > 100:
            print(line)
            line = ''
        line += text
    print(f'{line}}}}};\n')


print(f'''/// \\file  What BERT's rules ask of characters: Unicode {unicodedata.unidata_version}, as
/// tools/unicode_tables.py prints it. Sorted by code point.
#pragma once
#include <array>
#include <cstdint>

namespace enfilade::models::vocabularies {{

// clang-format off
struct CodeRange {{ std::uint32_t first, last; }};
struct LowerCase {{ std::uint32_t first, last, step; std::int32_t shift; }};
struct Bases {{ std::uint32_t code; std::array<std::uint32_t, 3> bases; }};
''')
table('kMarks', 'CodeRange', 'Category Mn: accents and the like.', ranges(lambda c: c == 'Mn'))
table('kPunctuation', 'CodeRange', 'Categories P.', ranges(lambda c: c[0] == 'P'))
table('kControls', 'CodeRange', 'Categories Cc, Cf, Co, Cs.',
      ranges(lambda c: c in ('Cc', 'Cf', 'Co', 'Cs')))
table('kLowerCase', 'LowerCase', 'Letters at every step from first to last: add shift.',
      lower_case())
rows = bases()
print('// What canonical decomposition (NFD) leaves without marks; 0: no character. Hangul is computed.')
print(f'inline constexpr std::array<Bases, {len(rows)}> kBases{{{{')
line = ''
for code, *rest in rows:
    text = f'{{0x{code:x},{{{",".join(f"0x{x:x}" for x in rest if x)}}}}},'
    if len(line) + len(text) > 100:
        print(line)
        line = ''
    line += text
print(f'''{line}}}}};
// clang-format on

}}  // namespace enfilade::models::vocabularies''')
