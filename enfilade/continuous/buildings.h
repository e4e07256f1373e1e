/// \file  The buildings of continuous episodes: a navigation mesh and its shortest paths per scan.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/geodesics.h"
#include "enfilade/continuous/navigation_mesh.h"

namespace enfilade::continuous {

/// A building by name.
struct Building {
  std::string scan;
  std::shared_ptr<const NavigationMesh> floor;
};

/// Buildings for one body. A floor is opened, and its shortest paths are prepared, at its first
/// use: milliseconds. All users share them. Any thread.
class Buildings {
 public:
  /// The `<scan>.navmesh` files in a folder, by name.
  /// \throws FileError if it cannot be read, or has none
  explicit Buildings(const std::filesystem::path& folder);
  /// Buildings that were made by other means. \throws ArgumentError for none, a null or a name
  /// twice
  explicit Buildings(std::vector<Building> made);
  ~Buildings();
  Buildings(const Buildings&) = delete;
  Buildings& operator=(const Buildings&) = delete;

  std::size_t size() const noexcept;
  const std::string& scan(std::size_t building) const;  ///< \pre building < size()
  /// The place of a scan's building; no value: it has none here.
  std::optional<std::size_t> find(std::string_view scan) const noexcept;
  /// find(), or \throws LookupError naming the scan and what there is
  std::size_t at(std::string_view scan) const;
  /// \pre building < size() \throws as load_navigation_mesh()
  const NavigationMesh& floor(std::size_t building) const;
  const Geodesics& ways(std::size_t building) const;  ///< as floor()

 private:
  struct Entry;
  std::vector<std::unique_ptr<Entry>> entries_;  // by name
};

/// "home0001" -> "home0001.navmesh".
std::string navigation_mesh_name(std::string_view scan);

}  // namespace enfilade::continuous
