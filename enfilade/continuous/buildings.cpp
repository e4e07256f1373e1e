#include "enfilade/continuous/buildings.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::continuous {

namespace {

constexpr std::string_view kSuffix = ".navmesh";

}  // namespace

struct Buildings::Entry {
  std::string scan;
  std::filesystem::path file;  // empty: made by other means
  mutable std::mutex mutex;
  mutable std::unique_ptr<const Geodesics> ways;

  const Geodesics& open() const {
    const std::lock_guard lock(mutex);
    if (!ways) {
      ways = std::make_unique<Geodesics>(
          std::make_shared<const NavigationMesh>(load_navigation_mesh(file)));
    }
    return *ways;
  }
};

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
}

Buildings::Buildings(std::vector<Building> made) {
  if (made.empty()) throw ArgumentError("buildings: none, at least one");
  for (Building& building : made) {
    if (!building.floor) throw ArgumentError(fmt::format("{}: its floor is null", building.scan));
    auto entry = std::make_unique<Entry>();
    entry->scan = std::move(building.scan);
    entry->ways = std::make_unique<Geodesics>(std::move(building.floor));
    entries_.push_back(std::move(entry));
  }
  const auto name = [](const auto& entry) -> const std::string& { return entry->scan; };
  std::ranges::sort(entries_, {}, name);
  const auto twice = std::ranges::adjacent_find(entries_, {}, name);
  if (twice != entries_.end()) {
    throw ArgumentError(fmt::format("buildings: \"{}\" is there twice", (*twice)->scan));
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

const Geodesics& Buildings::ways(std::size_t building) const {
  EN_CHECK_LT(building, entries_.size());
  return entries_[building]->open();
}

const NavigationMesh& Buildings::floor(std::size_t building) const { return ways(building).mesh(); }

}  // namespace enfilade::continuous
