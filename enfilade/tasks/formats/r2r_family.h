/// \file  What has grown out of R2R's form: token ids, lines, R2R-Last, R2R-Back, R4R. Fine-grained
/// R2R has a header of its own, fine_grained.h.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `R2R_<split>.json` and what has its form: with `instr_encodings` (token ids, one list an
/// instruction), with `midstop` (R2R-Back: goals are NamedTurningPoint), R4R's with
/// `first_path_id` and so on, which are read over; and HAMT's for pretraining, an instruction a
/// record (`instr_id, scan, path, heading, instr_encoding`, `instruction` where there is a text): a
/// file whose first record has an `instr_id`. Each becomes a path of its own, with the path_id of
/// its id ("4332_0") as its group; without `heading` it is 0. A list, or lines. Of PREVALENT's
/// files, too, and of ScaleVLN's, whose path ids are texts ("00000-kfPV7w3FaU5_12"): a path's id is
/// that text, its path_id the number of the first record that has it.
/// \param task  R2R-Back asks for `midstop` in each entry with more than one viewpoint; where a
/// path has one, and no `midstop`, the goal is hidden
/// \throws InvalidInput listing its faults with JSON paths: as parse_annotations();
/// `instr_encodings` that are not as many as the instructions; `midstop` in another task's file; an
/// `instr_id` that another record has, or that is not `<path_id>_<k>`
Annotations parse_r2r_family(std::string_view text, const std::string& file, std::string split,
                             Task task);

/// R2R's form with whatever the details hold of tokens, parts and turning points; it is read back
/// equal by parse_fine_grained() where instructions have parts, else by parse_r2r_family(). Lines,
/// if each path has one instruction with an id and without a text, as HAMT's have; else a list, an
/// entry a line. \throws ArgumentError as to_json(), and for an instruction of which some parts
/// have places and some none
std::string to_r2r_family(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
