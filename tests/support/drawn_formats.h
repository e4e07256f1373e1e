/// \file  Pictures in any combination of formats, in memory that shows what was not written.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/render/renderer.h"

namespace enfilade::render::testing {

/// Which outputs, and how they are stored.
struct Formats {
  std::optional<ColourFormat> colour;
  std::optional<DepthFormat> depth;
  std::optional<ClassFormat> classes;
  bool instances = false;
  DepthMeasure measure = DepthMeasure::kZ;
};

/// Memory of the host for such outputs.
struct Drawn {
  std::vector<std::byte> colour, depth, classes;
  std::vector<std::uint32_t> instances;
};

/// Outputs of so many pixels, all views together, into `memory`, which is filled with 0xA5.
inline Outputs outputs_of(const Formats& formats, std::size_t pixels, Drawn& memory) {
  Outputs out;
  const auto fill = [&](std::vector<std::byte>& bytes, std::size_t pixel) {
    bytes.assign(pixels * pixel, std::byte{0xA5});
    return std::span<std::byte>(bytes);
  };
  if (formats.colour) {
    out.colour =
        ColourOutput{*formats.colour, kImageNet, fill(memory.colour, pixel_bytes(*formats.colour))};
  }
  if (formats.depth) {
    out.depth = DepthOutput{*formats.depth, formats.measure,
                            fill(memory.depth, pixel_bytes(*formats.depth))};
  }
  if (formats.classes) {
    out.classes =
        ClassOutput{*formats.classes, fill(memory.classes, pixel_bytes(*formats.classes))};
  }
  if (formats.instances) {
    memory.instances.assign(pixels, 0xA5A5A5A5U);
    out.instances = InstanceOutput{memory.instances};
  }
  return out;
}

}  // namespace enfilade::render::testing
