#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/threads.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/devices.h"

namespace enfilade::render::cpu {
namespace {

using detail::PreparedView;
using scan::Layer;

// The rows that a task draws at least: enough work to be worth handing out.
constexpr std::uint32_t kLeastRows = 60;

// Whole pictures where there are enough for all threads; else parts, so that all have work.
std::uint32_t tile_rows(std::uint32_t height, std::size_t views, int threads) {
  const auto wanted = 2 * static_cast<std::size_t>(threads_or_all(threads));
  const std::size_t parts = (wanted + views - 1) / views;
  return std::max(kLeastRows, static_cast<std::uint32_t>((height + parts - 1) / parts));
}

// Above this the first pictures of a batch have left the caches, whatever their size, when the
// caller comes to read them. Less is written in the ordinary way: docs/design/kernels.md.
constexpr std::size_t kStreamBytes = std::size_t{64} << 20;

std::size_t bytes_of(const Outputs& outputs) {
  return (outputs.colour ? outputs.colour->pixels.size() : 0) +
         (outputs.depth ? outputs.depth->pixels.size() : 0) +
         (outputs.classes ? outputs.classes->pixels.size() : 0) +
         (outputs.instances ? outputs.instances->pixels.size_bytes() : 0);
}

// What all rows of a batch have in common.
struct Job {
  const PixelKernels& kernels;
  const Camera& camera;
  const Legacy& legacy;
  const Outputs& outputs;
  const float* depth_factor;  // one a pixel, or a block of ones
  PixelPacker packer;
  std::span<const PreparedView> views;
  std::span<const Face> faces;
  bool stream;  // write past the caches
  std::uint32_t tile_rows;
};

// Draws rows of a view, in blocks of columns: where the pixels of a block are on the faces is
// computed while the block before it is drawn, so that its texels are on their way.
class BandDrawer {
 public:
  BandDrawer(const Job& job, std::size_t view)
      : job_(job), view_(job.views[view]), number_(view), plan_(view_.rays), staging_(job.kernels) {
    const Outputs& out = job_.outputs;
    if (out.colour) find_base<image::ColourCells>(Layer::kColour);
    if (out.depth) find_base<image::ValueCells<std::uint16_t>>(Layer::kDepth);
    if (out.classes) find_base<image::ValueCells<std::uint16_t>>(Layer::kClass);
    if (out.instances) find_base<image::ValueCells<std::uint32_t>>(Layer::kInstance);
    for (std::size_t k = 0; k < kCubeFaces && out.colour; ++k) {
      if ((view_.mask >> k & 1U) == 0) continue;
      same_size_ = same_size_ && has_size(face(Layer::kColour, cube_face(k)).size, cube_face(k));
    }
  }

  void draw(std::uint32_t first_row, std::uint32_t rows) {
    const std::uint32_t width = job_.camera.width, end = first_row + rows;
    const std::uint32_t at_once = rows_of_block(width);
    std::size_t next = 0;
    for (std::uint32_t row = first_row; row < end; row += at_once) {
      for (std::uint32_t begin = 0; begin < width; begin += kBlock, ++next) {
        Block& block = blocks_[next % 2];
        prepare(block, row, std::min(at_once, end - row),
                {begin, std::min<std::uint32_t>(begin + kBlock, width)});
        staging_.flush();
        const Ahead ahead{std::span(block.tap_parts).first(base(Layer::kColour) ? block.count : 0),
                          block.taps, keeps_points() ? &points_ : nullptr};
        if (next > 0) {
          finish(blocks_[(next - 1) % 2], ahead);
        } else {
          job_.kernels.taps(ahead);
        }
        if (base(Layer::kColour)) end_at(block.taps, block.pixels());
        find_places(block);
      }
    }
    staging_.flush();
    if (next > 0) finish(blocks_[(next - 1) % 2], {{}, blocks_[next % 2].taps, nullptr});
    staging_.flush();
  }

 private:
  // Of pictures narrower than 128 pixels; more rows would gain little and make Block larger.
  static constexpr std::uint32_t kMostRows = 8;

  // A block's part of a stretch.
  struct Part {
    PixelRange piece;
    std::uint32_t row;
    std::size_t at;  // in the block
    CubeFace face;
  };

  // Whole rows of a narrow picture, or some columns of one row of a wide one.
  struct Block {
    std::uint32_t row = 0, rows = 0;
    PixelRange columns;
    std::array<Part, kMostRows * Stretches::kMost> parts;         // the first `count` are set
    std::array<TapPart, kMostRows * Stretches::kMost> tap_parts;  // of colour; set if it has a base
    std::size_t count = 0;
    TexelTaps taps;
    Places depth, classes, instances;
    std::span<const Part> all() const noexcept { return {parts.data(), count}; }
    std::size_t pixels() const noexcept { return std::size_t{rows} * columns.size(); }
  };

  // A memory's worth of pixels ahead is what hides its latency, however narrow the picture is.
  std::uint32_t rows_of_block(std::uint32_t width) const {
    if (part_by_part_) return 1;
    return std::clamp<std::uint32_t>(static_cast<std::uint32_t>(kBlock) / width, 1, kMostRows);
  }

  const Face& face(Layer layer, CubeFace face) const {
    return job_.faces[view_.face[index(layer)][index(face)]];
  }

  // Offsets have 31 bits: from the lowest of the view's faces, if all are in reach.
  template <class Cells>
  void find_base(Layer layer) {
    const std::uint8_t *lowest = nullptr, *highest = nullptr;
    std::size_t bytes = 0;
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      if ((view_.mask >> k & 1U) == 0) continue;
      const Face& one = face(layer, cube_face(k));
      if (lowest == nullptr || one.cells < lowest) lowest = one.cells;
      if (one.cells > highest) highest = one.cells;
      bytes = std::max(bytes, Cells::bytes(one.size));
    }
    const std::size_t reach = static_cast<std::size_t>(highest - lowest) + bytes;
    if (reach <= std::numeric_limits<std::int32_t>::max()) {
      bases_[index(layer)] = lowest;
    } else {
      part_by_part_ = true;
    }
  }

  // What offsets in the faces of a layer are from; null: each face has its own.
  const std::uint8_t* base(Layer layer) const { return bases_[index(layer)]; }

  // Whether all layers that are drawn with the nearest texel have that size.
  bool has_size(std::uint32_t size, CubeFace k) const {
    const Outputs& out = job_.outputs;
    return (!out.depth || face(Layer::kDepth, k).size == size) &&
           (!out.classes || face(Layer::kClass, k).size == size) &&
           (!out.instances || face(Layer::kInstance, k).size == size);
  }

  bool draws_nearest() const {
    return job_.outputs.depth || job_.outputs.classes || job_.outputs.instances;
  }

  // Whether colour's points are those of the other layers, too.
  bool keeps_points() const { return base(Layer::kColour) && draws_nearest() && same_size_; }

  // Calls each(layer, places of a block) for those that are drawn with the nearest texel.
  template <class Each>
  void nearest_layers(Block& block, const Each& each) {
    const Outputs& outputs = job_.outputs;
    if (outputs.depth) each(Layer::kDepth, block.depth);
    if (outputs.classes) each(Layer::kClass, block.classes);
    if (outputs.instances) each(Layer::kInstance, block.instances);
  }

  ColourFace colour_face(const Face& f, const std::uint8_t* base) const {
    return {base, static_cast<std::int32_t>(f.cells - base), f.size, job_.legacy.clamped_edges};
  }

  NearestFace nearest_face(Layer layer, CubeFace k) const {
    const Face& f = face(layer, k);
    const std::uint8_t* from = base(layer) ? base(layer) : f.cells;
    return {from, static_cast<std::int32_t>(f.cells - from), f.size};
  }

  void prepare(Block& block, std::uint32_t row, std::uint32_t rows, PixelRange columns) {
    block.row = row;
    block.rows = rows;
    block.columns = columns;
    block.count = 0;
    for (std::uint32_t k = 0; k < rows; ++k) {
      Stretches stretches;
      plan_.plan(row + k, job_.camera.width, stretches);
      for (const RowStretch& stretch : stretches.all()) {
        const PixelRange piece{std::max(stretch.begin, columns.begin),
                               std::min(stretch.end, columns.end)};
        if (piece.begin >= piece.end) continue;
        const std::size_t at = std::size_t{k} * columns.size() + piece.begin - columns.begin;
        block.parts[block.count] = {piece, row + k, at, face_of(stretch)};
        if (const std::uint8_t* from = base(Layer::kColour)) {
          const Face& f = face(Layer::kColour, face_of(stretch));
          block.tap_parts[block.count] = {face_line(view_.rays, row + k, face_of(stretch), f.size),
                                          piece, colour_face(f, from), at};
        }
        ++block.count;
      }
    }
  }

  // Kernels read whole registers of taps and places: what follows the last one repeats it.
  template <class Some>
  static void end_at(Some& some, std::size_t end) {
    std::fill_n(some.offset.data() + end, kTapsBeyond, some.offset[end - 1]);
  }

  // Where the nearest texels of a block's pixels are, in all layers that want them.
  void find_places(Block& block) {
    if (!draws_nearest()) return;
    for (const Part& part : block.all()) {
      // Of the faces that points_ are on.
      std::uint32_t size = keeps_points() ? face(Layer::kColour, part.face).size : 0;
      nearest_layers(block, [&](Layer layer, Places& places) {
        const NearestFace f = nearest_face(layer, part.face);
        if (f.size != size) {  // points made for another layer do not fit
          size = f.size;
          job_.kernels.points(face_line(view_.rays, part.row, part.face, size), part.piece, part.at,
                              points_);
        }
        const bool wide = layer == Layer::kInstance;
        (wide ? job_.kernels.places32 : job_.kernels.places16)(points_, part.at, part.piece.size(),
                                                               f, places);
      });
    }
    nearest_layers(block, [&](Layer, Places& places) { end_at(places, block.pixels()); });
  }

  void finish(Block& block, const Ahead& ahead) {
    if (const std::uint8_t* colour = base(Layer::kColour)) {
      job_.packer.draw_colour({colour, block.taps, 0, block.pixels()}, ahead,
                              place_of(block.row, block.columns.begin, block.pixels()));
    } else if (job_.outputs.colour) {
      for (const Part& part : block.all()) draw_colour_alone(block, part);
    }
    if (job_.outputs.depth) draw_depth(block);
    if (job_.outputs.classes) read_values(block, Layer::kClass, block.classes, classes_);
    if (job_.outputs.instances) read_values(block, Layer::kInstance, block.instances, instances_);
    job_.packer.pack_ids(
        {nullptr, nullptr, classes_.values.data(), instances_.values.data(), nullptr},
        place_of(block.row, block.columns.begin, block.pixels()));
  }

  // Row by row, as each has its own lengths of rays; part by part if each face has its own base.
  void draw_depth(const Block& block) {
    const auto draw = [&](const std::uint8_t* from, std::uint32_t row, PixelRange piece,
                          std::size_t at) {
      job_.packer.draw_depth({from, block.depth, at, piece.size()}, depth_factors(row, piece),
                             place_of(row, piece.begin, piece.size()));
    };
    if (const std::uint8_t* from = base(Layer::kDepth)) {
      for (std::uint32_t k = 0; k < block.rows; ++k) {
        draw(from, block.row + k, block.columns, std::size_t{k} * block.columns.size());
      }
      return;
    }
    for (const Part& part : block.all()) {
      draw(face(Layer::kDepth, part.face).cells, part.row, part.piece, part.at);
    }
  }

  const float* depth_factors(std::uint32_t row, PixelRange columns) const {
    const auto& depth = job_.outputs.depth;
    if (!depth || depth->measure == DepthMeasure::kRay) return job_.depth_factor;
    // The lower rows are the upper ones in a mirror: half of the table stays in the caches.
    const std::uint32_t upper = std::min(row, job_.camera.height - 1 - row);
    return job_.depth_factor + std::size_t{upper} * job_.camera.width + columns.begin;
  }

  BlockPlace place_of(std::uint32_t row, std::uint32_t column, std::size_t pixels) {
    const Camera& camera = job_.camera;
    return {number_, std::size_t{row} * camera.width + column, pixels,
            std::size_t{camera.width} * camera.height, job_.stream ? &staging_ : nullptr};
  }

  // For faces that are too far apart in memory.
  void draw_colour_alone(Block& block, const Part& part) {
    const Face& f = face(Layer::kColour, part.face);
    const TapPart taps{face_line(view_.rays, part.row, part.face, f.size), part.piece,
                       colour_face(f, f.cells), part.at};
    job_.kernels.taps({{&taps, 1}, block.taps, nullptr});
    end_at(block.taps, part.at + part.piece.size());
    job_.packer.draw_colour({f.cells, block.taps, part.at, part.piece.size()},
                            {{}, block.taps, nullptr},
                            place_of(part.row, part.piece.begin, part.piece.size()));
  }

  template <class Values>
  void read_values(const Block& block, Layer layer, const Places& places, Values& out) const {
    const auto read = [&](const std::uint8_t* from, std::size_t at, std::size_t count) {
      if constexpr (std::is_same_v<Values, Block32>) {
        job_.kernels.values32({from, places, at, count}, out.values.data() + at);
      } else {
        job_.kernels.values16({from, places, at, count}, out.values.data() + at);
      }
    };
    if (const std::uint8_t* from = base(layer)) return read(from, 0, block.pixels());
    for (const Part& part : block.all()) {
      read(face(layer, part.face).cells, part.at, part.piece.size());
    }
  }

  const Job& job_;
  const PreparedView& view_;
  std::size_t number_;
  ViewPlan plan_;
  std::array<const std::uint8_t*, scan::kLayers> bases_{};
  bool part_by_part_ = false;  // a layer has no base
  bool same_size_ = true;      // as colour: all other layers that are drawn
  std::array<Block, 2> blocks_;
  Points points_;  // of the block that is being prepared
  Staging staging_;
  Block32 instances_;
  Block16 classes_;
};

class CpuRenderer final : public Renderer {
 public:
  CpuRenderer(std::shared_ptr<FaceCache> faces, const RendererConfig& config)
      : config_(config),
        kernels_(config.backend == Backend::kCpu ? simd_kernels(config.cpu_target)
                                                 : scalar_kernels()),
        batch_(std::move(faces)),
        ones_(kBlock, 1.0F) {}

  void render(const Camera& camera, std::span<const View> views, const Outputs& outputs) override {
    validate(camera, views, outputs, batch_.cache().panoramas());
    detail::refuse_stream(outputs);
    if (outputs.depth && outputs.depth->measure == DepthMeasure::kZ && !(camera == camera_)) {
      inverse_ray_lengths_ = depth_factors(camera, DepthMeasure::kZ);
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
    return fmt::format("{} ({}, {} thread{})", enum_name(config_.backend),
                       !simd                        ? "no SIMD"
                       : config_.cpu_target.empty() ? cpu_target()
                                                    : config_.cpu_target,
                       threads, threads == 1 ? "" : "s");
  }

 private:
  void draw(const Camera& camera, const Outputs& outputs) {
    const bool rays = outputs.depth && outputs.depth->measure == DepthMeasure::kRay;
    const Job job{kernels_,
                  camera,
                  config_.legacy,
                  outputs,
                  rays ? ones_.data() : inverse_ray_lengths_.data(),
                  PixelPacker(kernels_, outputs, config_.legacy.eight_bit_depth),
                  batch_.views(),
                  batch_.faces(),
                  bytes_of(outputs) > kStreamBytes,
                  tile_rows(camera.height, batch_.views().size(), config_.threads)};
    const std::size_t tiles = (camera.height + job.tile_rows - 1) / job.tile_rows;
    parallel_for(batch_.views().size() * tiles, 1, config_.threads,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t k = begin; k < end; ++k) draw_tile(job, k / tiles, k % tiles);
                 });
  }

  static void draw_tile(const Job& job, std::size_t view, std::size_t tile) {
    const auto begin = static_cast<std::uint32_t>(tile) * job.tile_rows;
    BandDrawer(job, view).draw(begin, std::min(job.tile_rows, job.camera.height - begin));
    if (job.stream) job.kernels.stream_end();
  }

  RendererConfig config_;
  const PixelKernels& kernels_;
  detail::ViewBatch batch_;
  Camera camera_{0, 0, Radians(0)};  // of inverse_ray_lengths_
  std::vector<float> inverse_ray_lengths_;
  std::vector<float> ones_;
};

}  // namespace

}  // namespace enfilade::render::cpu

namespace enfilade::render::detail {

std::unique_ptr<Renderer> make_cpu_renderer(std::shared_ptr<FaceCache> faces,
                                            const RendererConfig& config) {
  return std::make_unique<cpu::CpuRenderer>(std::move(faces), config);
}

}  // namespace enfilade::render::detail
