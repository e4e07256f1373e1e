/// \file  The fields of NavMeshSettings: their names, their order in files, their ranges.
#pragma once
#include <array>

#include "enfilade/continuous/habitat/nav_mesh.h"

namespace enfilade::continuous::habitat {

/// A number of the settings, and what make_nav_mesh() takes.
struct NumberSetting {
  const char* name;
  float NavMeshSettings::*value;
  double least, most;
};
/// In the order of files.
inline constexpr std::array<NumberSetting, 13> kNumberSettings{{
    {"cell_size", &NavMeshSettings::cell_size, 0.001, 100},
    {"cell_height", &NavMeshSettings::cell_height, 0.001, 100},
    {"agent_height", &NavMeshSettings::agent_height, 0, 1000},
    {"agent_radius", &NavMeshSettings::agent_radius, 0, 1000},
    {"agent_max_climb", &NavMeshSettings::agent_max_climb, 0, 1000},
    {"agent_max_slope", &NavMeshSettings::agent_max_slope, 0, 90},
    {"region_min_size", &NavMeshSettings::region_min_size, 0, 10000},
    {"region_merge_size", &NavMeshSettings::region_merge_size, 0, 10000},
    {"edge_max_len", &NavMeshSettings::edge_max_len, 0, 10000},
    {"edge_max_error", &NavMeshSettings::edge_max_error, 0, 1000},
    {"verts_per_poly", &NavMeshSettings::verts_per_poly, 3, 6},  // Detour's most
    {"detail_sample_dist", &NavMeshSettings::detail_sample_dist, 0, 1000},
    {"detail_sample_max_error", &NavMeshSettings::detail_sample_max_error, 0, 1000},
}};

/// A switch of the settings.
struct SwitchSetting {
  const char* name;
  bool NavMeshSettings::*value;
};
/// In the order of files.
inline constexpr std::array<SwitchSetting, 4> kSwitchSettings{{
    {"filter_low_hanging_obstacles", &NavMeshSettings::filter_low_hanging_obstacles},
    {"filter_ledge_spans", &NavMeshSettings::filter_ledge_spans},
    {"filter_walkable_low_height_spans", &NavMeshSettings::filter_walkable_low_height_spans},
    {"include_static_objects", &NavMeshSettings::include_static_objects},
}};

}  // namespace enfilade::continuous::habitat
