/// \file  Episodes in which an agent chooses among neighbours, and what its network sees of them.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/agents/panorama.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/neural/core/resident_views.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "enfilade/sim/candidates.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::panoramic {

/// Where an episode begins and ends.
struct EpisodeStart {
  graph::Location location;
  Radians heading;                     ///< rounded to the nearest of the 12
  std::optional<ViewpointIndex> goal;  ///< no value: hidden
};

/// One episode. A choice is a candidate's number, or their count: stop. A move turns up or down to
/// the candidate's row, then right to its view, then goes there, and keeps that view. Each is an
/// entry of the trajectory, as in EnvDrop.
class PanoramicEpisode {
 public:
  /// \param graphs those of `panoramas`; both outlive it
  /// \throws ActionError for an unknown viewpoint
  PanoramicEpisode(agents::PanoramaCache& panoramas, const graph::GraphSet& graphs,
                   const EpisodeStart& start);

  graph::Location location() const noexcept { return location_; }
  std::uint32_t view() const noexcept { return view_; }  ///< 0..35
  Radians heading() const noexcept;                      ///< of the view
  Radians elevation() const noexcept;                    ///< of the view
  bool ended() const noexcept { return ended_; }         ///< stop was chosen
  const std::vector<sim::Candidate>& candidates() const noexcept { return *candidates_; }
  std::size_t stop() const noexcept { return candidates_->size(); }  ///< the choice that ends it
  /// The choice that leads along the shortest path to the goal; stop() there. \pre the goal is
  /// known
  std::size_t teacher() const;
  double distance() const;  ///< metres to the goal along edges. \pre the goal is known
  bool has_goal() const noexcept { return goal_.has_value(); }
  const std::vector<tasks::TrajectoryPoint>& trajectory() const noexcept { return points_; }

  /// \pre not ended, choice <= stop()
  void choose(std::size_t choice);

 private:
  void add_point();
  void arrive();

  agents::PanoramaCache* panoramas_;
  const graph::GraphSet* graphs_;
  graph::Location location_;
  std::uint32_t view_ = 0;
  std::optional<ViewpointIndex> goal_;
  bool ended_ = false;
  const std::vector<sim::Candidate>* candidates_ = nullptr;
  std::vector<tasks::TrajectoryPoint> points_;
};

/// Writes the picture's numbers of a view, 0..35, of a viewpoint.
using ImageSource =
    std::function<void(graph::Location location, std::uint32_t view, std::span<float> out)>;

/// The features of views; nothing is written for missing ones.
/// \param features null: there are none; else they outlive the result
ImageSource pictures_of(const core::ViewFeatures* features);

/// What the network sees of a batch of walks: pictures and directions of the 36 views and of the
/// candidates. Headings are relative to the agent's view, elevations absolute. Of ended walks
/// nothing is to be used.
StepInput look(std::span<const PanoramicEpisode> walks, const PanoramicConfig& config,
               const ImageSource& images);
/// The same, made where the pictures are: on their device, of numbers that are sent there.
StepInput look(std::span<const PanoramicEpisode> walks, const PanoramicConfig& config,
               core::ResidentViews& images);

}  // namespace enfilade::neural::panoramic
