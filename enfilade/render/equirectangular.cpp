// All directions of a panorama in one picture: one pixel after another, on all cores.

#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render {
namespace {

using scan::Layer;

// A pixel as a row of one column.
struct Pixel {
  CubeFace face;
  PixelRays rays;
  cpu::TexelPoint on(const Face& f) const {
    return cpu::texel_point(cpu::face_line(rays, 0, face, f.size), 0);
  }
};

Pixel pixel_towards(Vec3d direction) {
  const CubeFace face = face_towards(direction);
  return {face, {direction, {}, {}}};
}

class Drawer {
 public:
  Drawer(const detail::ViewBatch& batch, const View& view, const Mat3d& panorama_from_world,
         std::uint32_t width, std::uint32_t height, const Outputs& outputs)
      : faces_(batch.faces()),
        view_(batch.views().front()),
        heading_(view.heading),
        panorama_from_world_(panorama_from_world),
        width_(width),
        height_(height),
        outputs_(outputs),
        packer_(cpu::simd_kernels(), outputs, false) {
    ones_.fill(1.0F);
  }

  void draw_row(std::uint32_t row) const {
    for (std::uint32_t begin = 0; begin < width_; begin += cpu::kBlock) {
      const std::uint32_t end = std::min<std::uint32_t>(begin + cpu::kBlock, width_);
      std::array<Pixel, cpu::kBlock> pixels;
      for (std::uint32_t j = begin; j < end; ++j) pixels[j - begin] = at(row, j);
      const std::span<const Pixel> block(pixels.data(), end - begin);
      draw_block(block, {0, std::size_t{row} * width_ + begin, block.size(),
                         std::size_t{width_} * height_});
    }
  }

 private:
  Pixel at(std::uint32_t row, std::uint32_t column) const {
    const double heading = heading_.value + ((column + 0.5) / width_ - 0.5) * 2 * kPi;
    const double elevation = (0.5 - (row + 0.5) / height_) * kPi;
    const double level = std::cos(elevation);
    return pixel_towards(panorama_from_world_ * Vec3d{level * std::sin(heading),
                                                      level * std::cos(heading),
                                                      std::sin(elevation)});
  }

  const Face& face(Layer layer, CubeFace face) const {
    return faces_[view_.face[index(layer)][index(face)]];
  }

  template <class T>
  void read(Layer layer, std::span<const Pixel> pixels, T* out) const {
    for (const Pixel& p : pixels) {
      const Face& f = face(layer, p.face);
      *out++ = cpu::sample_nearest<T>(f, p.on(f));
    }
  }

  void draw_block(std::span<const Pixel> pixels, const cpu::BlockPlace& place) const {
    std::array<std::uint32_t, cpu::kBlock> rgba, instances;
    std::array<std::uint16_t, cpu::kBlock> depth, classes;
    if (outputs_.colour) {
      std::uint32_t* out = rgba.data();
      for (const Pixel& p : pixels) {
        const Face& f = face(Layer::kColour, p.face);
        *out++ = cpu::sample_colour(f.cells, cpu::tap_at(f.size, false, p.on(f)));
      }
    }
    if (outputs_.depth) read(Layer::kDepth, pixels, depth.data());
    if (outputs_.classes) read(Layer::kClass, pixels, classes.data());
    if (outputs_.instances) read(Layer::kInstance, pixels, instances.data());
    packer_.pack({rgba.data(), depth.data(), classes.data(), instances.data(), ones_.data()},
                 place);
  }

  std::span<const Face> faces_;
  const detail::PreparedView& view_;
  Radians heading_;
  Mat3d panorama_from_world_;
  std::uint32_t width_, height_;
  const Outputs& outputs_;
  cpu::PixelPacker packer_;
  std::array<float, cpu::kBlock> ones_{};
};

}  // namespace

void render_equirectangular(const std::shared_ptr<FaceCache>& faces, const View& view,
                            std::uint32_t width, std::uint32_t height, const Outputs& outputs,
                            int threads) {
  if (!faces) throw ArgumentError("faces: null, but panoramas come from a FaceCache");
  const Camera size{width, height, degrees(90)};
  validate(size, {&view, 1}, outputs, faces->panoramas());
  detail::refuse_stream(outputs);
  detail::ViewBatch batch(faces);
  batch.fill_whole(view, outputs);
  const auto& poses = faces->panoramas().source(view.scan).poses();
  const Drawer drawer(batch, view, transpose(poses[view.viewpoint.at()].world_from_panorama), width,
                      height, outputs);
  parallel_for(height, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      drawer.draw_row(static_cast<std::uint32_t>(row));
    }
  });
}

}  // namespace enfilade::render
