#include "enfilade/service/browsing/layers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "enfilade/draw/colour_maps.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::service::browsing {
namespace {

using nlohmann::ordered_json;

std::string hex(const draw::Rgb& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

ordered_json depth_legend(const image::CubeMap<std::uint16_t>& depth) {
  constexpr int kColours = 16;  // as many as the map is made of
  auto colours = ordered_json::array();
  for (int k = 0; k < kColours; ++k) {
    colours.push_back(hex(draw::depth_colour(static_cast<double>(k) / (kColours - 1))));
  }
  return {{"farthest", farthest_of(depth)}, {"colours", colours}};
}

ordered_json class_legend(const image::CubeMap<std::uint16_t>& classes) {
  std::map<std::uint32_t, std::size_t> areas;
  std::size_t texels = 0;
  for (const image::Image16& face : classes) {
    for (const draw::IdArea& area : draw::count_ids(face)) areas[area.id] += area.pixels;
    texels += face.pixels.size();
  }
  std::vector<std::pair<std::uint32_t, std::size_t>> order(areas.begin(), areas.end());
  std::ranges::stable_sort(order, std::greater{}, &std::pair<std::uint32_t, std::size_t>::second);
  auto list = ordered_json::array();
  for (const auto& [id, pixels] : order) {
    const double share = static_cast<double>(pixels) / static_cast<double>(texels);
    list.push_back({{"id", id},
                    {"name", mesh::class_name(id)},
                    {"colour", hex(draw::id_colour(id))},
                    {"share", std::round(share * 1e4) / 1e4}});
  }
  return list;
}

}  // namespace

std::string distance_grid(const scan::PanoramaSource& source, ViewpointIndex viewpoint) {
  if (source.face_sizes(viewpoint)[index(scan::Layer::kDepth)] == 0) {
    throw source.lacks(scan::Layer::kDepth, viewpoint);
  }
  const auto depth =
      scan::read_panorama(source, viewpoint, scan::mask_of(scan::Layer::kDepth)).depth;
  const std::size_t size = depth[0].width, n = std::min(size, kMostDistances);
  constexpr unsigned kStep = 8;  // 2 mm
  std::string grid;
  grid.reserve(kCubeFaces * n * n * 2);
  const auto middle = [&](std::size_t k) { return (2 * k + 1) * size / (2 * n); };
  for (const image::Image16& face : depth) {
    for (std::size_t y = 0; y < n; ++y) {
      for (std::size_t x = 0; x < n; ++x) {
        const unsigned reading = *face.at(middle(x), middle(y));
        // What is nearer than 2 mm must not become unknown.
        const unsigned kept = reading == 0 ? 0 : std::max(reading / kStep, 1U) * kStep;
        grid.push_back(static_cast<char>(kept & 255U));
        grid.push_back(static_cast<char>(kept >> 8U));
      }
    }
  }
  return grid;
}

double farthest_of(const image::CubeMap<std::uint16_t>& depth) {
  double farthest = 0;
  for (const image::Image16& face : depth) {
    farthest = std::max(farthest, draw::farthest_depth(face));
  }
  return farthest;
}

ordered_json legends_json(const scan::PanoramaSource& source, ViewpointIndex viewpoint) {
  const scan::FaceSizes sizes = source.face_sizes(viewpoint);
  ordered_json legends{{"depth", nullptr}, {"classes", nullptr}};
  if (sizes[index(scan::Layer::kDepth)] != 0) {
    legends["depth"] = depth_legend(
        scan::read_panorama(source, viewpoint, scan::mask_of(scan::Layer::kDepth)).depth);
  }
  if (sizes[index(scan::Layer::kClass)] != 0) {
    legends["classes"] = class_legend(
        scan::read_panorama(source, viewpoint, scan::mask_of(scan::Layer::kClass)).classes);
  }
  return legends;
}

}  // namespace enfilade::service::browsing
