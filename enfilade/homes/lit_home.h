/// \file  The light of synthetic homes as a data set keeps it, so that it is computed once.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade::homes {

/// Where a data set keeps the light on a home's surfaces (continuous::Scene), relative to its
/// folder: `light/SCAN.light`.
std::filesystem::path home_light_file(std::string_view scan);

/// Where it keeps the home's mesh for viewers, relative to its folder: `light/SCAN-KEY.glb.gz`. The
/// key is made of the home's options, so that a file of another home of this name is never read.
std::filesystem::path lit_home_file(const HomeEntry& home);

/// That file's content: the mesh with its light in the colours of its corners
/// (mesh::with_vertex_light()), as mesh::to_packed_glb().
/// \param light on built.home.mesh  \param threads 0: all cores; does not change the result
std::string packed_lit_home(const BuiltHome& built, const mesh::SurfaceLight& light, int threads);
/// The same with light that is computed here, in some seconds: coarser than that of pictures, as
/// corners of triangles do not show more.
std::string packed_lit_home(const BuiltHome& built, int threads);

}  // namespace enfilade::homes
