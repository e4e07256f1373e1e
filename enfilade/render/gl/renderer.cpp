#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/gl/context.h"
#include "enfilade/render/gl/face_textures.h"
#include "enfilade/render/gl/pieces.h"
#include "enfilade/render/gl/program.h"

namespace enfilade::render::gl {
namespace {

using detail::has;
using detail::kEachLayer;
using detail::kTexelBytes;
using scan::Layer;

// Size of one target: a batch fills several, so that one is drawn while another is packed.
constexpr std::size_t kTargetBytes = std::size_t{8} << 20;
// With more rows, floats could not distinguish the points of the grid on which hardware puts
// corners (1/256 pixel).
constexpr std::uint32_t kMostRows = 8192;

std::array<float, 3> to_floats(const std::array<double, 3>& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// Values of a layer from a pixel on; null if the layer is not drawn.
template <class T>
const T* values_of(const std::array<const std::byte*, scan::kLayers>& pixels, Layer layer,
                   std::size_t first) {
  const auto* values = reinterpret_cast<const T*>(pixels[index(layer)]);
  return values == nullptr ? nullptr : values + first;
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(std::shared_ptr<FaceCache> faces, const RendererConfig& config,
             std::shared_ptr<GlContext> context);
  void render(const Camera& camera, std::span<const View> views, const Outputs& outputs) override;
  std::string description() const override;

 private:
  /// Views that are in one target.
  struct Part {
    std::size_t first = 0, count = 0;
  };
  /// All of a call to render(), fixed while it runs.
  struct Frame {
    Camera camera;
    std::span<const View> views;
    Outputs outputs;
    ProgramKey program;
    std::size_t most = 0;  ///< views in a target
  };

  /// A face as a view sees it.
  struct Look {
    FaceForms forms;
    std::array<std::int32_t, scan::kLayers> slots{};
  };

  void draw_all(const Frame& frame);
  std::size_t draw(const Frame& frame, std::size_t first, RenderTarget& target);
  bool take_panorama(const Frame& frame, const View& view, bool first);
  bool add_view(const Frame& frame, const View& view, std::size_t place);
  void draw_edges_again(const Frame& frame, const PixelRays& rays,
                        const std::array<std::optional<Look>, kCubeFaces>& looks,
                        std::size_t place);
  void add_polygon(const Frame& frame, const Look& look, std::span<const PicturePoint> corners,
                   std::size_t place);
  void make_depth_factors(const Camera& camera, DepthMeasure measure);
  void finish(const Frame& frame, const Part& part, RenderTarget& target);

  std::shared_ptr<FaceCache> faces_;
  Legacy legacy_;
  std::shared_ptr<GlContext> context_;
  Programs programs_;
  FaceTextures textures_;
  std::array<RenderTarget, 2> targets_;
  // Pixels between the points of the grid on which the hardware puts corners.
  double mesh_ = 0;
  scan::FaceSizes sizes_{};  // of the panoramas in the target that is being drawn
  std::vector<Vertex> vertices_;
  std::vector<PicturePoint> edge_pixels_;
  std::optional<std::pair<Camera, DepthMeasure>> depth_factors_of_;
  std::vector<float> depth_factors_;  // what a ray's length is multiplied with, for each pixel
};

GlRenderer::GlRenderer(std::shared_ptr<FaceCache> faces, const RendererConfig& config,
                       std::shared_ptr<GlContext> context)
    : faces_(std::move(faces)),
      legacy_(config.legacy),
      context_(std::move(context)),
      textures_(faces_, faces_->config().bytes) {
  const Current current(*context_);
  GLuint array = 0, buffer = 0;
  glGenVertexArrays(1, &array);
  glBindVertexArray(array);
  glGenBuffers(1, &buffer);
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  describe_vertices();
  glDisable(GL_DITHER);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  GLint bits = 4;
  glGetIntegerv(GL_SUBPIXEL_BITS, &bits);
  mesh_ = std::ldexp(1.0, -bits);
  programs_.use({1U << index(Layer::kColour), legacy_.clamped_edges}, {});
  check_gl("setting up");
}

std::string GlRenderer::description() const {
  const std::string& version = context_->version();
  return fmt::format("gl ({}, OpenGL {})", context_->renderer(),
                     version.substr(0, version.find(' ')));
}

void GlRenderer::render(const Camera& camera, std::span<const View> views, const Outputs& outputs) {
  validate(camera, views, outputs, faces_->panoramas());
  detail::refuse_stream(outputs);
  const scan::LayerMask layers = detail::layers_of(outputs);
  if (views.empty() || layers == 0) return;
  const Current current(*context_);
  std::size_t bytes = 0;
  for (const Layer layer : kEachLayer) {
    if (has(layers, layer)) bytes += kTexelBytes[index(layer)] * camera.width * camera.height;
  }
  const std::size_t rows =
      std::max(camera.height, std::min(kMostRows, most_rows(camera.width, camera.height)));
  const std::size_t most = std::clamp<std::size_t>(kTargetBytes / bytes, 1, rows / camera.height);
  if (outputs.depth) make_depth_factors(camera, outputs.depth->measure);
  draw_all({camera, views, outputs, {layers, legacy_.clamped_edges}, std::min(most, views.size())});
}

// While one target is drawn, the one before is copied and the one before that is packed. Copying
// comes after drawing: a software driver waits for what it copies, and has work meanwhile.
void GlRenderer::draw_all(const Frame& frame) {
  std::array<Part, 3> parts;
  for (std::size_t k = 0, next = 0, packed = 0; packed < frame.views.size(); ++k) {
    Part& part = parts[k % 3];
    part = {next, 0};
    if (next < frame.views.size()) part.count = draw(frame, next, targets_[k % 2]);
    next += part.count;
    const Part& drawn = parts[(k + 2) % 3];
    if (k >= 1 && drawn.count > 0) {
      targets_[(k - 1) % 2].start_reading(
          static_cast<std::uint32_t>(drawn.count * frame.camera.height));
    }
    const Part& copied = parts[(k + 1) % 3];
    if (k >= 2) finish(frame, copied, targets_[k % 2]);
    packed += k >= 2 ? copied.count : 0;
  }
}

std::size_t GlRenderer::draw(const Frame& frame, std::size_t first, RenderTarget& target) {
  textures_.begin_turn();
  vertices_.clear();
  const std::size_t most = std::min(frame.most, frame.views.size() - first);
  std::size_t count = 0;
  for (; count < most; ++count) {
    const View& view = frame.views[first + count];
    const std::size_t before = vertices_.size();
    if (!take_panorama(frame, view, count == 0)) break;
    if (!add_view(frame, view, count)) {
      vertices_.resize(before);
      break;
    }
  }
  EN_CHECK_LT(0U, count);
  textures_.bring_in();
  const auto rows = static_cast<std::uint32_t>(frame.most * frame.camera.height);
  target.begin(frame.program.layers, frame.camera.width, rows);
  programs_.use(frame.program, sizes_);
  for (const Layer layer : kEachLayer) {
    if (!has(frame.program.layers, layer)) continue;
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(index(layer)));
    glBindTexture(GL_TEXTURE_2D_ARRAY, textures_.texture(layer, sizes_[index(layer)]));
  }
  glActiveTexture(GL_TEXTURE0 + scan::kLayers);  // a unit that no program reads
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices_.size() * sizeof(Vertex)),
               vertices_.data(), GL_STREAM_DRAW);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_.size()));
  glFlush();
  check_gl("drawing");
  return count;
}

// A target's panoramas have faces of one size, as textures do.
bool GlRenderer::take_panorama(const Frame& frame, const View& view, bool first) {
  const scan::FaceSizes& sizes = textures_.sizes(view.scan, view.viewpoint);
  for (const Layer layer : kEachLayer) {
    const std::uint32_t size = sizes[index(layer)];
    if (!has(frame.program.layers, layer)) continue;
    if (size == 0) {
      throw faces_->panoramas().source(view.scan).lacks(layer, view.viewpoint);
    }
    if (first) {
      sizes_[index(layer)] = size;
      textures_.prepare(layer, size);
    } else if (size != sizes_[index(layer)]) {
      return false;
    }
  }
  return true;
}

bool GlRenderer::add_view(const Frame& frame, const View& view, std::size_t place) {
  const Mat3d rotation = detail::panorama_from_camera(view, faces_->panoramas());
  const PixelRays rays = pixel_rays(frame.camera, rotation);
  const scan::FaceMask faces = faces_in_view(frame.camera, rotation);
  std::array<std::optional<Look>, kCubeFaces> looks;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((faces >> k & 1U) == 0) continue;
    const FaceForms forms = face_forms(frame.camera, rays, cube_face(k));
    // Corners are moved by half a mesh each way: with this no pixel falls between two pieces.
    const FacePiece piece = piece_of(frame.camera, forms, 2 * mesh_);
    if (piece.corners().size() < 3) continue;
    looks[k] = Look{forms, {}};
    for (const Layer layer : kEachLayer) {
      if (!has(frame.program.layers, layer)) continue;
      const FaceKey key{view.scan, view.viewpoint, layer, cube_face(k)};
      const std::int32_t slot = textures_.claim(key, sizes_[index(layer)]);
      if (slot < 0) return false;
      looks[k]->slots[index(layer)] = slot;
    }
    add_polygon(frame, *looks[k], piece.corners(), place);
  }
  draw_edges_again(frame, rays, looks, place);
  return true;
}

// Where pieces overlap, the last one drawn may not be the face that a pixel's ray meets, and across
// a clamped edge that shows. These pixels are drawn once more, one by one: a handful a view.
void GlRenderer::draw_edges_again(const Frame& frame, const PixelRays& rays,
                                  const std::array<std::optional<Look>, kCubeFaces>& looks,
                                  std::size_t place) {
  find_pixels_at_edges(frame.camera, rays, 4 * mesh_, edge_pixels_);
  const double i0 = (frame.camera.height - 1) / 2.0, j0 = (frame.camera.width - 1) / 2.0;
  for (const auto [x, y] : edge_pixels_) {
    const auto& look = looks[index(face_towards(rays.at(y + i0, x + j0)))];
    if (!look) continue;
    // Contains the middle of this pixel only.
    const std::array<PicturePoint, 3> triangle{
        {{x - 0.25, y - 0.25}, {x + 0.5, y - 0.25}, {x - 0.25, y + 0.5}}};
    add_polygon(frame, *look, triangle, place);
  }
}

void GlRenderer::add_polygon(const Frame& frame, const Look& look,
                             std::span<const PicturePoint> corners, std::size_t place) {
  const double width = frame.camera.width, height = frame.camera.height;
  const double middle_y = (static_cast<double>(place) + 0.5) * height;
  const double rows = static_cast<double>(frame.most) * height;
  // Rounded to the grid here, corners do not depend on where in the target the view lies: the same
  // view covers the same pixels in any batch.
  const auto on_grid = [this](double pixels) { return std::round(pixels / mesh_) * mesh_; };
  const auto vertex = [&](PicturePoint p) -> Vertex {
    return {
        {static_cast<float>(2 * on_grid(p.x) / width),
         static_cast<float>(2 * (on_grid(p.y) + middle_y) / rows - 1)},
        {static_cast<float>(width / 2), static_cast<float>(middle_y)},
        {to_floats(look.forms.right), to_floats(look.forms.down), to_floats(look.forms.forward)},
        look.slots};
  };
  for (std::size_t k = 2; k < corners.size(); ++k) {
    for (const std::size_t corner : {std::size_t{0}, k - 1, k}) {
      vertices_.push_back(vertex(corners[corner]));
    }
  }
}

void GlRenderer::make_depth_factors(const Camera& camera, DepthMeasure measure) {
  const std::pair now{camera, measure};
  if (depth_factors_of_ == now) return;
  depth_factors_ = cpu::depth_factors(camera, measure);
  depth_factors_of_ = now;
}

// Packs with the CPU back end's own arithmetic. Depth comes back as the texels hold it and is
// scaled here, as a graphics card's square root need not be as exact.
void GlRenderer::finish(const Frame& frame, const Part& part, RenderTarget& target) {
  const auto pixels = target.map();
  const std::size_t view_pixels = std::size_t{frame.camera.width} * frame.camera.height;
  const cpu::PixelPacker packer(cpu::simd_kernels(), frame.outputs, legacy_.eight_bit_depth);
  for (std::size_t k = 0; k < part.count; ++k) {
    const std::size_t first = k * view_pixels;
    packer.pack({values_of<std::uint32_t>(pixels, Layer::kColour, first),
                 values_of<std::uint16_t>(pixels, Layer::kDepth, first),
                 values_of<std::uint16_t>(pixels, Layer::kClass, first),
                 values_of<std::uint32_t>(pixels, Layer::kInstance, first), depth_factors_.data()},
                {part.first + k, 0, view_pixels, view_pixels});
  }
  target.finish_reading();
}

}  // namespace

}  // namespace enfilade::render::gl

namespace enfilade::render::detail {

std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config) {
  return make_gl_renderer(std::move(faces), config, gl::make_context(config.gl_device));
}

std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config,
                                           std::shared_ptr<gl::GlContext> context) {
  return std::make_unique<gl::GlRenderer>(std::move(faces), config, std::move(context));
}

}  // namespace enfilade::render::detail
