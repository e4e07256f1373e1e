/// \file  The shaders, one program for each set of outputs, and what they draw into.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/render/detail/layers.h"
#include "enfilade/render/gl/context.h"

namespace enfilade::render::gl {

/// How OpenGL keeps a layer's values, as texels of faces and as pixels of targets, by index(Layer).
struct TexelFormat {
  GLenum internal, format, type;
};
inline constexpr std::array<TexelFormat, scan::kLayers> kTexelFormats{{
    {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE},
    {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT},
    {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT},
    {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT},
}};

/// A corner of a triangle. All but `position` is the same for the whole piece of a picture.
struct Vertex {
  std::array<float, 2> position;                  ///< of the target, -1..1
  std::array<float, 2> middle;                    ///< of the picture, pixels of the target
  std::array<std::array<float, 3>, 3> forms;      ///< FaceForms: right, down, forward
  std::array<std::int32_t, scan::kLayers> slots;  ///< layers of the face textures
};

/// The variant of a program.
struct ProgramKey {
  scan::LayerMask layers = 0;
  bool clamped = false;  ///< Legacy::clamped_edges
};

/// Links each program at its first use. Belongs to the context that is current then.
class Programs {
 public:
  /// Makes the program current and sets the faces' sizes (border not counted) by layer. Colour is
  /// sampled from texture unit 0, depth 1, class 2, instance 3; outputs have these numbers too.
  /// \throws Error with the compiler's or linker's log
  void use(const ProgramKey& key, const scan::FaceSizes& sizes);

 private:
  struct LinkedProgram {
    GLuint program = 0;
    GLint sizes = -1;
  };
  std::array<LinkedProgram, 32> entries_{};
};

/// Describes Vertex to the vertex array object that is bound, for the buffer that is bound.
void describe_vertices();

/// One picture for each layer, all drawn at once, and the buffers that they are read back through.
/// Views lie below one another, so that the driver draws a whole batch as one picture and reads it
/// back at once. Belongs to the current context.
class RenderTarget {
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
