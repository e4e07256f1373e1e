/// \file  Instructions to find objects, an instruction a record, as HM3DAutoVLN's files have them
/// (github.com/cshizhe/HM3DAutoVLN): REVERIE's task in other buildings.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads records of `instr_id, scan, path, pos_vps, objid` and, where there are any, `instruction`,
/// `instr_encoding` and `heading` (else 0). Lines, or a list. Scans and viewpoints may have ids of
/// any shape ("00000-kfPV7w3FaU5", "000007"), `objid` is a number or its digits. Each record
/// becomes a path of its own; its goal is a NamedObject with the viewpoints of `pos_vps`. Records
/// whose ids differ in what follows the last underscore alone are a group. Other fields are read
/// over.
/// \throws InvalidInput listing its faults with JSON paths: missing or wrongly typed fields, an
/// empty path or id, no viewpoint that sees the object, a negative `objid`, an `instr_id` that
/// another record has
Annotations parse_object_lines(std::string_view text, const std::string& file, std::string split);

/// Lines: what parse_object_lines() gave is read back equal, if it is not empty.
/// \throws ArgumentError for other annotations than those, and for what JSON cannot say: an
/// infinite number, text that is not UTF-8
std::string to_object_lines(const Annotations& annotations);

}  // namespace enfilade::tasks::formats
