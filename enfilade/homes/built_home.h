/// \file  A synthetic home with everything that is computed from it but light and pictures.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "enfilade/capture/scan_files.h"
#include "enfilade/homes/home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/floor_polygons.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::homes {

/// A home and rays through it.
struct BuiltHome {
  Home home;  // its mesh is the tracer's too
  std::shared_ptr<const mesh::RayTracer> tracer;
};
/// Plan, mesh, furniture and lights of one home. \throws as make_plan()
BuiltHome build_home(const PlanOptions& options, HomeSurfaces surfaces = HomeSurfaces::kTextured);

/// Viewpoints on the floors of all rooms, and edges, from the mesh alone. Surfaces outside of the
/// rooms (grass, roofs) are not floor.
scan::Connectivity build_graph(const BuiltHome& built, const std::string& scan, int threads);

/// The same under the home's name in a set, as write_homes() has it before corrections.
scan::Connectivity home_graph(const BuiltHome& built, const std::string& scan, int threads);

/// The rooms as regions of Matterport3D's files, in the plan's order.
std::vector<capture::ScanRoom> scan_rooms(const Plan& plan);

/// Polygons of the floors of all rooms, from the mesh alone. The landscape around is left out.
/// \param body  size of the body
/// \throws as mesh::make_floor_polygons()
mesh::FloorPolygons make_home_floor(const BuiltHome& built, const mesh::Body& body);

/// The list's entry of a home with this graph. \param plan the home's own
HomeEntry describe(const Home& home, const PlanOptions& plan,
                   const scan::Connectivity& connectivity);

}  // namespace enfilade::homes
