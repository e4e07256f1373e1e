/// \file  RxR's files (github.com/google-research-datasets/RxR): guides and followers, JSON Lines.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/demonstrations.h"

namespace enfilade::tasks::formats {

/// Reads guide annotations, an instruction a line; also HAMT's with `instr_encoding`. Each line
/// becomes a path with one instruction, whose details have the language and the timed words, if
/// there are any. Instruction ids are `<path_id>_<instruction_id>`; of test lines, which have no
/// `path_id` and a path of the start alone, `<instruction_id>`, which is their path_id, too. Lines
/// of one `path_id` are a group. `split`, `annotator_id` and `edit_distance` are read over.
/// \throws InvalidInput listing its faults with JSON paths (the index counts records from 0):
/// missing or wrongly typed fields, a negative id, an empty path, more than the start where there
/// is no path_id, an unknown language, an instruction_id that another line has
Annotations parse_rxr_guide(std::string_view lines, const std::string& file, std::string split);

/// Reads follower annotations, a walk a line.
/// \throws InvalidInput listing its faults with JSON paths: missing or wrongly typed fields, a
/// negative id, an empty path, a demonstration_id that another line has
std::vector<Demonstration> parse_rxr_followers(std::string_view lines, const std::string& file);

/// Followers' lines: parse_rxr_followers() reads them back equal, if there are any.
/// \throws ArgumentError for an infinite number, a negative id, an empty path, or text that is not
/// UTF-8, naming the demonstration
std::string to_rxr_followers(std::span<const Demonstration> walks);

/// A guide's lines: what parse_rxr_guide() gave is read back equal, if it is not empty.
/// `edit_distance` and `annotator_id` are not in the model, and are left out.
/// \throws ArgumentError for other annotations than RxR's, and for what JSON cannot say: an
/// infinite number, text that is not UTF-8
std::string to_rxr_guide(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
