/// \file  RxR's files (github.com/google-research-datasets/RxR): guides and followers, JSON Lines.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/demonstrations.h"

namespace enfilade::tasks::formats {

/// Reads guide annotations, an instruction a line; also HAMT's with `instr_encoding`. Each line
/// becomes a path with one instruction, whose details have the language and the timed words.
/// Instruction ids are `<path_id>_<instruction_id>`; of test lines, which have no `path_id` and a
/// path of the start alone, `<instruction_id>`, which is their path_id, too. Lines of one `path_id`
/// are a group.
/// \throws InvalidInput listing its faults with JSON paths (the index counts records from 0):
/// missing or wrongly typed fields, an empty path, an unknown language, an instruction_id that
/// another line has, a word that ends before it starts
Annotations parse_rxr_guide(std::string_view lines, const std::string& file, std::string split);

/// \throws InvalidInput as above, for followers
std::vector<Demonstration> parse_rxr_followers(std::string_view lines, const std::string& file);

/// A guide's lines, which parse_rxr_guide() reads back equal. `edit_distance` and `annotator_id`
/// are not in the model, and are left out.
std::string to_rxr_guide(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
