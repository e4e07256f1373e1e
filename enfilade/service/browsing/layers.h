/// \file  The viewer's data: distances in each direction, and legends of the colours.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "enfilade/image/image.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::service::browsing {

/// Points of a face's edge in distance_grid(), at most.
inline constexpr std::size_t kMostDistances = 96;

/// Distances in each direction: six faces by index(CubeFace), each of n x n numbers in rows.
/// Numbers are 16 bits little-endian, quarter millimetres along the ray, 0: unknown. n is the size
/// of the depth faces, at most kMostDistances. They are single readings: means would make surfaces
/// that do not exist. Rounded to 2 mm, which compresses in half.
/// \throws LookupError if the viewpoint has no depth; as scan::PanoramaSource
std::string distance_grid(const scan::PanoramaSource& source, ViewpointIndex viewpoint);

/// One scale for the six depth pictures of a panorama, or the edges of faces would show: metres.
double farthest_of(const image::CubeMap<std::uint16_t>& depth);

/// The legends of a panorama's depth and classes in the colours of draw/colour_maps.h: {"depth":
/// {"farthest", "colours"}, "classes": [{"id", "name", "colour", "share"}]}, the largest area
/// first. A layer without pictures is null.
/// \throws as scan::PanoramaSource
nlohmann::ordered_json legends_json(const scan::PanoramaSource& source, ViewpointIndex viewpoint);

}  // namespace enfilade::service::browsing
