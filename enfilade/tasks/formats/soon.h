/// \file  SOON's files, as released (github.com/ZhuFengdaaa/SOON) and as DUET reads them.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `<split>.json` as released: entries with several alternative paths. Each alternative
/// becomes a path of its own, with id `<split number>-<running number>` as in DUET's files
/// (numbers: train 0, val_seen_instrs 1, val_unseen_instrs 2, val_unseen_house 3, test 4; other
/// splits 9). Its path_id is the running number, its group the entry.
///
/// Instruction k of an entry is its list of five texts: name, attribute, relation, region, and the
/// whole, which is the text. The first four become the details' fields `obj_name`, `attribute`,
/// `relation`, `region`. An `instr_id` is kept: InstructionDetails::entry.
///
/// Goals are NamedBoxes; hidden without `bboxes`, or if the list is empty. A box has its `target`;
/// its own `heading` and `elevation`, and `mouse_*`, are ignored. The scan is that of the boxes, or
/// the entry's own `scan`. The heading is 1.52, with which DUET evaluates.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, no path, an empty path
/// - two scans in one entry, a repeated instr_id
/// - instructions that are not lists of five
/// - alternatives that repeat more than 2 GiB of their entries
Annotations parse_soon(std::string_view json, const std::string& file, std::string split);

/// The same for DUET's lines (`<split>_enc.jsonl`, `<split>_enc_pseudo_obj_label.jsonl`), one path
/// per line. `instructions` is a list of objects with `full` and any of the other four texts.
/// `instr_encodings` has the same keys; that of `full` becomes the tokens. `pseudo_label` is
/// ignored. Lines do not name their entry: there are no groups and first alternatives.
/// \throws InvalidInput as parse_soon(); also for a repeated path_id, one that is not two numbers
/// with "-" between them, and another number of encodings than of instructions
Annotations parse_soon_lines(std::string_view lines, const std::string& file, std::string split);

/// The released form, one entry per line. Neighbouring paths of one group are an entry's
/// alternatives; a path without a group is an entry. An entry without an `instr_id` gets its number
/// in the file. Except for that, a result of parse_soon() is read back equal, if its split has the
/// same name. So is one of parse_soon_lines(), except the ids, the order of first alternatives and
/// tokens, which this form does not have.
/// \throws ArgumentError for other annotations than SOON's, naming the path:
/// - instructions without the four texts beside the whole
/// - paths of one group that differ in more than the path, two groups of one instr_id
/// - infinite numbers and text that is not UTF-8
std::string to_soon(const Annotations& annotations);

/// Lines in DUET's form: a result of parse_soon_lines() is read back equal, if it is not empty. So
/// is one of parse_soon(), except groups, first alternatives and entries' ids. Encodings have only
/// `full`.
/// \throws ArgumentError for other annotations than SOON's, infinite numbers, and text that is not
/// UTF-8
std::string to_soon_lines(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
