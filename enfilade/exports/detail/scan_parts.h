/// \file  Common parts of the exports: names of files, included viewpoints, means of depth; HDF5
/// files and their attributes. A part per scan lets stopped work go on.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/exports/options.h"
#include "enfilade/features/hdf5_writer.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/graph/graph_set.h"

namespace enfilade::exports::detail {

/// The name itself.
/// \throws ArgumentError if is_file_name() refuses it, or it has a quotation mark
const std::string& checked_file_name(const std::string& name);

/// Writes a viewpoint's data into the part of its scan.
using WriteViewpoint = std::function<void(features::Hdf5Writer& part, ScanIndex scan,
                                          ViewpointIndex viewpoint, const std::string& name)>;

/// Calls `write` for every included viewpoint, in the order of the graphs, in the calling thread;
/// `name` is "<scan>_<viewpoint>". Parts lie in the folder "<file>.parts" until all are done and
/// become `file`. Scans whose part an earlier run of the same `job` has finished are skipped.
/// \param job  a text that differs whenever the file would, for the same viewpoints
/// \param options progress counts viewpoints; those of kept parts, too
/// \throws FileError; the errors of `write`
void write_by_scan(const graph::GraphSet& graphs, const std::filesystem::path& file,
                   const std::string& job, const ExportOptions& options,
                   const WriteViewpoint& write);

/// The included viewpoints of a graph, in its order.
std::vector<ViewpointIndex> included(const graph::NavGraph& graph);
/// How many viewpoints all graphs include.
std::size_t included_count(const graph::GraphSet& graphs);

/// Name, size and time of a file, for a job. \throws FileError
std::string state_of(const std::filesystem::path& file);

/// The mean of the readings in each cell of square pictures, in units of `unit`; a reading beyond
/// one unit counts as one. 0 is no reading, and the value of a cell without any.
/// \param depths (pictures, cells * cell, cells * cell), metres; cell: pixels across
/// \param out (pictures, cells, cells)
void pool_depth(std::span<const float> depths, std::size_t pictures, std::size_t cells,
                std::size_t cell, float unit, std::span<float> out);

/// scanId, viewpointId, image_w, image_h, vfov in degrees: whole numbers as integers.
std::vector<features::Hdf5Attribute> view_attributes(const std::string& scan,
                                                     const std::string& viewpoint,
                                                     const Camera& camera);

}  // namespace enfilade::exports::detail
