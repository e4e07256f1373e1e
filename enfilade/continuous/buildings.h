/// \file  The buildings of continuous episodes: a floor per scan.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/floor.h"
#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::continuous {

/// A building by name.
struct Building {
  std::string scan;
  std::shared_ptr<const Floor> floor;

  Building(std::string name, std::shared_ptr<const Floor> of);
  /// On our own floor. A null stays one.
  Building(std::string name, const std::shared_ptr<const NavigationMesh>& mesh);
};

/// Buildings for one body, all on floors of one kind. A floor is opened, and its shortest paths are
/// prepared, at its first use: milliseconds. All users share them. Any thread.
class Buildings {
 public:
  /// The `<scan>.navmesh` files in a folder, by name: our own or Habitat's (floor_kind_of()).
  /// \throws FileError if it cannot be read, or has none
  /// \throws InvalidInput `mixed-floors`: files of both kinds
  explicit Buildings(const std::filesystem::path& folder);
  /// Buildings that were made by other means. \throws ArgumentError for none, a null, a name twice,
  /// or floors of two kinds
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
  /// \pre building < size() \throws as load_floor()
  const Floor& floor(std::size_t building) const;
  /// name_of() the kind of all of them. Opens none.
  std::string_view floor_name() const noexcept;

 private:
  struct Entry;
  std::vector<std::unique_ptr<Entry>> entries_;  // by name
  FloorKind kind_ = FloorKind::kEnfilade;
};

/// The kind of a floor's file, by its first bytes: kEnfilade for anything but Habitat's. Also for a
/// file that cannot be read; load_floor() says why.
FloorKind floor_kind_of(const std::filesystem::path& file) noexcept;
/// Whether Habitat's file was made for the body. \throws FileError; InvalidInput for another file
bool is_habitat_floor_of(const std::filesystem::path& file, const mesh::Body& body);
/// The floor of such a file. Habitat's files do not name their recipe; steps are those of 0.3.3.
/// \throws as load_navigation_mesh() and is_habitat_floor_of()
std::shared_ptr<const Floor> load_floor(const std::filesystem::path& file);

/// "home0001" -> "home0001.navmesh".
std::string navigation_mesh_name(std::string_view scan);

}  // namespace enfilade::continuous
