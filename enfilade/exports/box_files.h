/// \file  Boxes of objects in REVERIE's files, of any building with labels.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/capture/object_boxes.h"
#include "enfilade/exports/options.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::exports {

/// The boxes around the included viewpoints of the graphs; a viewpoint without boxes gets an empty
/// list, as in REVERIE's files.
/// \throws FileError, InvalidInput for graphs that cannot be read
tasks::ObjectBoxes boxes_of_graphs(const tasks::ObjectBoxes& boxes, const graph::GraphSet& graphs);

/// The same, computed from labelled meshes (capture::compute_object_boxes()): SCAN.house, .ply,
/// .fsegs.json and .semseg.json of each scan. They are searched in `folder` itself, and there in
/// SCAN, `SCAN/house_segmentations` and `v1/scans/SCAN/house_segmentations`.
/// \param connectivity  folder of the graphs' files. `options.progress` counts scans
/// \param warnings  as of mesh::read_house_mesh()
/// \throws LookupError for a scan without a .house file, naming the searched folders
/// \throws as mesh::read_house_mesh() and capture::compute_object_boxes()
tasks::ObjectBoxes boxes_of_meshes(const graph::GraphSet& graphs,
                                   const std::filesystem::path& connectivity,
                                   const std::filesystem::path& folder,
                                   const capture::ObjectBoxOptions& boxes = {},
                                   const ExportOptions& options = {},
                                   std::vector<Diagnostic>* warnings = nullptr);

/// Writes REVERIE's folder: `<scan>_<viewpoint>.json` for each viewpoint with boxes. Single files
/// in both forms are made by tasks::ObjectBoxes::to_json().
/// \throws FileError; ArgumentError for a name that cannot be a file's
void write_box_folder(const tasks::ObjectBoxes& boxes, const std::filesystem::path& folder);

}  // namespace enfilade::exports
