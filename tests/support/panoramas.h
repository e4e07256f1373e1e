/// \file  Small panoramas for tests, in which every texel can be told from its neighbours.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan::testing {

/// Viewpoints "v0", "v1", ... a metre apart along +x at eye height 1.5 m, level and looking along
/// +y, each connected to the next.
inline Connectivity row_of_viewpoints(const std::string& scan, std::size_t count) {
  Connectivity c{scan, scan + "_connectivity.json", {}};
  for (std::size_t i = 0; i < count; ++i) {
    ConnectivityEntry entry;
    entry.id = "v" + std::to_string(i);
    // Columns: right = +x, down = -z, look = +y.
    entry.pose = {1, 0, 0, static_cast<double>(i), 0, 0, 1, 0, 0, -1, 0, 1.5, 0, 0, 0, 1};
    entry.height = 1.5;
    if (i > 0) entry.unobstructed.emplace_back(i - 1);
    if (i + 1 < count) entry.unobstructed.emplace_back(i + 1);
    entry.visible = entry.unobstructed;
    c.entries.push_back(entry);
  }
  return c;
}

/// All four layers: smooth colours and depths that depend on place, face and seed, with holes in
/// depth; a few classes; instances above 2^24.
inline Panorama panorama(std::uint32_t size, std::uint64_t seed) {
  Panorama p = make_panorama(size);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    Rng rng(seed, k);
    const std::uint64_t base = rng.below(200);
    for (std::size_t y = 0; y < size; ++y) {
      for (std::size_t x = 0; x < size; ++x) {
        std::uint8_t* rgb = p.colour[k].at(x, y);
        rgb[0] = static_cast<std::uint8_t>(base + x * 50 / size);
        rgb[1] = static_cast<std::uint8_t>(base + y * 50 / size);
        rgb[2] = static_cast<std::uint8_t>(40 * k + seed % 40);
        *p.depth[k].at(x, y) = rng.below(16) == 0
                                   ? std::uint16_t{0}
                                   : static_cast<std::uint16_t>(8000 + 100 * base + 3 * x + 7 * y);
        *p.classes[k].at(x, y) = static_cast<std::uint16_t>(300 * (x * 4 / size) + y * 4 / size);
        *p.instances[k].at(x, y) = static_cast<std::uint32_t>((seed << 25) + 70'000 * k + x / 4);
      }
    }
  }
  return p;
}

/// `count` panoramas of all layers with different pictures.
inline std::shared_ptr<const MemoryPanoramas> memory_panoramas(const std::string& scan,
                                                               std::size_t count,
                                                               std::uint32_t size) {
  std::vector<Panorama> panoramas;
  for (std::size_t i = 0; i < count; ++i) panoramas.push_back(panorama(size, i + 1));
  return std::make_shared<const MemoryPanoramas>(row_of_viewpoints(scan, count),
                                                 std::move(panoramas));
}

/// Room for six colour faces with their borders.
class BorderedMap {
 public:
  explicit BorderedMap(std::uint32_t size) {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      cells_[k].resize(image::ColourCells::bytes(size));
      faces_[k] = {cells_[k].data(), size};
    }
  }
  BorderedMap(const BorderedMap&) = delete;
  BorderedMap& operator=(const BorderedMap&) = delete;

  const std::array<image::ColourCells, kCubeFaces>& faces() const { return faces_; }
  /// All texels of a face and of its border.
  const std::vector<std::uint8_t>& cells(std::size_t face) const { return cells_[face]; }

 private:
  std::array<std::vector<std::uint8_t>, kCubeFaces> cells_;
  std::array<image::ColourCells, kCubeFaces> faces_;
};

}  // namespace enfilade::scan::testing
