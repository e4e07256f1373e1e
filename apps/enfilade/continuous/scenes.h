/// \file  Scenes of a data set's buildings, for rendering from any position.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/enfilade/continuous/floors.h"
#include "enfilade/continuous/scene.h"
#include "enfilade/exports/expert_walks.h"

namespace enfilade::apps {

/// Where the light of a synthetic home is kept once it is made: DATA/light/SCAN.light.
std::filesystem::path home_light_file(const dataset::Dataset& data, const std::string& scan);
/// Result of make_home_lights().
struct LightsReport {
  std::size_t made = 0, kept = 0;
};
/// Computes the light of all synthetic homes of a data set, and stores it. Existing light stays.
/// \throws FileError
LightsReport make_home_lights(const dataset::Dataset& data, int threads);

/// The scene of a synthetic home or of the scan's mesh file. A home is made again with its
/// textures, and with its stored light, or light that is made now. A mesh file is photographed or
/// lit.
/// \throws UsageError for a scan without a mesh; as Scene::open()
std::shared_ptr<const continuous::Scene> scene_of_scan(const dataset::Dataset& data,
                                                       const MeshSource& source,
                                                       const std::string& scan, int threads);

/// The same with the scan's panoramas, if `appearance` requires them.
/// \throws UsageError if the scan has none; as scene_of_scan()
exports::BuildingLook look_of_scan(const dataset::Dataset& data, const MeshSource& source,
                                   const std::string& scan, continuous::Appearance appearance,
                                   int threads);

/// --appearance, "mesh" or "panoramas"
void add_appearance_option(CLI::App& verb, std::string& appearance);

}  // namespace enfilade::apps
