#include "enfilade/exports/depth_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/exports/detail/numbers.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/render/renderer.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using features::Hdf5Array;
using features::Hdf5Type;

constexpr std::size_t kLevelBegin = 12, kLevelCount = 12;  // of the 36 views, those at the horizon
constexpr std::uint32_t kCells = 14, kCellPixels = 16;     // of BEVBert, across

/// Which views are drawn, and with which camera.
struct Shooting {
  Camera camera;
  std::size_t begin = 0, count = render::kDiscreteViews;
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
  render::RendererConfig config;
  config.threads = options.threads;
  const auto renderer = render::make_renderer(data.faces(), config);
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
