/// \file  RxR's files (github.com/google-research-datasets/RxR): guides and followers, JSON Lines.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/demonstrations.h"

namespace enfilade::tasks::formats {

/// Reads guide annotations, one instruction per line; also HAMT's with `instr_encoding`. Each line
/// becomes a path with one instruction, whose details have the language and any timed words.
/// Instruction ids are `<path_id>_<instruction_id>`. Test lines have no `path_id`, and only the
/// start as their path; their id is `<instruction_id>`, which is their path_id, too. Lines of one
/// `path_id` are a group. `split`, `annotator_id` and `edit_distance` are ignored.
/// \throws InvalidInput listing its faults with JSON paths (the index counts records from 0):
/// - missing or wrongly typed fields, a negative id, an empty path, an unknown language
/// - more than the start without a path_id
/// - a repeated instruction_id
Annotations parse_rxr_guide(std::string_view lines, const std::string& file, std::string split);

/// Reads follower annotations, one trajectory per line.
/// \throws InvalidInput listing its faults with JSON paths: missing or wrongly typed fields, a
/// negative id, an empty path, a repeated demonstration_id
std::vector<Demonstration> parse_rxr_followers(std::string_view lines, const std::string& file);

/// Followers' lines: parse_rxr_followers() reads them back equal, if there are any.
/// \throws ArgumentError for an infinite number, a negative id, an empty path, or text that is not
/// UTF-8, naming the demonstration
std::string to_rxr_followers(std::span<const Demonstration> walks);

/// A guide's lines: a result of parse_rxr_guide() is read back equal, if it is not empty.
/// `edit_distance` and `annotator_id` are not in the model, and are left out.
/// \throws ArgumentError for other annotations than RxR's, infinite numbers, and text that is not
/// UTF-8
std::string to_rxr_guide(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
