/// \file  The shaders, one program for each set of outputs.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

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
  struct Entry {
    GLuint program = 0;
    GLint sizes = -1;
  };
  std::array<Entry, 32> entries_{};
};

/// Describes Vertex to the vertex array object that is bound, for the buffer that is bound.
void describe_vertices();

}  // namespace enfilade::render::gl
