/// \file  Conversion of blocks of pixels to the output formats; also used by the GL back end and
/// for equirectangular pictures.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render::cpu {

/// Buffer for blocks before they go to memory past the caches, in whole cache lines. It is copied
/// only when the next block is prepared. A load that reads the bytes of several recent stores waits
/// until all have left the processor's store buffer.
class Staging {
 public:
  explicit Staging(const PixelKernels& kernels) : kernels_(kernels) {}
  /// Memory for this block, aligned to 64. \pre all of a block are of kBlock pixels at most
  std::byte* take(std::size_t bytes);
  /// Has flush() copy that.
  void send(std::byte* to, const std::byte* from, std::size_t bytes);
  /// Copies the buffered bytes, and ends the block.
  void flush();

 private:
  struct Copy {
    std::byte* to;
    const std::byte* from;
    std::size_t bytes;
  };
  static constexpr std::size_t kLine = 64;
  static constexpr std::size_t kCopies = 32;  // three planes and depth of seven stretches

  const PixelKernels& kernels_;
  std::size_t used_ = 0, count_ = 0;
  std::array<Copy, kCopies> copies_;
  // A block's colour as three planes of floats and its depth, each piece from a new line on.
  alignas(kLine) std::array<std::byte, 16 * kBlock + kCopies * kLine> memory_;
};

/// Where a block's pixels go: `first` is the place of its first pixel in its view, row-major.
struct BlockPlace {
  std::size_t view = 0;
  std::size_t first = 0;
  std::size_t count = 0;
  std::size_t pixels = 0;      ///< per view
  Staging* staging = nullptr;  ///< if the batch is larger than the caches; null: straight to memory

  std::size_t pixel() const { return view * pixels + first; }  ///< place in the whole batch
};

/// Values of a block of pixels; only those of layers among the outputs are read.
struct Values {
  const std::uint32_t* rgba;
  const std::uint16_t *depth, *classes;
  const std::uint32_t* instances;
  const float* depth_factor;  ///< turns a pixel's ray length into the output's measure
};

/// Converts values to the formats of some outputs. Must not outlive its arguments.
class PixelPacker {
 public:
  PixelPacker(const PixelKernels& kernels, const Outputs& outputs, bool eight_bit_depth) noexcept;
  void pack(const Values& values, const BlockPlace& place) const;
  /// Draws colour from a run of taps, as many as place.count, straight into the output's format;
  /// makes the taps of the block ahead.
  void draw_colour(const TapRun& run, const Ahead& ahead, const BlockPlace& place) const;
  /// The same for depth. `factor` as in Values.
  void draw_depth(const PlaceRun& run, const float* factor, const BlockPlace& place) const;
  /// Classes and instances.
  void pack_ids(const Values& values, const BlockPlace& place) const;

 private:
  void pack_colour(const std::uint32_t* rgba, const BlockPlace& place) const;
  void pack_depth(const std::uint16_t* units, const float* factor, const BlockPlace& place) const;
  void pack_classes(const std::uint16_t* values, const BlockPlace& place) const;

  const PixelKernels& kernels_;
  const Outputs& outputs_;
  bool eight_bit_depth_;
  PlanarScale scale_{};  // of colour
};

/// Factors and summands of planar formats.
PlanarScale planar_scale(const Normalisation& normalisation) noexcept;

/// What turns a distance along each pixel's ray into the measure: 1 / the ray's length for kZ,
/// else 1.
std::vector<float> depth_factors(const Camera& camera, DepthMeasure measure);

}  // namespace enfilade::render::cpu
