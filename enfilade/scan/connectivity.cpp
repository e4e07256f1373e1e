#include "enfilade/scan/connectivity.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::scan {
namespace {

using json::Element;
using json::Faults;
using json::Path;

enum FieldIndex : std::size_t { kId, kPose, kIncluded, kVisible, kUnobstructed, kHeight, kFields };
constexpr std::array<json::Field, kFields> kWanted{
    {{"image_id"}, {"pose"}, {"included"}, {"visible"}, {"unobstructed"}, {"height", false}}};
using Found = std::array<std::optional<Element>, kFields>;

void read_pose(Element element, const Path& path, Faults& faults, std::array<double, 16>& pose) {
  const auto numbers = json::array(element, path, faults);
  if (!numbers) return;
  if (numbers->size() != pose.size()) {
    faults.error(path, "bad-pose",
                 fmt::format("{} numbers, not 16 (a 4 x 4 matrix)", numbers->size()));
    return;
  }
  std::size_t i = 0;
  for (const Element number : *numbers) {
    pose[i] = json::number(number, Path(path, i), faults).value_or(0);
    if (std::abs(pose[i]) > kMostMetres) {
      faults.error(Path(path, i), "bad-pose", fmt::format("{} is no length in metres", pose[i]));
    }
    ++i;
  }
}

std::vector<ViewpointIndex> read_row(Element element, std::size_t n, const Path& path,
                                     Faults& faults) {
  std::vector<ViewpointIndex> places;
  const auto flags = json::array(element, path, faults);
  if (!flags) return places;
  std::size_t i = 0;
  for (const Element flag : *flags) {
    bool set = false;
    if (flag.get_bool().get(set) != simdjson::SUCCESS) {
      json::boolean(flag, Path(path, i), faults);  // reports what was found
    }
    if (set && i < n) places.emplace_back(i);
    ++i;
  }
  if (i != n) {
    faults.error(path, "wrong-length",
                 fmt::format("{} flags, not {} (one for each viewpoint of the file)", i, n));
  }
  return places;
}

ConnectivityEntry read_entry(Element element, std::size_t n, const Path& path, Faults& faults) {
  ConnectivityEntry entry;
  Found found;
  if (!json::fields(element, kWanted, found, path, faults)) return entry;
  entry.id = json::id(*found[kId], Path(path, "image_id"), faults).value_or("");
  read_pose(*found[kPose], Path(path, "pose"), faults, entry.pose);
  entry.included = json::boolean(*found[kIncluded], Path(path, "included"), faults).value_or(false);
  entry.visible = read_row(*found[kVisible], n, Path(path, "visible"), faults);
  entry.unobstructed = read_row(*found[kUnobstructed], n, Path(path, "unobstructed"), faults);
  if (found[kHeight]) {
    const Path place(path, "height");
    entry.height = json::number(*found[kHeight], place, faults).value_or(0);
    if (std::abs(entry.height) > kMostMetres) {
      faults.error(place, "bad-height", fmt::format("{} is no length in metres", entry.height));
    }
  }
  return entry;
}

Connectivity read(const json::Document& document, std::string scan) {
  Connectivity result{std::move(scan), document.name(), {}};
  Faults faults(document.name());
  const Path root;
  if (const auto entries = json::array(document.root(), root, faults)) {
    std::size_t n = 0;
    for ([[maybe_unused]] const Element entry : *entries) ++n;  // size() saturates at 2^24 - 1
    result.entries.reserve(n);
    std::unordered_map<std::string, std::size_t> first;
    for (const Element element : *entries) {
      const std::size_t i = result.entries.size();
      const Path path(root, i);
      result.entries.push_back(read_entry(element, n, path, faults));
      const std::string& id = result.entries.back().id;
      if (const auto [at, fresh] = first.emplace(id, i); !fresh && !id.empty()) {
        faults.error(Path(path, "image_id"), "repeated-id",
                     fmt::format("{} stands at $[{}] already", quote(id), at->second));
      }
    }
  }
  faults.throw_if_errors();
  return result;
}

std::filesystem::path scan_list_file(const std::filesystem::path& directory) {
  return directory / "scans.txt";
}

// Scan ids with white space between them; none in a blank text.
std::vector<std::string> parse_scan_list(std::string_view text, const std::string& file) {
  std::vector<std::string> scans;
  std::set<std::string, std::less<>> seen;
  Faults faults(file);
  const Path root;
  const auto add = [&](std::string_view scan) {
    if (std::string fault = fault_of_id(scan); !fault.empty()) {
      faults.error(root, "bad-id", std::move(fault));
    } else if (!seen.emplace(scan).second) {
      faults.error(root, "repeated-scan", fmt::format("{} stands in the list twice", quote(scan)));
    }
    scans.emplace_back(scan);
  };
  for (const ListLine& line : list_lines(text)) {
    std::istringstream words{std::string(line.text)};
    // A list made by `ls` has the files' names.
    for (std::string word; words >> word;) add(scan_of_file(word).value_or(word));
  }
  faults.throw_if_errors();
  return scans;
}

// A list that a scan is to be added to, and its text; both are empty if the file is absent or
// blank.
struct ScanList {
  std::vector<std::string> scans;
  std::string text;
};

ScanList read_scan_list(const std::filesystem::path& file) {
  if (!file_exists(file)) return {};
  ScanList list;
  list.text = read_plain_text(file);
  list.scans = parse_scan_list(list.text, file.string());
  if (trimmed(list.text).empty()) list.text.clear();
  return list;
}

}  // namespace

bool is_scan_id(std::string_view scan) { return is_id(scan); }

void require_scan_id(std::string_view scan) {
  if (const std::string fault = fault_of_id(scan); !fault.empty()) {
    throw LookupError("scan: " + fault);
  }
}

std::string_view name_in_hm3d(std::string_view scan) noexcept {
  constexpr std::size_t kDigits = 5;
  const bool numbered = scan.find_first_not_of("0123456789") == kDigits && scan[kDigits] == '-';
  return numbered ? scan.substr(kDigits + 1) : std::string_view();
}

std::filesystem::path connectivity_file(const std::filesystem::path& directory,
                                        std::string_view scan) {
  return directory / fmt::format("{}_connectivity.json", scan);
}

std::optional<std::filesystem::path> find_connectivity(const std::filesystem::path& directory,
                                                       std::string_view scan) {
  const std::filesystem::path file = find_text_file(connectivity_file(directory, scan));
  return file_exists(file) ? std::optional(file) : std::nullopt;
}

std::optional<std::string> scan_of_file(const std::filesystem::path& file) {
  return name_before(file, "_connectivity.json");
}

Connectivity load_connectivity(const std::filesystem::path& directory, std::string_view scan) {
  require_scan_id(scan);
  return load_connectivity_file(connectivity_file(directory, scan), std::string(scan));
}

Connectivity load_connectivity_file(const std::filesystem::path& file, std::string scan) {
  return read(json::Document::load(file), std::move(scan));
}

Connectivity parse_connectivity(std::string_view json, std::string scan, const std::string& file) {
  return read(json::Document::parse(json, file), std::move(scan));
}

std::string to_json(const Connectivity& connectivity) {
  const std::size_t n = connectivity.entries.size();
  const auto flags = [n](const std::vector<ViewpointIndex>& places) {
    std::vector<bool> row(n, false);
    for (const ViewpointIndex v : places) row.at(v.at()) = true;
    return row;
  };
  nlohmann::ordered_json entries = nlohmann::ordered_json::array();
  for (const ConnectivityEntry& entry : connectivity.entries) {
    entries.push_back({{"image_id", entry.id},
                       {"pose", entry.pose},
                       {"included", entry.included},
                       {"visible", flags(entry.visible)},
                       {"unobstructed", flags(entry.unobstructed)},
                       {"height", entry.height}});
  }
  return entries.dump() + "\n";
}

void save_connectivity(const std::filesystem::path& directory, const Connectivity& connectivity) {
  save_connectivity(OutputFolder(directory), connectivity);
}

void save_connectivity(const OutputFolder& out, const Connectivity& connectivity) {
  const std::filesystem::path file = scan_list_file(out.path());
  auto [scans, text] = read_scan_list(file);
  out.write(connectivity_file({}, connectivity.scan).string(), to_json(connectivity));
  if (std::ranges::find(scans, connectivity.scan) != scans.end()) return;
  if (!text.empty() && !text.ends_with('\n')) text += '\n';
  out.write(file.filename().string(), text + connectivity.scan + "\n");
}

void check_scan_list(const std::filesystem::path& directory) {
  (void)read_scan_list(scan_list_file(directory));
}

std::vector<std::string> load_scan_list(const std::filesystem::path& directory) {
  const std::filesystem::path file = scan_list_file(directory);
  // A data set's folder, where that of its graphs is wanted.
  const std::filesystem::path below = scan_list_file(directory / "connectivity");
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored) && std::filesystem::exists(below, ignored)) {
    throw FileError(file.string() + ": no such file, but " + below.string() +
                    " is there: name that folder, " + below.parent_path().string());
  }
  std::vector<std::string> scans = parse_scan_list(read_plain_text(file), file.string());
  if (scans.empty()) {
    refuse(file.string(), Path().text(), "no-scans", "lists no scan; one id a line is expected");
  }
  return scans;
}

}  // namespace enfilade::scan
