#include "enfilade/scan/regions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <ranges>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"

namespace enfilade::scan {
namespace {

using json::Element;
using json::Faults;
using json::Path;

using Viewpoints = std::unordered_map<std::string, std::uint32_t>;

void read_region(Element element, std::uint32_t region, const Path& path, Faults& faults,
                 Viewpoints& viewpoints) {
  const auto ids = json::array(element, path, faults);
  if (!ids) return;
  std::size_t i = 0;
  for (const Element id : *ids) {
    const Path here(path, i++);
    const auto text = json::id(id, here, faults);
    if (!text) continue;
    const auto [at, fresh] = viewpoints.emplace(*text, region);
    if (!fresh) {
      faults.error(here, "repeated-viewpoint",
                   fmt::format("viewpoint {} is in region {} already", quote(*text), at->second));
    }
  }
}

}  // namespace

RegionMap RegionMap::load(const std::filesystem::path& file) {
  return parse(read_text_file(file), file.string());
}

RegionMap RegionMap::parse(std::string_view text, const std::string& file) {
  const json::Document document = json::Document::parse(text, file);
  RegionMap map;
  Faults faults(file);
  const Path root;
  const auto scans = json::object(document.root(), root, faults);
  faults.throw_if_errors();
  for (const auto scan : *scans) {
    const Path scan_path(root, scan.key);
    if (std::string fault = fault_of_id(scan.key); !fault.empty()) {
      faults.error(scan_path, "bad-id", std::move(fault));
      continue;
    }
    const auto regions = json::object(scan.value, scan_path, faults);
    if (!regions) continue;
    Viewpoints& viewpoints = map.scans_[std::string(scan.key)];
    for (const auto region : *regions) {
      const Path path(scan_path, region.key);
      const auto index = parse_number<std::uint32_t>(region.key);
      if (!index) {
        faults.error(path, "bad-region",
                     fmt::format("region {}, not a whole number from 0 on", quote(region.key)));
        continue;
      }
      read_region(region.value, *index, path, faults, viewpoints);
      ++map.regions_;
    }
  }
  faults.throw_if_errors();
  return map;
}

std::optional<std::uint32_t> RegionMap::find(const std::string& scan,
                                             const std::string& viewpoint) const {
  const auto viewpoints = scans_.find(scan);
  if (viewpoints == scans_.end()) return std::nullopt;
  const auto region = viewpoints->second.find(viewpoint);
  if (region == viewpoints->second.end()) return std::nullopt;
  return region->second;
}

std::vector<std::string> RegionMap::scans() const {
  std::vector<std::string> names;
  for (const auto& [scan, viewpoints] : scans_) names.push_back(scan);
  return names;
}

std::string to_json(const std::vector<ScanRegions>& scans) {
  const auto quoted = [](const std::string& text) { return nlohmann::json(text).dump(); };
  std::vector<std::string> lines;
  for (const ScanRegions& scan : scans) {
    std::vector<std::string> regions;
    for (std::size_t r = 0; r < scan.viewpoints.size(); ++r) {
      if (scan.viewpoints[r].empty()) continue;
      const auto ids = scan.viewpoints[r] | std::views::transform(quoted);
      regions.push_back(fmt::format("\"{}\": [{}]", r, fmt::join(ids, ", ")));
    }
    lines.push_back(fmt::format("\n{}: {{{}}}", quoted(scan.scan), fmt::join(regions, ", ")));
  }
  return fmt::format("{{{}\n}}\n", fmt::join(lines, ","));
}

}  // namespace enfilade::scan
