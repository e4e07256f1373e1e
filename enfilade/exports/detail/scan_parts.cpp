#include "enfilade/exports/detail/scan_parts.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <system_error>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/rng.h"

namespace enfilade::exports::detail {
namespace {

namespace fs = std::filesystem;

/// Which viewpoints are written, so that parts of other graphs are not taken.
std::string state_of_graphs(const graph::GraphSet& graphs) {
  std::string text;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const graph::NavGraph& graph = graphs.graph(ScanIndex(i));
    std::string ids;
    for (const ViewpointIndex v : included(graph)) ids += graph.id(v) + "\n";
    text += fmt::format("{} {:016x}\n", graph.scan(), stream_of(ids.data(), ids.size()));
  }
  return text;
}

/// The folder of a job's parts, emptied if it holds another job's. A link in its place is removed.
OutputFolder open_parts(const fs::path& file, const std::string& job) {
  const fs::path folder = file.string() + ".parts";
  const fs::path note = folder / "job.txt";
  const bool same = !fs::is_symlink(folder) && file_exists(note) && read_file(note) == job;
  if (!same) {
    std::error_code error;
    fs::remove_all(folder, error);
    if (error) throw FileError(fmt::format("{}: {}", folder.string(), error.message()));
  }
  OutputFolder parts(folder);
  if (!same) parts.write("job.txt", job);
  return parts;
}

}  // namespace

const std::string& checked_file_name(const std::string& name) {
  if (!is_file_name(name) || name.find('"') != std::string::npos) {
    throw ArgumentError(fmt::format("{}: not a name of a file", quote(name)));
  }
  return name;
}

std::vector<ViewpointIndex> included(const graph::NavGraph& graph) {
  std::vector<ViewpointIndex> found;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (graph.included(ViewpointIndex(i))) found.emplace_back(i);
  }
  return found;
}

std::size_t included_count(const graph::GraphSet& graphs) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    count += graphs.graph(ScanIndex(i)).included_count();
  }
  return count;
}

void write_by_scan(const graph::GraphSet& graphs, const fs::path& file, const std::string& job,
                   const ExportOptions& options, const WriteViewpoint& write) {
  const OutputFolder parts = open_parts(file, job + state_of_graphs(graphs));
  const std::size_t total = included_count(graphs);
  std::size_t done = 0;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const graph::NavGraph& graph = graphs.graph(ScanIndex(i));
    const fs::path part = parts.file(graph.scan() + ".hdf5");
    if (file_exists(part)) {
      done += graph.included_count();
      continue;
    }
    features::Hdf5Writer writer(part);
    for (const ViewpointIndex v : included(graph)) {
      write(writer, ScanIndex(i), v, graph.scan() + "_" + graph.id(v));
      if (options.progress) options.progress(++done, total);
    }
    writer.finish();
  }
  features::Hdf5Writer whole(file);
  for (const std::string& scan : graphs.scans()) whole.copy_from(parts.file(scan + ".hdf5"));
  whole.finish();
  std::error_code ignored;  // what is left of the folder does no harm
  fs::remove_all(parts.path(), ignored);
  if (options.progress) options.progress(total, total);
}

std::string state_of(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  const auto time = error ? 0 : fs::last_write_time(file, error).time_since_epoch().count();
  if (error) throw FileError(fmt::format("{}: {}", file.string(), error.message()));
  return fmt::format("{} {} {}", fs::absolute(file).string(), size, time);
}

void pool_depth(std::span<const float> depths, std::size_t pictures, std::size_t cells,
                std::size_t cell, float unit, std::span<float> out) {
  const std::size_t edge = cells * cell;
  EN_CHECK_EQ(depths.size(), pictures * edge * edge);
  EN_CHECK_EQ(out.size(), pictures * cells * cells);
  std::vector<double> sums(out.size());
  std::vector<std::size_t> counts(out.size());
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!(depths[i] > 0)) continue;
    const std::size_t row = i / edge;  // of all pictures, one below the other
    const std::size_t place = row / cell * cells + i % edge / cell;
    sums[place] += std::min(depths[i] / unit, 1.0F);
    ++counts[place];
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = counts[i] == 0 ? 0.0F : static_cast<float>(sums[i] / static_cast<double>(counts[i]));
  }
}

std::vector<features::Hdf5Attribute> view_attributes(const std::string& scan,
                                                     const std::string& viewpoint,
                                                     const Camera& camera) {
  // Without the rounding error of a conversion to radians and back.
  const double vfov = std::round(to_degrees(camera.vertical_field_of_view) * 1e9) / 1e9;
  features::Hdf5Value field = vfov;
  if (vfov == std::floor(vfov)) field = static_cast<std::int64_t>(vfov);
  return {{"scanId", scan},
          {"viewpointId", viewpoint},
          {"image_w", std::int64_t{camera.width}},
          {"image_h", std::int64_t{camera.height}},
          {"vfov", std::move(field)}};
}

}  // namespace enfilade::exports::detail
