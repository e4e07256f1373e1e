#include "enfilade/render/gl/targets.h"

#include <fmt/format.h>

#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::render::gl {
namespace {

using scan::Layer;

GLenum attachment(Layer layer) { return GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(index(layer)); }

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

void Target::begin(scan::LayerMask layers, std::uint32_t width, std::uint32_t height) {
  layers_ = layers;
  width_ = width;
  height_ = height;
  if (framebuffer_ == 0) glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (const Layer layer : detail::kEachLayer) {
    if (detail::has(layers, layer)) allocate(layer);
  }
  if (attached_ != layers) attach();
  glViewport(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
}

void Target::allocate(Layer layer) {
  Picture& picture = pictures_[index(layer)];
  if (picture.width < width_ || picture.height < height_) {
    attached_ = 0;
    glDeleteTextures(1, &picture.texture);
    picture = {0, picture.buffer, width_, height_, picture.buffer_bytes, picture.mapped};
    glGenTextures(1, &picture.texture);
    glBindTexture(GL_TEXTURE_2D, picture.texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, kTexelFormats[index(layer)].internal,
                   static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
  }
  const std::size_t bytes = std::size_t{width_} * height_ * detail::kTexelBytes[index(layer)];
  if (picture.buffer == 0) glGenBuffers(1, &picture.buffer);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, picture.buffer);
  if (picture.mapped) {  // left so by a render() that failed
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
  for (const Layer layer : detail::kEachLayer) {
    const bool wanted = detail::has(layers_, layer);
    outputs[index(layer)] = wanted ? attachment(layer) : GL_NONE;
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment(layer), GL_TEXTURE_2D,
                           wanted ? pictures_[index(layer)].texture : 0, 0);
  }
  glDrawBuffers(scan::kLayers, outputs.data());
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw Error("OpenGL: the framebuffer cannot be drawn into: " + gl_name(status));
  }
  attached_ = layers_;
}

void Target::start_reading(std::uint32_t rows) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (const Layer layer : detail::kEachLayer) {
    if (!detail::has(layers_, layer)) continue;
    glBindBuffer(GL_PIXEL_PACK_BUFFER, pictures_[index(layer)].buffer);
    glReadBuffer(attachment(layer));
    glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(rows),
                 kTexelFormats[index(layer)].format, kTexelFormats[index(layer)].type, nullptr);
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  check_gl("reading pixels back");
}

std::array<const std::byte*, scan::kLayers> Target::map() {
  std::array<const std::byte*, scan::kLayers> pixels{};
  for (const Layer layer : detail::kEachLayer) {
    if (!detail::has(layers_, layer)) continue;
    Picture& picture = pictures_[index(layer)];
    glBindBuffer(GL_PIXEL_PACK_BUFFER, picture.buffer);
    const void* bytes = glMapBufferRange(
        GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(picture.buffer_bytes), GL_MAP_READ_BIT);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    if (bytes == nullptr) {
      check_gl("mapping pixels");
      throw Error("OpenGL: mapping pixels: glMapBufferRange gave nothing");
    }
    picture.mapped = true;
    pixels[index(layer)] = static_cast<const std::byte*>(bytes);
  }
  return pixels;
}

void Target::finish_reading() {
  bool kept = true;
  for (const Layer layer : detail::kEachLayer) {
    if (!detail::has(layers_, layer)) continue;
    glBindBuffer(GL_PIXEL_PACK_BUFFER, pictures_[index(layer)].buffer);
    kept = glUnmapBuffer(GL_PIXEL_PACK_BUFFER) == GL_TRUE && kept;
    pictures_[index(layer)].mapped = false;
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  if (!kept) throw Error("OpenGL: the pixels were lost while they were read (glUnmapBuffer)");
}

}  // namespace enfilade::render::gl
