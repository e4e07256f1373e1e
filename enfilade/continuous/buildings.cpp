#include "enfilade/continuous/buildings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <utility>

#include "enfilade/continuous/geodesics.h"
#include "enfilade/continuous/habitat/habitat_floor.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::continuous {

namespace {

constexpr std::string_view kSuffix = ".navmesh";

habitat::NavMesh load_habitat_mesh(const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return habitat::parse_nav_mesh({data, bytes.size()}, file.string());
}

}  // namespace

struct Buildings::Entry {
  std::string scan;
  std::filesystem::path file;  // empty: made by other means
  mutable std::mutex mutex;
  mutable std::shared_ptr<const Floor> floor;

  const Floor& open() const {
    const std::lock_guard lock(mutex);
    if (!floor) floor = load_floor(file);
    return *floor;
  }
};

Building::Building(std::string name, std::shared_ptr<const Floor> of)
    : scan(std::move(name)), floor(std::move(of)) {}

Building::Building(std::string name, const std::shared_ptr<const NavigationMesh>& mesh)
    : scan(std::move(name)), floor(mesh ? std::make_shared<const Geodesics>(mesh) : nullptr) {}

FloorKind floor_kind_of(const std::filesystem::path& file) noexcept {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return FloorKind::kEnfilade;
  std::array<char, sizeof(std::int32_t)> start{};
  std::ifstream(file, std::ios::binary).read(start.data(), start.size());
  return habitat::is_nav_mesh_file({start.data(), start.size()}) ? FloorKind::kHabitat
                                                                 : FloorKind::kEnfilade;
}

bool is_habitat_floor_of(const std::filesystem::path& file, const mesh::Body& body) {
  return load_habitat_mesh(file).settings == habitat::settings_of(body);
}

std::shared_ptr<const Floor> load_floor(const std::filesystem::path& file) {
  if (floor_kind_of(file) == FloorKind::kEnfilade) {
    return std::make_shared<const Geodesics>(
        std::make_shared<const NavigationMesh>(load_navigation_mesh(file)));
  }
  return std::make_shared<const habitat::HabitatFloor>(load_habitat_mesh(file));
}

std::string navigation_mesh_name(std::string_view scan) {
  return fmt::format("{}{}", scan, kSuffix);
}

Buildings::Buildings(const std::filesystem::path& folder) {
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {
    if (entry.path().extension() != kSuffix) continue;
    auto found = std::make_unique<Entry>();
    found->scan = entry.path().stem().string();
    found->file = entry.path();
    entries_.push_back(std::move(found));
  }
  if (code) throw FileError(fmt::format("{}: {}", folder.string(), code.message()));
  if (entries_.empty()) {
    throw FileError(fmt::format("{}: has no file *{}; `enfilade continuous` makes them",
                                folder.string(), kSuffix));
  }
  std::ranges::sort(entries_, {}, [](const auto& entry) { return entry->scan; });
  kind_ = floor_kind_of(entries_.front()->file);
  for (const auto& entry : entries_) {
    if (floor_kind_of(entry->file) == kind_) continue;
    throw InvalidInput(
        {{Severity::kError, entry->file.string(), "", "mixed-floors",
          fmt::format("another floor than {} has; `enfilade continuous` with or without "
                      "--navmesh habitat makes all of one kind",
                      entries_.front()->file.filename().string())}});
  }
}

Buildings::Buildings(std::vector<Building> made) {
  if (made.empty()) throw ArgumentError("buildings: none, at least one");
  for (Building& building : made) {
    if (!building.floor) throw ArgumentError(fmt::format("{}: its floor is null", building.scan));
    auto entry = std::make_unique<Entry>();
    entry->scan = std::move(building.scan);
    entry->floor = std::move(building.floor);
    entries_.push_back(std::move(entry));
  }
  const auto name = [](const auto& entry) -> const std::string& { return entry->scan; };
  std::ranges::sort(entries_, {}, name);
  const auto twice = std::ranges::adjacent_find(entries_, {}, name);
  if (twice != entries_.end()) {
    throw ArgumentError(fmt::format("buildings: \"{}\" is there twice", (*twice)->scan));
  }
  kind_ = entries_.front()->floor->kind();
  for (const auto& entry : entries_) {
    if (entry->floor->kind() == kind_) continue;
    throw ArgumentError(
        fmt::format("buildings: the floor of \"{}\" is of another kind than that of \"{}\"",
                    entry->scan, entries_.front()->scan));
  }
}

Buildings::~Buildings() = default;

std::size_t Buildings::size() const noexcept { return entries_.size(); }

const std::string& Buildings::scan(std::size_t building) const {
  EN_CHECK_LT(building, entries_.size());
  return entries_[building]->scan;
}

std::optional<std::size_t> Buildings::find(std::string_view scan) const noexcept {
  const auto at = std::ranges::lower_bound(
      entries_, scan, {}, [](const auto& entry) { return std::string_view(entry->scan); });
  if (at == entries_.end() || (*at)->scan != scan) return std::nullopt;
  return static_cast<std::size_t>(at - entries_.begin());
}

std::size_t Buildings::at(std::string_view scan) const {
  const auto found = find(scan);
  if (!found) {
    throw LookupError(fmt::format("no navigation mesh of scan \"{}\" among {}, from {} to {}", scan,
                                  size(), entries_.front()->scan, entries_.back()->scan));
  }
  return *found;
}

std::string_view Buildings::floor_name() const noexcept { return name_of(kind_); }

const Floor& Buildings::floor(std::size_t building) const {
  EN_CHECK_LT(building, entries_.size());
  return entries_[building]->open();
}

}  // namespace enfilade::continuous
