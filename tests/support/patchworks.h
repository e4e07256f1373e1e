/// \file  Panoramas whose colours, classes and distances go together, to learn from.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/scan/panorama_source.h"
#include "tests/support/panoramas.h"

namespace enfilade::tests {

/// Grey walls (class 1, 4 m off) with patches of things at random places: red chairs (3), green
/// plants (14), blue beds (11), all 2 m off.
inline scan::Panorama patchwork(std::uint64_t seed) {
  constexpr std::uint32_t kSize = 32, kPatch = 8;
  struct Thing {
    std::uint16_t object;
    std::array<std::uint8_t, 3> colour;
    std::uint16_t distance;
  };
  static constexpr std::array<Thing, 4> kThings{{{1, {128, 128, 128}, 16000},
                                                 {3, {220, 30, 30}, 8000},
                                                 {14, {30, 220, 30}, 8000},
                                                 {11, {30, 30, 220}, 8000}}};
  scan::Panorama p = scan::make_panorama(kSize);
  Rng rng(seed);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    std::array<std::size_t, 16> patches{};
    for (std::size_t& patch : patches) patch = rng.below(3) == 0 ? rng.below(4) : 0;
    for (std::uint32_t y = 0; y < kSize; ++y) {
      for (std::uint32_t x = 0; x < kSize; ++x) {
        const Thing& thing = kThings.at(patches.at(y / kPatch * 4 + x / kPatch));
        std::ranges::copy(thing.colour, p.colour[k].at(x, y));
        *p.classes[k].at(x, y) = thing.object;
        *p.depth[k].at(x, y) = thing.distance;
      }
    }
  }
  return p;
}

/// n of them, each a viewpoint of a scan.
inline std::shared_ptr<const scan::PanoramaSource> patchworks(const std::string& scan,
                                                              std::size_t n, std::uint64_t seed) {
  std::vector<scan::Panorama> panoramas;
  for (std::size_t i = 0; i < n; ++i) panoramas.push_back(patchwork(seed + i));
  return std::make_shared<scan::MemoryPanoramas>(scan::testing::row_of_viewpoints(scan, n),
                                                 std::move(panoramas));
}

}  // namespace enfilade::tests
