/// \file  One HDF5 file, made in a part for each scan, so that work that was stopped is continued.
#pragma once
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "enfilade/exports/options.h"
#include "enfilade/features/hdf5_writer.h"
#include "enfilade/graph/graph_set.h"

namespace enfilade::exports::detail {

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

/// Name, size and time of a file, for a job. \throws FileError
std::string state_of(const std::filesystem::path& file);

}  // namespace enfilade::exports::detail
