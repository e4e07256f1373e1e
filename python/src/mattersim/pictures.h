/// \file  What the agents of a simulator see, drawn into memory that old code looks into.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/sim/state.h"
#include "python/src/mattersim/settings.h"
#include "python/src/mattersim/types.h"

namespace enfilade::python::mattersim {

/// Draws each agent's picture into the same memory every time. Needs no GIL.
class Pictures {
 public:
  /// Opens no picture yet. \throws ArgumentError for a camera that cannot be
  Pictures(std::shared_ptr<const scan::PanoramaSet> panoramas, const Settings& settings,
           const Options& options);

  /// \throws LookupError, FileError, InvalidInput for missing or broken pictures
  void draw(const sim::StateSpans& state);
  /// Decodes all pictures of these viewpoints; they stay. \throws likewise
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

/// The panoramas below a data set path, shared by all simulators that name the same ones.
std::shared_ptr<const scan::PanoramaSet> open_panoramas(const std::string& dataset_path,
                                                        const std::string& nav_graph_path,
                                                        const std::vector<std::string>& scans);

}  // namespace enfilade::python::mattersim
