/// \file  Instructions to find objects, an instruction a record, as HM3DAutoVLN's files have them
/// (github.com/cshizhe/HM3DAutoVLN): REVERIE's task in other buildings.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads records of `instr_id, scan, path, pos_vps, objid` and, optionally, `instruction`,
/// `instr_encoding` and `heading` (else 0). Lines, or a list. Scans and viewpoints may have ids of
/// any form ("00000-kfPV7w3FaU5", "000007"), `objid` is a number or its digits. Each record becomes
/// a path of its own; its goal is a NamedObject with the viewpoints of `pos_vps`. Records whose ids
/// differ only after the last underscore are a group. Other fields are ignored.
/// \throws InvalidInput listing its faults with JSON paths:
/// - missing or wrongly typed fields, an empty path or id, a negative `objid`
/// - no viewpoint that sees the object
/// - a repeated `instr_id`
Annotations parse_object_lines(std::string_view text, const std::string& file, std::string split);

/// Lines: a result of parse_object_lines() is read back equal, if it is not empty.
/// \throws ArgumentError for other annotations than those, infinite numbers, and text that is not
/// UTF-8
std::string to_object_lines(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
