/// \file  REVERIE's files: `REVERIE_<split>.json`, versions 1 and 2, and the boxes of objects in
/// views.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads a file of annotations: a list, or lines. Goals are NamedObject; hidden where an entry has
/// no `objId`, as in the test split. `distance`, `ix` and `instructions_l` of version 1 are read
/// over, `instr_encodings` become tokens.
/// \throws InvalidInput listing its faults with JSON paths: missing or wrongly typed fields, an
/// empty path, an `id` that another entry has, or that is not `<path_id>_<objId>`
Annotations parse_reverie(std::string_view json, const std::string& file, std::string split);

}  // namespace enfilade::tasks::formats
