#include "enfilade/render/cpu/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "enfilade/core/threads.h"
#include "enfilade/render/cpu/footprint.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/gl_devices.h"

namespace enfilade::render::cpu {
namespace {

using detail::PreparedView;
using scan::Layer;

// Rows a task draws: enough work to be worth handing out, small enough to share one picture.
constexpr std::uint32_t kTileRows = 120;

// Above this the first pictures of a batch would have left the second-level cache when the caller
// comes to read them, after pushing out the texels.
constexpr std::size_t kStreamBytes = std::size_t{4} << 20;

std::size_t bytes_of(const Outputs& outputs) {
  return (outputs.colour ? outputs.colour->pixels.size() : 0) +
         (outputs.depth ? outputs.depth->pixels.size() : 0) +
         (outputs.classes ? outputs.classes->pixels.size() : 0) +
         (outputs.instances ? outputs.instances->pixels.size_bytes() : 0);
}

// What all rows of a batch have in common.
struct Job {
  const Kernels& kernels;
  const Camera& camera;
  const Legacy& legacy;
  const Outputs& outputs;
  const float* depth_factor;  // one a pixel, or a block of ones
  Packer packer;
  std::span<const PreparedView> views;
  std::span<const Face> faces;
  bool stream;  // write past the caches
};

class RowDrawer {
 public:
  RowDrawer(const Job& job, std::size_t view, std::uint32_t row, const PlannedRow& planned)
      : job_(job),
        view_(job.views[view]),
        planned_(planned),
        place_{view, std::size_t{row} * job.camera.width, 0,
               std::size_t{job.camera.width} * job.camera.height, job.stream} {}

  void draw() {
    const std::uint32_t width = job_.camera.width;
    for (std::uint32_t begin = 0; begin < width; begin += kBlock) {
      const Piece block{begin, std::min<std::uint32_t>(begin + kBlock, width)};
      place_.count = block.size();
      for (const Stretch& stretch : planned_.plan.stretches()) {
        const Piece piece{std::max(stretch.begin, block.begin), std::min(stretch.end, block.end)};
        if (piece.begin < piece.end) read(index(stretch.face), piece, piece.begin - block.begin);
      }
      pack();
      place_.first += block.size();
    }
  }

 private:
  // The points of a piece, made again only for layers of another size.
  const Points& points_for(const Face& face, std::size_t k, Piece piece) {
    if (size_ != face.size) job_.kernels.points(planned_.lines[k], face.size, piece, points_);
    size_ = face.size;
    return points_;
  }

  // Texels of face `k` for a piece, to place `at` of the block.
  void read(std::size_t k, Piece piece, std::uint32_t at) {
    const Kernels& kernels = job_.kernels;
    const std::size_t count = piece.size();
    size_ = 0;
    const auto face = [&](Layer layer) { return job_.faces[view_.face[index(layer)][k]]; };
    if (job_.outputs.colour) {
      const Face f = face(Layer::kColour);
      kernels.colour(points_for(f, k, piece), f, job_.legacy.clamped_edges, count,
                     &colour_.values[at]);
    }
    if (job_.outputs.depth) {
      const Face f = face(Layer::kDepth);
      kernels.nearest16(points_for(f, k, piece), f, count, &depth_.values[at]);
    }
    if (job_.outputs.classes) {
      const Face f = face(Layer::kClass);
      kernels.nearest16(points_for(f, k, piece), f, count, &classes_.values[at]);
    }
    if (job_.outputs.instances) {
      const Face f = face(Layer::kInstance);
      kernels.nearest32(points_for(f, k, piece), f, count, &instances_.values[at]);
    }
  }

  void pack() const {
    const auto& depth = job_.outputs.depth;
    const bool scaled = depth && depth->measure == DepthMeasure::kZ;
    job_.packer.pack(
        {colour_.values.data(), depth_.values.data(), classes_.values.data(),
         instances_.values.data(), scaled ? job_.depth_factor + place_.first : job_.depth_factor},
        place_);
  }

  const Job& job_;
  const PreparedView& view_;
  const PlannedRow& planned_;
  Place place_;
  std::uint32_t size_ = 0;  // of the face that points_ are on
  Points points_;
  Block32 colour_, instances_;
  Block16 depth_, classes_;
};

void bring_texels(const Job& job, const PreparedView& view, std::span<const PlannedRow> rows) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((view.mask >> k & 1U) == 0) continue;
    std::optional<Footprint> footprint;
    for (const Layer layer : detail::kEachLayer) {
      if (!detail::has(detail::layers_of(job.outputs), layer)) continue;
      const Face& face = job.faces[view.face[index(layer)][k]];
      if (!footprint || footprint->size() != face.size) {
        footprint.emplace(rows, cube_face(k), face.size);
      }
      footprint->bring(face, detail::kTexelBytes[index(layer)]);
    }
  }
}

class CpuRenderer final : public Renderer {
 public:
  CpuRenderer(std::shared_ptr<FaceCache> faces, const RendererConfig& config)
      : config_(config),
        kernels_(config.backend == Backend::kCpu ? simd_kernels() : scalar_kernels()),
        batch_(std::move(faces)),
        ones_(kBlock, 1.0F) {}

  void render(const Camera& camera, std::span<const View> views, const Outputs& outputs) override {
    validate(camera, views, outputs, batch_.cache().panoramas());
    if (outputs.depth && outputs.depth->measure == DepthMeasure::kZ && !(camera == camera_)) {
      inverse_ray_lengths_ = inverse_ray_lengths(camera);
      camera_ = camera;
    }
    for (std::size_t first = 0; first < views.size();) {
      const std::size_t count =
          batch_.fill(camera, views.subspan(first), outputs, batch_.cache().config().bytes);
      draw(camera, detail::slice(camera, outputs, first, count));
      first += count;
    }
    batch_.clear();
  }

  std::string description() const override {
    const int threads = threads_or_all(config_.threads);
    const bool simd = config_.backend == Backend::kCpu;
    return fmt::format("{} ({}, {} thread{})", to_string(config_.backend),
                       simd ? cpu_target() : "no SIMD", threads, threads == 1 ? "" : "s");
  }

 private:
  void draw(const Camera& camera, const Outputs& outputs) {
    const bool rays = outputs.depth && outputs.depth->measure == DepthMeasure::kRay;
    const Job job{kernels_,
                  camera,
                  config_.legacy,
                  outputs,
                  rays ? ones_.data() : inverse_ray_lengths_.data(),
                  Packer(kernels_, outputs, config_.legacy.eight_bit_depth),
                  batch_.views(),
                  batch_.faces(),
                  bytes_of(outputs) > kStreamBytes};
    const std::size_t tiles = (camera.height + kTileRows - 1) / kTileRows;
    parallel_for(batch_.views().size() * tiles, 1, config_.threads,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t k = begin; k < end; ++k) draw_tile(job, k / tiles, k % tiles);
                 });
  }

  static void draw_tile(const Job& job, std::size_t view, std::size_t tile) {
    const auto begin = static_cast<std::uint32_t>(tile) * kTileRows;
    const std::uint32_t count = std::min(kTileRows, job.camera.height - begin);
    std::array<PlannedRow, kTileRows> rows;
    for (std::uint32_t k = 0; k < count; ++k) {
      rows[k].lines = face_lines(job.views[view].rays, begin + k);
      rows[k].plan = RowPlan(job.views[view].rays, begin + k, job.camera.width);
    }
    bring_texels(job, job.views[view], std::span(rows).first(count));
    for (std::uint32_t k = 0; k < count; ++k) RowDrawer(job, view, begin + k, rows[k]).draw();
    if (job.stream) job.kernels.stream_end();
  }

  RendererConfig config_;
  const Kernels& kernels_;
  detail::Batch batch_;
  Camera camera_{0, 0, Radians(0)};  // of inverse_ray_lengths_
  std::vector<float> inverse_ray_lengths_;
  std::vector<float> ones_;
};

}  // namespace

std::unique_ptr<Renderer> make_cpu_renderer(std::shared_ptr<FaceCache> faces,
                                            const RendererConfig& config) {
  return std::make_unique<CpuRenderer>(std::move(faces), config);
}

}  // namespace enfilade::render::cpu
