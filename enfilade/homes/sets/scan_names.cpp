#include "enfilade/homes/sets/scan_names.h"

#include <fmt/format.h>

#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::homes::sets {
namespace {

constexpr std::string_view kPrefix = "home";

}  // namespace

std::string scan_name(std::size_t home) { return fmt::format("{}{:04}", kPrefix, home + 1); }

std::optional<std::size_t> place_of_scan(const std::string& scan) {
  if (!scan.starts_with(kPrefix)) return std::nullopt;
  const auto number = parse_number<std::size_t>(std::string_view(scan).substr(kPrefix.size()));
  // Compared as a whole: "home1" has a number too.
  if (!number || *number == 0 || scan != scan_name(*number - 1)) return std::nullopt;
  return *number - 1;
}

std::string draws_of(const std::string& scan) {
  return scan.starts_with(kPrefix) ? "home_" + scan.substr(kPrefix.size()) : scan;
}

void write_alias_graph(const std::filesystem::path& connectivity) {
  scan::Connectivity graph{"ZMojNkEp431", "", {}};
  scan::ConnectivityEntry& entry = graph.entries.emplace_back();
  entry.id = "2f4d90acd4024c269fb0efe49a8ac540";
  // As of homes: right = +x, down = -z, look = +y, the eye at 1.5 m.
  entry.pose = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1.5, 0, 0, 0, 1};
  entry.height = 1.5;
  write_file_atomically(scan::connectivity_file(connectivity, graph.scan), to_json(graph));
}

}  // namespace enfilade::homes::sets
