#include "enfilade/exports/detail/scan_parts.h"

#include <fmt/format.h>
#include <system_error>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
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
    for (std::size_t v = 0; v < graph.size(); ++v) {
      if (graph.included(ViewpointIndex(v))) ids += graph.id(ViewpointIndex(v)) + "\n";
    }
    text += fmt::format("{} {:016x}\n", graph.scan(), stream_of(ids.data(), ids.size()));
  }
  return text;
}

/// The folder of a job's parts, emptied if it holds another job's.
fs::path open_parts(const fs::path& file, const std::string& job) {
  const fs::path folder = file.string() + ".parts";
  const fs::path note = folder / "job.txt";
  if (!file_exists(note) || read_file(note) != job) {
    std::error_code error;
    fs::remove_all(folder, error);
    if (error) throw FileError(fmt::format("{}: {}", folder.string(), error.message()));
    make_folder(folder);
    write_file_atomically(note, job);
  }
  return folder;
}

}  // namespace

void write_by_scan(const graph::GraphSet& graphs, const fs::path& file, const std::string& job,
                   const ExportOptions& options, const WriteViewpoint& write) {
  const fs::path parts = open_parts(file, job + state_of_graphs(graphs));
  std::size_t total = 0;
  std::size_t done = 0;
  for (std::size_t i = 0; i < graphs.size(); ++i)
    total += graphs.graph(ScanIndex(i)).included_count();
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const graph::NavGraph& graph = graphs.graph(ScanIndex(i));
    const fs::path part = parts / (graph.scan() + ".hdf5");
    if (file_exists(part)) {
      done += graph.included_count();
      continue;
    }
    features::Hdf5Writer writer(part);
    for (std::size_t v = 0; v < graph.size(); ++v) {
      if (!graph.included(ViewpointIndex(v))) continue;
      write(writer, ScanIndex(i), ViewpointIndex(v),
            graph.scan() + "_" + graph.id(ViewpointIndex(v)));
      if (options.progress) options.progress(++done, total);
    }
    writer.finish();
  }
  features::Hdf5Writer whole(file);
  for (const std::string& scan : graphs.scans()) whole.copy_from(parts / (scan + ".hdf5"));
  whole.finish();
  std::error_code ignored;  // what is left of the folder does no harm
  fs::remove_all(parts, ignored);
  if (options.progress) options.progress(total, total);
}

std::string state_of(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) throw FileError(fmt::format("{}: {}", file.string(), error.message()));
  const auto time = fs::last_write_time(file).time_since_epoch().count();
  return fmt::format("{} {} {}", fs::absolute(file).string(), size, time);
}

}  // namespace enfilade::exports::detail
