/// \file  Fine-grained R2R: which piece of an instruction describes which piece of its path.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads fine-grained R2R (github.com/YicongHong/Fine-Grained-R2R): R2R's entries with two more
/// fields. `new_instructions` is a text that holds a Python literal: lists of lists of words, by
/// instruction and sub-instruction. `chunk_view` has `[first, last]` by sub-instruction, 1-based
/// positions on the path; test splits have none. They become the parts of the instructions'
/// details. The literal may have fewer lists than there are instructions (path 757 of val seen
/// does): then the last ones have no parts. `instr_encodings` become tokens. A list, or lines.
/// \throws InvalidInput listing its faults with JSON paths: as parse_r2r_family(), and
/// - a literal that is not of that form, or with more lists than instructions
/// - another number of chunks than of sub-instructions
/// - a position beyond the path, a last one before the first
Annotations parse_fine_grained(std::string_view json, const std::string& file, std::string split);

}  // namespace enfilade::tasks::formats
