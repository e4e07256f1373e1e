#include "enfilade/render/gl/targets.h"

#include <fmt/format.h>

#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::render::gl {
namespace {

struct PixelFormat {
  GLenum internal, format, type;
};
constexpr std::array<PixelFormat, scan::kLayers> kFormats{{
    {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE},
    {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT},
    {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT},
    {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT},
}};

GLenum attachment(std::size_t layer) { return GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(layer); }

std::string status_name(GLenum status) {
  switch (status) {
    case GL_FRAMEBUFFER_UNDEFINED:
      return "GL_FRAMEBUFFER_UNDEFINED";
    case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT:
      return "GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT";
    case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT:
      return "GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT";
    case GL_FRAMEBUFFER_INCOMPLETE_DRAW_BUFFER:
      return "GL_FRAMEBUFFER_INCOMPLETE_DRAW_BUFFER";
    case GL_FRAMEBUFFER_INCOMPLETE_READ_BUFFER:
      return "GL_FRAMEBUFFER_INCOMPLETE_READ_BUFFER";
    case GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE:
      return "GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE";
    case GL_FRAMEBUFFER_UNSUPPORTED:
      return "GL_FRAMEBUFFER_UNSUPPORTED";
    default:
      return fmt::format("0x{:04x}", status);
  }
}

}  // namespace

std::uint32_t most_rows(std::uint32_t width, std::uint32_t height) {
  std::array<GLint, 2> viewport{};
  GLint texture = 0;
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
  const auto widest = static_cast<std::uint32_t>(std::min(viewport[0], texture));
  const auto highest = static_cast<std::uint32_t>(std::min(viewport[1], texture));
  if (width > widest || height > highest) {
    throw Error(fmt::format("OpenGL: pictures of {} x {} pixels: the device draws at most {} x {}",
                            width, height, widest, highest));
  }
  return highest;
}

void Target::begin(LayerMask layers, std::uint32_t width, std::uint32_t height) {
  layers_ = layers;
  width_ = width;
  height_ = height;
  if (framebuffer_ == 0) glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (std::size_t layer = 0; layer < scan::kLayers; ++layer) {
    if (has(layers, layer)) allocate(layer);
  }
  if (attached_ != layers) attach();
  glViewport(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
}

void Target::allocate(std::size_t layer) {
  Picture& picture = pictures_[layer];
  if (picture.width < width_ || picture.height < height_) {
    attached_ = 0;
    glDeleteTextures(1, &picture.texture);
    picture = {0, picture.buffer, width_, height_, picture.buffer_bytes, picture.mapped};
    glGenTextures(1, &picture.texture);
    glBindTexture(GL_TEXTURE_2D, picture.texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, kFormats[layer].internal, static_cast<GLsizei>(width_),
                   static_cast<GLsizei>(height_));
  }
  const std::size_t bytes = std::size_t{width_} * height_ * kPixelBytes[layer];
  if (picture.buffer == 0) glGenBuffers(1, &picture.buffer);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, picture.buffer);
  if (picture.mapped) {  // a render() that failed left it so
    glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
    picture.mapped = false;
  }
  if (picture.buffer_bytes < bytes) {
    glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_READ);
    picture.buffer_bytes = bytes;
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  try {
    check_gl(fmt::format("a target of {} x {} pixels", width_, height_));
  } catch (const Error&) {
    picture.width = picture.height = 0;
    picture.buffer_bytes = 0;
    throw;
  }
}

void Target::attach() {
  std::array<GLenum, scan::kLayers> outputs{};
  for (std::size_t layer = 0; layer < scan::kLayers; ++layer) {
    const bool wanted = has(layers_, layer);
    outputs[layer] = wanted ? attachment(layer) : GL_NONE;
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment(layer), GL_TEXTURE_2D,
                           wanted ? pictures_[layer].texture : 0, 0);
  }
  glDrawBuffers(scan::kLayers, outputs.data());
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw Error("OpenGL: the framebuffer cannot be drawn into: " + status_name(status));
  }
  attached_ = layers_;
}

void Target::start_reading(std::uint32_t rows) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (std::size_t layer = 0; layer < scan::kLayers; ++layer) {
    if (!has(layers_, layer)) continue;
    glBindBuffer(GL_PIXEL_PACK_BUFFER, pictures_[layer].buffer);
    glReadBuffer(attachment(layer));
    glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(rows),
                 kFormats[layer].format, kFormats[layer].type, nullptr);
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  check_gl("reading pixels back");
}

std::array<const std::byte*, scan::kLayers> Target::map() {
  std::array<const std::byte*, scan::kLayers> pixels{};
  for (std::size_t layer = 0; layer < scan::kLayers; ++layer) {
    if (!has(layers_, layer)) continue;
    Picture& picture = pictures_[layer];
    glBindBuffer(GL_PIXEL_PACK_BUFFER, picture.buffer);
    const void* bytes = glMapBufferRange(
        GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(picture.buffer_bytes), GL_MAP_READ_BIT);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    if (bytes == nullptr) {
      check_gl("mapping pixels");
      throw Error("OpenGL: mapping pixels: glMapBufferRange gave nothing");
    }
    picture.mapped = true;
    pixels[layer] = static_cast<const std::byte*>(bytes);
  }
  return pixels;
}

void Target::finish_reading() {
  bool kept = true;
  for (std::size_t layer = 0; layer < scan::kLayers; ++layer) {
    if (!has(layers_, layer)) continue;
    glBindBuffer(GL_PIXEL_PACK_BUFFER, pictures_[layer].buffer);
    kept = glUnmapBuffer(GL_PIXEL_PACK_BUFFER) == GL_TRUE && kept;
    pictures_[layer].mapped = false;
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  if (!kept) throw Error("OpenGL: the pixels were lost while they were read (glUnmapBuffer)");
}

}  // namespace enfilade::render::gl
