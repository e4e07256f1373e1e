/// \file  Images of the views of a simulator's agents, in memory that old code reads.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/sim/simulator.h"
#include "python/src/mattersim/types.h"

namespace enfilade::python::mattersim {

struct Settings;
struct Options;

/// Draws each agent's image into the same memory every time. Does not need the GIL.
class Pictures {
 public:
  /// Opens no image yet. \throws ArgumentError for an invalid camera
  Pictures(const std::shared_ptr<const scan::PanoramaSet>& panoramas, const Settings& settings,
           const Options& options);

  /// \throws LookupError, FileError, InvalidInput for missing or broken images
  void draw(const sim::StateSpans& state);
  /// Decodes all images of these viewpoints and keeps them. \throws likewise
  void preload(ScanIndex scan, const std::vector<ViewpointIndex>& viewpoints);

  const Camera& camera() const noexcept { return camera_; }
  Pixels colour_of(std::size_t agent) const;
  Pixels depth_of(std::size_t agent) const;  ///< all 0 unless depth is enabled

 private:
  Camera camera_;
  bool with_depth_;
  std::size_t agents_;
  std::shared_ptr<render::FaceCache> faces_;
  std::unique_ptr<render::Renderer> renderer_;
  std::shared_ptr<std::byte[]> colour_, depth_;
  std::vector<render::View> views_;
};

/// The panoramas below a data set path, shared by all simulators with the same path.
std::shared_ptr<const scan::PanoramaSet> open_panoramas(const std::string& dataset_path,
                                                        const std::string& nav_graph_path,
                                                        const std::vector<std::string>& scans);

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
