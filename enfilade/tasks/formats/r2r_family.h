/// \file  R2R's form and its descendants: token ids, lines, R2R-Last, R2R-Back, R4R. Fine-grained
/// R2R has a header of its own, fine_grained.h.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `R2R_<split>.json` and files of its form, a list or lines:
/// - with `instr_encodings`: token ids, one list per instruction
/// - with `midstop` (R2R-Back): goals are NamedTurningPoint
/// - R4R's, whose `first_path_id` and so on are ignored
/// - HAMT's for pretraining, one instruction per record (`instr_id, scan, path, heading,
///   instr_encoding`, optional `instruction`): a file whose first record has an `instr_id`
/// - PREVALENT's and ScaleVLN's, whose path ids are texts ("00000-kfPV7w3FaU5_12"). That text is a
///   path's id; its path_id is the number of the first record with it.
///
/// A record of HAMT's form becomes a path of its own, with the path_id of its id ("4332_0") as its
/// group; without `heading` it is 0.
/// \param task  R2R-Back needs `midstop` in each entry with more than one viewpoint; if an entry
/// has just one and no `midstop`, the goal is hidden
/// \throws InvalidInput listing its faults with JSON paths: as parse_annotations(), and
/// - another number of `instr_encodings` than of instructions
/// - `midstop` in another task's file
/// - an `instr_id` that is repeated, or that is not `<path_id>_<k>`
Annotations parse_r2r_family(std::string_view text, const std::string& file, std::string split,
                             Task task);

/// R2R's form with all tokens, parts and turning points of the details. It is read back equal by
/// parse_fine_grained() if instructions have parts, else by parse_r2r_family(). Lines, if each path
/// has one instruction with an id and without a text, as HAMT's have; else a list, one entry per
/// line.
/// \throws ArgumentError as to_json(), and for an instruction in which only some parts have
/// positions
std::string to_r2r_family(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
