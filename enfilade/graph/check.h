/// \file  Checks of a navigation graph.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::graph {

/// Limits beyond which an edge is reported.
struct CheckOptions {
  double longest_edge = 5.0;      ///< metres; the paper's limit between viewpoints
  double shortest_offset = 0.05;  ///< metres apart horizontally; below, headings are unstable
};

/// Reports faults, and changes nothing. Codes: `long-edge`, `steep-edge` (ends nearly above each
/// other), `one-way-edge`, `self-edge`, `edge-to-excluded` (one note per file),
/// `isolated-viewpoint`, `disconnected-part`, `bad-pose` (not a rigid motion), `same-position`,
/// `no-viewpoints`. Each has the JSON path of its cause. Edges are reported once, from their lower
/// index.
std::vector<Diagnostic> check_graph(const scan::Connectivity& connectivity,
                                    const CheckOptions& options = {});

/// A file's diagnostics, also if it could not be read; never throws for a bad file.
struct FileReport {
  std::string scan;
  std::size_t viewpoints = 0;
  std::size_t included = 0;
  std::size_t edges = 0;  ///< undirected, between included viewpoints
  std::vector<Diagnostic> diagnostics;
};

/// Checks each scan of a folder's scans.txt, or, if it has none, each `*_connectivity.json`,
/// packed or not.
/// Files of scans that the list does not name are noted (`unlisted-file`).
/// \throws FileError if there is no such folder; InvalidInput if scans.txt is broken
std::vector<FileReport> check_folder(const std::filesystem::path& directory,
                                     const CheckOptions& options = {});

}  // namespace enfilade::graph
