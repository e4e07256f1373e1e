/// \file  Shared parts of all forms of experts' trajectories: rollouts, the folder's claim,
/// rendering.
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/exports/expert_walks.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::exports::detail {

/// Means and ranges of a trajectory's pictures before JPEG, of each channel, 0 to 1.
struct PixelStatistics {
  std::array<double, 3> least{}, most{}, mean{}, deviation{};
};

/// One trajectory and its pictures.
struct DrawnWalk {
  const tasks::ContinuousResult& walk;
  const tasks::ContinuousEpisode& episode;
  std::vector<std::string> pictures;  ///< JPEG files, one before each action
  PixelStatistics pixels;
};

/// The trajectories of a form, in the order of the episodes; too long ones are left out.
struct Walked {
  std::vector<tasks::ContinuousResult> walks;
  std::size_t too_long = 0;
};

/// Checks the options, runs the expert, and claims the folder for `form`.
/// \throws as write_streamvln()
Walked walk_as_expert(std::string_view form, const ExpertWalks& walks,
                      const std::filesystem::path& folder, const WalkPictures& pictures);

/// How a form stores a trajectory.
struct WalkStore {
  /// Whether an earlier run has written it. By its index in Walked::walks.
  std::function<bool(std::size_t)> has;
  /// Writes it, whole or not at all. Called from several threads.
  std::function<void(std::size_t, const DrawnWalk&)> write;
};
/// Renders trajectories that the store does not have, in parallel, one building after the other.
WalkReport draw_walks(const Walked& walked, const ExpertWalks& walks, const WalkPictures& pictures,
                      const ExportOptions& options, const WalkStore& store);

/// Writes pictures into `folder`, which appears when all are there.
/// \param name  of the k-th picture
void write_picture_folder(const std::filesystem::path& folder, const DrawnWalk& walk,
                          const std::function<std::string(std::size_t)>& name);

}  // namespace enfilade::exports::detail
