#include "enfilade/render/gl/program.h"

#include <fmt/format.h>

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

}  // namespace

void Programs::use(const ProgramKey& key, const scan::FaceSizes& sizes) {
  Entry& entry = entries_[key.layers | (key.clamped ? 16U : 0U)];
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

}  // namespace enfilade::render::gl
