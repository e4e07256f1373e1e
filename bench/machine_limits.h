/// \file  What one thread of this machine can do at most, and how long a picture must take by that.
///
/// Figures in frames a second hold for one machine. Beside what its clock and its memory allow,
/// measured in the same run, they can be carried to another.
#pragma once
#include <cstddef>
#include <cstdint>

#include "enfilade/geometry/camera.h"
#include "enfilade/render/renderer.h"

namespace enfilade::bench {

/// Bytes a second that one thread moves, in a buffer of `bytes` on large pages.
struct MemoryRates {
  std::size_t bytes = 0;
  double read = 0;               ///< in order
  double read_pieces = 0;        ///< pieces of 1 KiB in random order, about as texels are
  double write = 0;              ///< in order, by ordinary stores
  double write_past_caches = 0;  ///< in order, by stores that leave the caches alone
};

/// One thread of this machine.
struct MachineLimits {
  double clock_hz = 0;         ///< from chains of dependent additions, one a cycle
  std::size_t cache_size = 0;  ///< of the last level, bytes; 32 MiB where the system doesn't say
  MemoryRates cache, memory;   ///< a buffer well within the last level; one well beyond
};

/// Measures in CPU time of the calling thread, best of a few passes, in less than a second. Takes
/// twice the last level's size of memory, at least 256 MiB, at most 512 MiB or an eighth of what
/// the machine has.
MachineLimits measure_machine_limits();

/// Different texels that a view reads, each counted once.
struct TexelsSeen {
  double linear = 0;   ///< for colour: four a pixel
  double nearest = 0;  ///< for depth and ids: one a pixel
};
/// Mean over the discretized views of an upright panorama. Texels beyond a face's edge count as
/// those on the edge. \pre camera is valid, face_size > 0
TexelsSeen texels_seen(const Camera& camera, std::uint32_t face_size);

/// The least that one view moves, in bytes.
struct PictureTraffic {
  double texels = 0;  ///< as the files have them: 3 bytes of colour, 2 of depth or class, 4 of id
  double output = 0;
};
/// Of outputs for `views` views.
PictureTraffic picture_traffic(const Camera& camera, std::uint32_t face_size,
                               const render::Outputs& outputs, std::size_t views);

/// Seconds that memory alone takes for a view: its texels read in order, which is quicker than any
/// order that a view can have, its output written in the quickest way.
double memory_bound(const PictureTraffic& traffic, const MemoryRates& texels_in,
                    const MachineLimits& limits);

}  // namespace enfilade::bench
