/// \file  Graphs that all simulators of the process share, with their names as Python objects.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "python/src/mattersim/types.h"

namespace enfilade::python::mattersim {

/// Graphs stay open for the rest of the process, as in the old simulator: a hundred simulators read
/// a scan once. A scans.txt that has changed is read again.
class SharedGraphs {
 public:
  /// The folder's scans, by its scans.txt (v0.2). Reads only that list. \throws FileError,
  /// InvalidInput
  static std::shared_ptr<SharedGraphs> of_folder(const std::string& folder);
  /// One scan of a folder that needs no scans.txt (v0.1). Reads its graph. \throws likewise
  static std::shared_ptr<SharedGraphs> of_scan(const std::string& folder, const std::string& scan);

  explicit SharedGraphs(std::shared_ptr<const graph::GraphSet> set);

  const std::shared_ptr<const graph::GraphSet>& set() const noexcept { return set_; }
  /// By ViewpointIndex. \pre the graph has been read; the GIL is held
  const std::vector<ViewpointNames>& names(ScanIndex scan);
  const nb::object& scan_name(ScanIndex scan) const { return scan_names_[scan.at()]; }

 private:
  std::shared_ptr<const graph::GraphSet> set_;
  std::vector<nb::object> scan_names_;
  std::vector<std::vector<ViewpointNames>> names_;  // empty until first use
};

}  // namespace enfilade::python::mattersim
