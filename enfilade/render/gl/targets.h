/// \file  Render targets and their read-back.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/render/gl/program.h"

namespace enfilade::render::gl {

/// One picture for each layer, all drawn at once, and the buffers that they are read back through.
/// Views lie below one another, so that the driver draws a whole batch as one picture and reads it
/// back at once. Belongs to the current context.
class Target {
 public:
  /// Makes the target the one that is drawn into, with at least this size.
  /// \throws Error if it is too large for the device, incomplete, or out of memory
  void begin(scan::LayerMask layers, std::uint32_t width, std::uint32_t height);
  /// Starts to copy the first rows into the buffers. Does not wait where the driver can copy by
  /// itself. \throws Error
  void start_reading(std::uint32_t rows);
  /// The rendered pictures, by layer; waits for them. Rows from the top, no padding. Valid until
  /// finish_reading().
  /// \throws Error
  std::array<const std::byte*, scan::kLayers> map();
  /// \throws Error if the driver lost the pixels meanwhile
  void finish_reading();

 private:
  void allocate(scan::Layer layer);
  void attach();

  GLuint framebuffer_ = 0;
  scan::LayerMask layers_ = 0, attached_ = 0;
  std::uint32_t width_ = 0, height_ = 0;
  struct Picture {
    GLuint texture = 0, buffer = 0;
    std::uint32_t width = 0, height = 0;
    std::size_t buffer_bytes = 0;
    bool mapped = false;
  };
  std::array<Picture, scan::kLayers> pictures_{};
};

/// The most rows that a target may have. \throws Error if a picture is too wide or high
std::uint32_t most_rows(std::uint32_t width, std::uint32_t height);

}  // namespace enfilade::render::gl
