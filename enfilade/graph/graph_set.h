/// \file  The graphs of a data set, opened when they are needed and shared by everyone.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::graph {

/// A viewpoint of a scan of a GraphSet.
struct Location {
  ScanIndex scan;
  ViewpointIndex viewpoint;
  friend constexpr bool operator==(Location, Location) = default;
};

/// The scans of one connectivity folder, in the order of its `scans.txt`. Opening reads that list
/// only; a graph is read at its first use, once, by whichever thread comes first. All functions may
/// be called from any thread. Graphs live as long as the set.
class GraphSet {
 public:
  /// \throws FileError, InvalidInput: as scan::load_scan_list
  static std::shared_ptr<const GraphSet> open(const std::filesystem::path& directory);
  /// Those scans of a folder, in this order; it need have no `scans.txt`.
  /// \throws ArgumentError if one is named twice
  static std::shared_ptr<const GraphSet> open(const std::filesystem::path& directory,
                                              std::vector<std::string> scans);
  /// As open(), but a folder that this process has open already is shared, not read again.
  static std::shared_ptr<const GraphSet> open_shared(const std::filesystem::path& directory);
  /// A set of graphs that are in memory. \throws ArgumentError if two have one scan id.
  static std::shared_ptr<const GraphSet> of(std::vector<NavGraph> graphs);

  ~GraphSet();
  GraphSet(const GraphSet&) = delete;
  GraphSet& operator=(const GraphSet&) = delete;

  std::size_t size() const noexcept { return scans_.size(); }
  const std::vector<std::string>& scans() const noexcept { return scans_; }  ///< by ScanIndex
  std::optional<ScanIndex> find(std::string_view scan) const;                ///< O(1)
  /// As find(). \throws LookupError naming the scan and the folder
  ScanIndex at(std::string_view scan) const;

  /// Reads the graph at its first use. \pre scan < size()
  /// \throws FileError, InvalidInput as scan::load_connectivity; a later call tries again
  const NavGraph& graph(ScanIndex scan) const;
  /// \throws LookupError for a scan that is not listed; FileError, InvalidInput as graph(ScanIndex)
  const NavGraph& graph(std::string_view scan) const { return graph(at(scan)); }
  /// Reads all that are not read yet, on `threads` (0: all cores).
  void load_all(int threads = 0) const;

  /// The included viewpoint of these names.
  /// \throws LookupError naming the unknown or excluded one; FileError, InvalidInput
  Location locate(std::string_view scan, std::string_view viewpoint) const;

 private:
  struct Slot;
  GraphSet(std::string origin, std::vector<std::string> scans);

  std::string origin_;  // the folder, or "<memory>", for messages
  std::vector<std::string> scans_;
  std::unique_ptr<Slot[]> slots_;
};

}  // namespace enfilade::graph
