/// \file  SOON's files, as released (github.com/ZhuFengdaaa/SOON) and as DUET reads them.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `<split>.json` as released: entries with several alternative paths. Each alternative
/// becomes a path of its own, with id `<split number>-<running number>` as in DUET's files
/// (numbers: train 0, val_seen_instrs 1, val_unseen_instrs 2, val_unseen_house 3, test 4; other
/// splits 9); its path_id is the running number, its group the entry. Instruction k of an entry is
/// its list of five texts: name, attribute, relation, region (details' fields `obj_name`,
/// `attribute`, `relation`, `region`), and the whole, which is the text. Goals are NamedBoxes;
/// hidden where there are no `bboxes`. The scan is that of the boxes, or the entry's own `scan`.
/// The heading is 1.52, with which DUET evaluates. \throws InvalidInput listing its faults with
/// JSON paths: missing or wrongly typed fields, no path, an empty path, boxes of two scans, angles
/// that are not finite, instructions that are no lists of five
Annotations parse_soon(std::string_view json, const std::string& file, std::string split);

/// The same of DUET's lines (`<split>_enc.jsonl`, `<split>_enc_pseudo_obj_label.jsonl`): a path a
/// line, `instructions` a list of objects, `instr_encodings` with the same keys (that of `full`
/// becomes the tokens).
Annotations parse_soon_lines(std::string_view lines, const std::string& file, std::string split);

/// Lines in DUET's form, which parse_soon_lines() reads back equal.
std::string to_soon_lines(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
