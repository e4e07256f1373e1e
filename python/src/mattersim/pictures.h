/// \file  Images of the views of a simulator's agents, in memory that old code reads.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/sim/state.h"
#include "python/src/mattersim/settings.h"
#include "python/src/mattersim/types.h"

namespace enfilade::python::mattersim {

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

}  // namespace enfilade::python::mattersim
