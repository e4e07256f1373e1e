/// \file  What has grown out of R2R's form: token ids, lines, R2R-Last, R2R-Back, R4R, fine-grained
/// R2R.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `R2R_<split>.json` and what has its form: with `instr_encodings` (token ids, one list an
/// instruction), with `midstop` (R2R-Back: goals are NamedTurningPoint), R4R's with
/// `first_path_id` and so on, which are read over; and HAMT's lines for pretraining, an instruction
/// a line (`instr_id, scan, path, heading, instr_encoding`; there is no text, so it is empty). A
/// list, or lines. Of PREVALENT's files, too.
/// \param task  R2R-Back asks for `midstop` in each entry with more than one viewpoint
/// \throws InvalidInput listing its faults with JSON paths: as parse_annotations(), and
/// `instr_encodings` that are not as many as the instructions
Annotations parse_r2r_family(std::string_view text, const std::string& file, std::string split,
                             Task task);

/// Reads fine-grained R2R (github.com/YicongHong/Fine-Grained-R2R): R2R's entries with
/// `new_instructions`, a text that holds a Python literal (lists of lists of words, by instruction
/// and sub-instruction), and `chunk_view`, `[first, last]` by sub-instruction, 1-based places on
/// the path. They become the parts of the instructions' details. Test splits have no `chunk_view`.
/// \throws InvalidInput listing its faults with JSON paths: as above; a literal that is not of that
/// form; other numbers of chunks than of sub-instructions; a place beyond the path
Annotations parse_fine_grained(std::string_view json, const std::string& file, std::string split);

/// R2R's form with whatever the details hold of tokens, parts and turning points; it is read back
/// equal by parse_fine_grained() where instructions have parts, else by parse_r2r_family().
std::string to_r2r_family(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
