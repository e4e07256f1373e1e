/// \file  REVERIE's annotations: `REVERIE_<split>.json`, versions 1 and 2. The boxes of objects in
/// views are read by objects.h.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads a file of annotations: a list, or lines. Goals are NamedObject; a path of R2R with several
/// objects is a group. An entry without `objId`, as in the test split, has a hidden goal. Its `id`
/// is the path's number, and its path only the start. An entry with an `objId` may have a number as
/// its `id`, too: goals of a test split, whose ids must not give them away. Other fields are
/// ignored, such as `distance`, `ix` and `instructions_l` of version 1. The field `instr_encodings`
/// becomes tokens.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, an empty path, a negative id
/// - an `id` that is repeated, or that is neither `<path_id>_<objId>` nor a number
/// - more than the start of a path whose goal is hidden
/// - another number of `instr_encodings` than of instructions
Annotations parse_reverie(std::string_view json, const std::string& file, std::string split);

/// A list, one entry per line: a result of parse_reverie() is read back equal. Lengths of paths are
/// left out, as in version 2.
/// \throws ArgumentError for other annotations than REVERIE's, naming the entry; for infinite
/// numbers and text that is not UTF-8
std::string to_reverie(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
