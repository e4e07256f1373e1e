/// \file  REVERIE's annotations: `REVERIE_<split>.json`, versions 1 and 2. The boxes of objects in
/// views are read by objects.h.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads a file of annotations: a list, or lines. Goals are NamedObject; a path of R2R with several
/// objects is a group; hidden where an entry has no `objId`, as in the test split, whose `id` is
/// the path's number and whose path is the start alone. An entry with an `objId` may have a number
/// as its `id`, too: goals of a test split, whose ids must not tell them. `instr_encodings` become
/// tokens. Other fields are read over, such as `distance`, `ix` and `instructions_l` of version 1.
/// \throws InvalidInput listing its faults with JSON paths: missing or wrongly typed fields, an
/// empty path, a negative id, an `id` that another entry has, or that is neither
/// `<path_id>_<objId>` nor a number, more than the start of a path whose goal is hidden,
/// `instr_encodings` that are not as many as the instructions
Annotations parse_reverie(std::string_view json, const std::string& file, std::string split);

/// A list, an entry a line: what parse_reverie() gave is read back equal. Lengths of paths are left
/// out, as in version 2.
/// \throws ArgumentError for other annotations than REVERIE's, naming the entry, and for what JSON
/// cannot say: an infinite number, text that is not UTF-8
std::string to_reverie(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
