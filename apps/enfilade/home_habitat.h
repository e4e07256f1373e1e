/// \file  Homes as Habitat's programs open them: `enfilade homes --parts habitat`.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "enfilade/homes/home_set.h"

namespace enfilade::apps {

/// How the files are made.
struct HabitatHomesOptions {
  bool episodes = true;              ///< of the splits of the folder's Room-to-Room
  std::size_t per_home = 60;         ///< episodes of PointNav and of ObjectNav, at most
  std::uint64_t seed = 1;            ///< of their starts and goals
  std::uint32_t image_width = 1280;  ///< in .house files, pixels
  int threads = 0;                   ///< 0: all cores; the files are the same for any number
};

/// Writes `<folder>/habitat`, which habitat-lab calls `data`, and says what became of it. It has
/// scene_datasets/mp3d (exports/habitat_scene.h) and, with episodes,
/// - `datasets/vln/mp3d/r2r/v1`: VLN-CE and experts, from each split of Room-to-Room
/// - `datasets/pointnav/mp3d/v1`, `datasets/objectnav/mp3d/v1`: train of train's homes, val of
///   val_unseen's
///
/// \throws as homes::build_home(), exports::write_habitat_scene(), dataset::Dataset
void write_habitat_homes(const std::filesystem::path& folder,
                         const std::vector<homes::HomeEntry>& homes,
                         const HabitatHomesOptions& options);

}  // namespace enfilade::apps
