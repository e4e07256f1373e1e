#include "enfilade/exports/box_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/mesh/segmentation.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using tasks::ObjectBoxes;

/// Adds the boxes around a scan's included viewpoints.
void copy_boxes(const ObjectBoxes& from, const graph::NavGraph& graph, ObjectBoxes& to) {
  for (const ViewpointIndex v : detail::included(graph)) {
    const auto objects = from.at(graph.scan(), graph.id(v));
    to.add(graph.scan(), graph.id(v), {objects.begin(), objects.end()});
  }
}

fs::path find_segmentations(const fs::path& folder, const std::string& scan) {
  const std::array<fs::path, 4> places{folder, folder / scan, folder / scan / "house_segmentations",
                                       folder / "v1" / "scans" / scan / "house_segmentations"};
  std::string tried;
  for (const fs::path& place : places) {
    const fs::path file = place / (scan + ".house");
    if (file_exists(find_text_file(file))) return place;
    tried += "\n  " + file.string();
  }
  throw LookupError(fmt::format("no labelled mesh of scan {}; tried:{}", scan, tried));
}

}  // namespace

ObjectBoxes boxes_of_graphs(const ObjectBoxes& boxes, const graph::GraphSet& graphs) {
  ObjectBoxes chosen;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    copy_boxes(boxes, graphs.graph(ScanIndex(i)), chosen);
  }
  return chosen;
}

ObjectBoxes boxes_of_meshes(const graph::GraphSet& graphs, const fs::path& connectivity,
                            const fs::path& folder, const capture::ObjectBoxOptions& boxes,
                            const ExportOptions& options, std::vector<Diagnostic>* warnings) {
  capture::ObjectBoxOptions told = boxes;
  told.threads = options.threads;
  ObjectBoxes all;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const std::string& scan = graphs.scans()[i];
    const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(
        mesh::read_house_mesh(find_segmentations(folder, scan), scan, warnings)));
    const ObjectBoxes found =
        capture::compute_object_boxes(tracer, scan::load_connectivity(connectivity, scan), told);
    copy_boxes(found, graphs.graph(ScanIndex(i)), all);
    if (options.progress) options.progress(i + 1, graphs.size());
  }
  return all;
}

void write_box_folder(const ObjectBoxes& boxes, const fs::path& folder) {
  const OutputFolder out(folder);
  // One file of this form has a viewpoint a line: "<scan>_<viewpoint>":{"<viewpoint>":{...}}
  const std::string all = boxes.to_json(true);
  for (std::size_t start = 0; start < all.size();) {
    const std::size_t end = std::min(all.find('\n', start), all.size());
    std::string_view line = std::string_view(all).substr(start, end - start);
    start = end + 1;
    if (!line.starts_with('"')) continue;
    if (line.ends_with(',')) line.remove_suffix(1);
    const std::size_t close = line.find("\":");
    const std::string name(line.substr(1, close - 1));
    out.write(detail::checked_file_name(name) + ".json",
              std::string(line.substr(close + 2)) + "\n");
  }
}

}  // namespace enfilade::exports
