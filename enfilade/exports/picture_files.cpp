#include "enfilade/exports/picture_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/image/codecs.h"
#include "enfilade/render/renderer.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using features::Hdf5Array;
using features::Hdf5Type;
using render::kDiscreteViews;

std::unique_ptr<render::Renderer> make_renderer(const dataset::Dataset& data, int threads) {
  render::RendererConfig config;
  config.threads = threads;
  return render::make_renderer(data.faces(), config);
}

// --- pictures ---

void check_note(const OutputFolder& folder, const dataset::Dataset& data,
                const ViewPicturesOptions& pictures) {
  std::string note = fmt::format(
      "{} x {} pixels, {:.9g} degrees, quality {}\n", pictures.camera.width, pictures.camera.height,
      to_degrees(pictures.camera.vertical_field_of_view), pictures.quality);
  // Without a folder, graphs and panoramas are named one by one.
  if (!data.folder().empty()) note += fs::absolute(data.folder()).string() + "\n";
  const fs::path file = folder.path() / "enfilade_views.txt";
  if (!file_exists(file)) {
    folder.write("enfilade_views.txt", note);
  } else if (const std::string other = read_file(file); other != note) {
    throw FileError(fmt::format(
        "{}: the folder has other pictures, of {:?}, not {:?}; remove it or name another folder",
        file.string(), other, note));
  }
}

/// Draws and writes one viewpoint after the other.
class PictureWriter {
 public:
  PictureWriter(const dataset::Dataset& data, const ViewPicturesOptions& pictures, int threads)
      : pictures_(pictures),
        threads_(threads),
        pixels_(kDiscreteViews * bytes_of_view()),
        renderer_(make_renderer(data, threads)) {}

  /// Makes the folder of a viewpoint, which is not there.
  void write(ScanIndex scan, ViewpointIndex viewpoint, const OutputFolder& out,
             const std::string& folder) {
    render::Outputs outputs;
    outputs.colour.emplace().pixels = std::as_writable_bytes(std::span(pixels_));
    renderer_->render(pictures_.camera, render::discrete_views(scan, viewpoint), outputs);
    const std::string part = folder + ".part";
    out.remove_all(part);  // of a killed run
    parallel_for(kDiscreteViews, 1, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t view = begin; view < end; ++view) {
        const std::vector<std::uint8_t> jpeg = encode(view);
        out.write(fmt::format("{}/{}.jpg", part, view),
                  std::string_view(reinterpret_cast<const char*>(jpeg.data()), jpeg.size()));
      }
    });
    out.rename(part, folder);
  }

 private:
  std::size_t bytes_of_view() const {
    return std::size_t{3} * pictures_.camera.width * pictures_.camera.height;
  }

  std::vector<std::uint8_t> encode(std::size_t view) const {
    image::Image8 picture(pictures_.camera.width, pictures_.camera.height, 3);
    const std::span<const std::uint8_t> from =
        std::span(pixels_).subspan(view * bytes_of_view(), bytes_of_view());
    picture.pixels.assign(from.begin(), from.end());
    return image::encode_jpeg(picture, pictures_.quality,
                              pictures_.quality >= image::kFullChromaQuality);
  }

  ViewPicturesOptions pictures_;
  int threads_;
  std::vector<std::uint8_t> pixels_;
  std::unique_ptr<render::Renderer> renderer_;
};

// --- depth and classes ---

constexpr std::size_t kLevelBegin = 12, kLevelCount = 12;  // of the 36 views, those at the horizon
constexpr std::uint32_t kCells = 14, kCellPixels = 16;     // of BEVBert, across

/// Which views are drawn, and with which camera.
struct Shooting {
  Camera camera;
  std::size_t begin = 0, count = kDiscreteViews;
};

/// What depends on the pictures: other pictures make another file.
std::string job_of(const char* what, const dataset::Dataset& data) {
  std::string job = fmt::format("{}\n", what);
  for (std::size_t i = 0; i < data.graphs()->size(); ++i) {
    const scan::PanoramaSource& source = data.panoramas()->source(ScanIndex(i));
    std::string state = source.state();
    if (state.empty()) {  // it cannot be told whether pictures are the same: none is kept
      state = fmt::format("at {}", std::chrono::steady_clock::now().time_since_epoch().count());
    }
    job += fmt::format("{} {}\n", source.origin(), state);
  }
  return job;
}

/// Draws the views of each viewpoint into `outputs`, and writes what `array` then says.
template <class MakeArray>
void draw_by_scan(const dataset::Dataset& data, const fs::path& file, const char* what,
                  const Shooting& shooting, const ExportOptions& options,
                  const render::Outputs& outputs, const MakeArray& array) {
  const auto renderer = make_renderer(data, options.threads);
  const graph::GraphSet& graphs = *data.graphs();
  detail::write_by_scan(
      graphs, file, job_of(what, data), options,
      [&](features::Hdf5Writer& part, ScanIndex scan, ViewpointIndex v, const std::string& name) {
        const auto views = render::discrete_views(scan, v);
        renderer->render(shooting.camera, std::span(views).subspan(shooting.begin, shooting.count),
                         outputs);
        const graph::NavGraph& graph = graphs.graph(scan);
        part.write(
            {name, array(), detail::view_attributes(graph.scan(), graph.id(v), shooting.camera)});
      });
}

}  // namespace

ViewPicturesReport write_view_pictures(const dataset::Dataset& data, const fs::path& folder,
                                       const ViewPicturesOptions& pictures,
                                       const ExportOptions& options) {
  validate(pictures.camera);
  check_range("quality", pictures.quality, 1, 100);
  const OutputFolder out(folder);
  check_note(out, data, pictures);
  const graph::GraphSet& graphs = *data.graphs();
  const std::size_t total = detail::included_count(graphs);
  PictureWriter writer(data, pictures, options.threads);
  ViewPicturesReport report;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const graph::NavGraph& graph = graphs.graph(ScanIndex(i));
    for (const ViewpointIndex v : detail::included(graph)) {
      const std::string place = graph.scan() + "/" + detail::checked_file_name(graph.id(v));
      if (file_exists(folder / place)) {
        ++report.kept;
      } else {
        writer.write(ScanIndex(i), v, out, place);
      }
      ++report.viewpoints;
      if (options.progress) options.progress(report.viewpoints, total);
    }
  }
  return report;
}

void write_gridmm_depth(const dataset::Dataset& data, const fs::path& file,
                        const ExportOptions& options) {
  constexpr std::uint32_t kEdge = 128;
  const Shooting shooting{{kEdge, kEdge, degrees(60)}};
  std::vector<std::uint16_t> depths(std::size_t{shooting.count} * kEdge * kEdge);
  render::Outputs outputs;
  outputs.depth = {render::DepthFormat::kQuarterMillimetresUint16, render::DepthMeasure::kZ,
                   std::as_writable_bytes(std::span(depths))};
  draw_by_scan(data, file, "gridmm depth", shooting, options, outputs, [&] {
    return Hdf5Array{
        Hdf5Type::kUint16, {shooting.count, kEdge, kEdge}, std::as_bytes(std::span(depths))};
  });
}

void write_bevbert_depth(const dataset::Dataset& data, const fs::path& file,
                         const ExportOptions& options) {
  constexpr std::uint32_t kEdge = kCells * kCellPixels;
  const Shooting shooting{{kEdge, kEdge, degrees(90)}, kLevelBegin, kLevelCount};
  std::vector<float> depths(shooting.count * kEdge * kEdge);
  std::vector<float> cells(shooting.count * kCells * kCells);
  render::Outputs outputs;
  outputs.depth = {render::DepthFormat::kMetresFloat32, render::DepthMeasure::kZ,
                   std::as_writable_bytes(std::span(depths))};
  draw_by_scan(data, file, "bevbert depth", shooting, options, outputs, [&] {
    detail::pool_depth(depths, shooting.count, kCells, kCellPixels, kBevbertMetres, cells);
    return Hdf5Array{
        Hdf5Type::kFloat32, {shooting.count, kCells, kCells}, std::as_bytes(std::span(cells))};
  });
}

void write_bevbert_classes(const dataset::Dataset& data, const fs::path& file,
                           const ExportOptions& options) {
  const Shooting shooting{{kCells, kCells, degrees(90)}, kLevelBegin, kLevelCount};
  std::vector<std::uint8_t> classes(shooting.count * kCells * kCells);
  render::Outputs outputs;
  outputs.classes = {render::ClassFormat::kUint8, std::as_writable_bytes(std::span(classes))};
  draw_by_scan(data, file, "bevbert classes", shooting, options, outputs, [&] {
    // Void and what is above misc count as misc, 40, and numbers are kept modulo 40.
    for (std::uint8_t& one : classes) one = one < 40 ? one : std::uint8_t{0};
    return Hdf5Array{
        Hdf5Type::kUint8, {shooting.count, kCells, kCells}, std::as_bytes(std::span(classes))};
  });
}

}  // namespace enfilade::exports
