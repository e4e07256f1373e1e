#include "enfilade/exports/view_pictures.h"

#include <fmt/format.h>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/exports/detail/file_names.h"
#include "enfilade/image/codecs.h"
#include "enfilade/render/renderer.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using render::kDiscreteViews;

void check_note(const fs::path& folder, const dataset::Dataset& data,
                const ViewPicturesOptions& pictures) {
  std::string note = fmt::format(
      "{} x {} pixels, {:.9g} degrees, quality {}\n", pictures.camera.width, pictures.camera.height,
      to_degrees(pictures.camera.vertical_field_of_view), pictures.quality);
  // Without a folder, graphs and panoramas are named one by one.
  if (!data.folder().empty()) note += fs::absolute(data.folder()).string() + "\n";
  const fs::path file = folder / "enfilade_views.txt";
  if (!file_exists(file)) {
    write_file_atomically(file, note);
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
      : pictures_(pictures), threads_(threads), pixels_(kDiscreteViews * bytes_of_view()) {
    render::RendererConfig config;
    config.threads = threads;
    renderer_ = render::make_renderer(data.faces(), config);
  }

  /// Makes the folder of a viewpoint, which is not there.
  void write(ScanIndex scan, ViewpointIndex viewpoint, const fs::path& folder) {
    render::Outputs outputs;
    outputs.colour.emplace().pixels = std::as_writable_bytes(std::span(pixels_));
    renderer_->render(pictures_.camera, render::discrete_views(scan, viewpoint), outputs);
    const fs::path part = folder.string() + ".part";
    make_folder(part);
    parallel_for(kDiscreteViews, 1, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t view = begin; view < end; ++view) {
        const std::vector<std::uint8_t> jpeg = encode(view);
        write_file_atomically(
            part / fmt::format("{}.jpg", view),
            std::string_view(reinterpret_cast<const char*>(jpeg.data()), jpeg.size()));
      }
    });
    std::error_code error;
    fs::rename(part, folder, error);
    if (error) throw FileError(fmt::format("{}: {}", folder.string(), error.message()));
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

}  // namespace

ViewPicturesReport write_view_pictures(const dataset::Dataset& data, const fs::path& folder,
                                       const ViewPicturesOptions& pictures,
                                       const ExportOptions& options) {
  validate(pictures.camera);
  check_range("quality", pictures.quality, 1, 100);
  make_folder(folder);
  check_note(folder, data, pictures);
  const graph::GraphSet& graphs = *data.graphs();
  std::size_t total = 0;
  for (std::size_t i = 0; i < graphs.size(); ++i)
    total += graphs.graph(ScanIndex(i)).included_count();
  PictureWriter writer(data, pictures, options.threads);
  ViewPicturesReport report;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const graph::NavGraph& graph = graphs.graph(ScanIndex(i));
    make_folder(folder / graph.scan());
    for (std::size_t v = 0; v < graph.size(); ++v) {
      if (!graph.included(ViewpointIndex(v))) continue;
      const fs::path place =
          folder / graph.scan() / detail::checked_file_name(graph.id(ViewpointIndex(v)));
      if (file_exists(place)) {
        ++report.kept;
      } else {
        writer.write(ScanIndex(i), ViewpointIndex(v), place);
      }
      ++report.viewpoints;
      if (options.progress) options.progress(report.viewpoints, total);
    }
  }
  return report;
}

}  // namespace enfilade::exports
