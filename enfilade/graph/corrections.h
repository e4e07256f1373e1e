/// \file  People's corrections to a graph, kept apart from it: the paper's manual verification.
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::graph {

/// One edge that a person added or took away, or a viewpoint left out.
struct Correction {
  /// The effect of a correction.
  enum class Action { kAddEdge, kRemoveEdge, kExclude, kInclude };
  Action action = Action::kAddEdge;
  std::string from, to;  ///< viewpoint ids; `to` is empty for (in/ex)clusion
  std::string who, why;  ///< both must be there
  std::string when;      ///< ISO 8601 date or time; may be empty
};
/// Their names: core/enum_names.h.
constexpr std::array<std::string_view, 4> names_of(Correction::Action /*enum*/) {
  return {"add-edge", "remove-edge", "exclude", "include"};
}
/// All corrections to the graph of one scan.
struct Corrections {
  std::string scan;
  std::vector<Correction> list;  ///< applied in order
};

/// A file of them: JSON {"scan", "corrections": [{"action": "add-edge" | "remove-edge" | "exclude"
/// | "include", "from", "to", "who", "why", "when"}]}. \throws FileError, InvalidInput
Corrections load_corrections(const std::filesystem::path& file);
Corrections parse_corrections(std::string_view json, const std::string& file);
std::string to_json(const Corrections& corrections);

/// A graph with them applied. Both directions of an edge change. Notes (warnings) name those that
/// change nothing. \throws InvalidInput if the scan is another or an id is not there; nothing is
/// applied then
struct Corrected {
  scan::Connectivity connectivity;
  std::vector<Diagnostic> notes;
};
Corrected apply(const scan::Connectivity& connectivity, const Corrections& corrections,
                const std::string& file);

}  // namespace enfilade::graph
