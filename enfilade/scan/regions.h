/// \file  Regions (rooms) of viewpoints.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace enfilade::scan {

/// Viewpoint -> region index, for the scans of a file such as CVDN's
/// `region_to_panorama.json`: {scan: {region index: [viewpoint ids]}}. Immutable: any thread.
class RegionMap {
 public:
  /// \throws FileError, InvalidInput (with JSON paths: wrong types, bad ids, a region that is not a
  /// whole number >= 0, a viewpoint in two regions)
  static RegionMap load(const std::filesystem::path& file);
  static RegionMap parse(std::string_view json, const std::string& file);

  /// Region of a viewpoint; no value if the file has it in no region.
  std::optional<std::uint32_t> find(const std::string& scan, const std::string& viewpoint) const;
  std::vector<std::string> scans() const;                    ///< in alphabetical order
  std::size_t regions() const noexcept { return regions_; }  ///< in all scans together

 private:
  std::map<std::string, std::unordered_map<std::string, std::uint32_t>> scans_;
  std::size_t regions_ = 0;
};

/// The viewpoints of each region of a scan.
struct ScanRegions {
  std::string scan;
  std::vector<std::vector<std::string>> viewpoints;  ///< ids, by region index
};

/// The content of a file that RegionMap reads, one line per scan. Regions without viewpoints are
/// left out. \pre all ids are UTF-8, each scan is given once
std::string to_json(const std::vector<ScanRegions>& scans);

}  // namespace enfilade::scan
