#include "enfilade/homes/sets/home_corrections.h"

#include <fmt/format.h>
#include <algorithm>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::homes::sets {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = "_corrections.json";

// In the order of their names, so that the same fault is reported first everywhere.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    if (entry.path().filename().string().ends_with(kSuffix)) files.push_back(entry.path());
  }
  if (code) throw FileError(fmt::format("{}: cannot open: {}", folder.string(), code.message()));
  if (files.empty()) {
    throw FileError(
        fmt::format("{}: holds no corrections: SCAN{} is expected", folder.string(), kSuffix));
  }
  std::ranges::sort(files);
  return files;
}

[[noreturn]] void refuse(const fs::path& file, std::string where, std::string code,
                         std::string message) {
  throw InvalidInput(
      {{Severity::kError, file.string(), std::move(where), std::move(code), std::move(message)}});
}

}  // namespace

std::map<std::string, HomeCorrections> load_home_corrections(
    const fs::path& folder, const std::vector<std::string>& scans) {
  std::map<std::string, HomeCorrections> all;
  if (folder.empty()) return all;
  for (const fs::path& file : files_in(folder)) {
    std::string scan = file.filename().string();
    scan.resize(scan.size() - kSuffix.size());
    if (std::ranges::find(scans, scan) == scans.end()) {
      refuse(file, "", "unknown-scan",
             fmt::format("{:?} is none of the {} homes of this set: {} to {}", scan, scans.size(),
                         scans.front(), scans.back()));
    }
    graph::Corrections corrections = graph::load_corrections(file);
    if (corrections.scan != scan) {
      refuse(file, "$.scan", "other-scan",
             fmt::format("{:?}, and the file is named after {:?}", corrections.scan, scan));
    }
    const std::string text = to_json(corrections);
    const std::string checksum = fmt::format("{:016x}", stream_of(text.data(), text.size()));
    all[scan] = {file, std::move(corrections), checksum};
  }
  return all;
}

}  // namespace enfilade::homes::sets
