#include "enfilade/render/gl/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::render::gl {
namespace {

constexpr const char* kVertexShader = R"(
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 middle;
layout(location = 2) in vec3 right;
layout(location = 3) in vec3 down;
layout(location = 4) in vec3 forward;
layout(location = 5) in ivec4 slots;
flat out vec2 middle_;
flat out vec3 right_, down_, forward_;
flat out ivec4 slots_;
void main() {
  middle_ = middle;
  right_ = right;
  down_ = down;
  forward_ = forward;
  slots_ = slots;
  gl_Position = vec4(position, 0.0, 1.0);
}
)";

// The layers after colour are read alike: {} stands for the layer's number.
constexpr const char* kValuesOutput = R"(
uniform usampler2DArray faces_{0};
layout(location = {0}) out uint value_{0};
)";
constexpr const char* kValuesRead = R"(
  value_{0} = texelFetch(faces_{0}, texel(point, sizes[{0}], slots_[{0}]), 0).r;
)";

constexpr const char* kFragmentInputs = R"(
flat in vec2 middle_;
flat in vec3 right_, down_, forward_;
flat in ivec4 slots_;
uniform vec4 sizes;
#ifdef COLOUR
uniform sampler2DArray faces_0;
layout(location = 0) out vec4 colour;
#endif

ivec3 texel(vec2 point, float size, int slot) {
  return ivec3(clamp(floor(point * (0.5 * size) + 0.5 * size), 0.0, size - 1.0), slot);
}
)";

// A pixel's ray is computed from where the pixel is, not interpolated between corners, so that it
// does not depend on how the picture was cut.
constexpr const char* kFragmentMain = R"(
void main() {
  vec3 at = vec3(1.0, gl_FragCoord.xy - middle_);
  vec2 point = vec2(dot(right_, at), dot(down_, at)) / dot(forward_, at);
#ifdef COLOUR
  vec2 place = point * (0.5 * sizes.x) + 0.5 * sizes.x;
#ifdef CLAMPED
  place = clamp(place, 0.5, sizes.x - 0.5);
#endif
  // The border is a texel on each side.
  vec3 inside = vec3((place + 1.0) / (sizes.x + 2.0), float(slots_.x));
  colour = vec4(textureLod(faces_0, inside, 0.0).rgb, 1.0);
#endif
)";

std::string header_of(const ProgramKey& key) {
  std::string text = "#version 430 core\n";
  if (detail::has(key.layers, scan::Layer::kColour)) text += "#define COLOUR\n";
  if (key.clamped) text += "#define CLAMPED\n";
  return text;
}

std::string fragment_shader(const ProgramKey& key) {
  std::string inputs = kFragmentInputs, body = kFragmentMain;
  for (const scan::Layer layer : detail::kEachLayer) {
    if (layer == scan::Layer::kColour || !detail::has(key.layers, layer)) continue;
    inputs += fmt::format(kValuesOutput, index(layer));
    body += fmt::format(kValuesRead, index(layer));
  }
  return inputs + body + "}\n";
}

// `get`, `log`: glGetShaderiv and glGetShaderInfoLog, or those of programs.
template <class Get, class Log>
std::string log_of(GLuint object, Get get, Log log) {
  GLint size = 0;
  get(object, GL_INFO_LOG_LENGTH, &size);
  std::string text(static_cast<std::size_t>(size > 0 ? size : 1), ' ');
  GLsizei written = 0;
  log(object, static_cast<GLsizei>(text.size()), &written, text.data());
  text.resize(static_cast<std::size_t>(written));
  return text;
}

void attach(GLuint program, GLenum stage, const char* name, const std::string& source) {
  const GLuint shader = glCreateShader(stage);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE) {
    const std::string log = log_of(
        shader, [](auto... a) { glGetShaderiv(a...); },
        [](auto... a) { glGetShaderInfoLog(a...); });
    glDeleteShader(shader);
    throw Error(fmt::format("OpenGL: the {} shader does not compile: {}", name, log));
  }
  glAttachShader(program, shader);
  glDeleteShader(shader);  // deleted with the program
}

GLuint link(const ProgramKey& key) {
  const GLuint program = glCreateProgram();
  try {
    const std::string header = header_of(key);
    attach(program, GL_VERTEX_SHADER, "vertex", header + kVertexShader);
    attach(program, GL_FRAGMENT_SHADER, "fragment", header + fragment_shader(key));
    glLinkProgram(program);
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
      const std::string log = log_of(
          program, [](auto... a) { glGetProgramiv(a...); },
          [](auto... a) { glGetProgramInfoLog(a...); });
      throw Error("OpenGL: the shaders do not link: " + log);
    }
    check_gl("linking shaders");
  } catch (const Error&) {
    glDeleteProgram(program);
    throw;
  }
  return program;
}

GLenum attachment(scan::Layer layer) {
  return GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(index(layer));
}

}  // namespace

void Programs::use(const ProgramKey& key, const scan::FaceSizes& sizes) {
  LinkedProgram& entry = entries_[key.layers | (key.clamped ? 16U : 0U)];
  if (entry.program == 0) {
    entry.program = link(key);
    entry.sizes = glGetUniformLocation(entry.program, "sizes");
    glUseProgram(entry.program);
    for (const scan::Layer layer : detail::kEachLayer) {
      if (!detail::has(key.layers, layer)) continue;
      const std::string sampler = fmt::format("faces_{}", index(layer));
      glUniform1i(glGetUniformLocation(entry.program, sampler.c_str()),
                  static_cast<GLint>(index(layer)));
    }
  }
  glUseProgram(entry.program);
  const auto size = [&](std::size_t layer) { return static_cast<float>(sizes[layer]); };
  glUniform4f(entry.sizes, size(0), size(1), size(2), size(3));
}

void describe_vertices() {
  const auto floats = [](GLuint location, GLint count, std::size_t offset) {
    glEnableVertexAttribArray(location);
    // OpenGL takes the offset as a pointer.
    glVertexAttribPointer(location, count, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                          reinterpret_cast<const void*>(offset));
  };
  floats(0, 2, offsetof(Vertex, position));
  floats(1, 2, offsetof(Vertex, middle));
  for (GLuint form = 0; form < 3; ++form) {
    floats(2 + form, 3, offsetof(Vertex, forms) + form * sizeof(std::array<float, 3>));
  }
  glEnableVertexAttribArray(5);
  glVertexAttribIPointer(5, 4, GL_INT, sizeof(Vertex),
                         reinterpret_cast<const void*>(offsetof(Vertex, slots)));
}

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

void RenderTarget::begin(scan::LayerMask layers, std::uint32_t width, std::uint32_t height) {
  layers_ = layers;
  width_ = width;
  height_ = height;
  if (framebuffer_ == 0) glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (const scan::Layer layer : detail::kEachLayer) {
    if (detail::has(layers, layer)) allocate(layer);
  }
  if (attached_ != layers) attach();
  glViewport(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
}

void RenderTarget::allocate(scan::Layer layer) {
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

void RenderTarget::attach() {
  std::array<GLenum, scan::kLayers> outputs{};
  for (const scan::Layer layer : detail::kEachLayer) {
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

void RenderTarget::start_reading(std::uint32_t rows) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (const scan::Layer layer : detail::kEachLayer) {
    if (!detail::has(layers_, layer)) continue;
    glBindBuffer(GL_PIXEL_PACK_BUFFER, pictures_[index(layer)].buffer);
    glReadBuffer(attachment(layer));
    glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(rows),
                 kTexelFormats[index(layer)].format, kTexelFormats[index(layer)].type, nullptr);
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  check_gl("reading pixels back");
}

std::array<const std::byte*, scan::kLayers> RenderTarget::map() {
  std::array<const std::byte*, scan::kLayers> pixels{};
  for (const scan::Layer layer : detail::kEachLayer) {
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

void RenderTarget::finish_reading() {
  bool kept = true;
  for (const scan::Layer layer : detail::kEachLayer) {
    if (!detail::has(layers_, layer)) continue;
    glBindBuffer(GL_PIXEL_PACK_BUFFER, pictures_[index(layer)].buffer);
    kept = glUnmapBuffer(GL_PIXEL_PACK_BUFFER) == GL_TRUE && kept;
    pictures_[index(layer)].mapped = false;
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  if (!kept) throw Error("OpenGL: the pixels were lost while they were read (glUnmapBuffer)");
}

}  // namespace enfilade::render::gl
