/// \file  Experts' walks as pictures and actions, as StreamVLN and its descendants train on them.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/scene.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/exports/options.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::exports {

/// What the pictures are like, and which walks are taken.
struct StreamVlnOptions {
  /// 640 x 480 pixels, 79 degrees from left to right.
  Camera camera{640, 480, degrees(63.4534)};
  int quality = 90;                ///< of JPEG, 1 to 100
  std::size_t most_actions = 498;  ///< longer walks are left out, as in the released data
  std::string data = "r2r";        ///< in the names of folders
};

/// How much was done.
struct StreamVlnReport {
  std::size_t episodes = 0;  ///< whose pictures are there now
  std::size_t kept = 0;      ///< of them, those that an earlier run had written
  std::size_t too_long = 0;  ///< left out
  std::size_t pictures = 0;
};

/// What a building looks like. Called once a scan, from one thread.
using SceneOfScan = std::function<std::shared_ptr<const continuous::Scene>(const std::string&)>;

/// Has an expert walk along each episode's reference path (0.5 m at points on the way, 0.25 m at
/// the end) and writes, below `folder`, `images/<scan>_<data>_<id, six digits>/rgb/001.jpg`, a
/// picture before each action, and `annotations.json`: `[{"id": 525, "video":
/// "images/<scan>_r2r_000525", "instructions": ["..."], "actions": [-1, 1, 2, ...]}]`, where action
/// -1 is the beginning, 1 forward, 2 left, 3 right, one a picture; the stop at the end is not
/// written, as in the released data. An episode's folder appears when all its pictures are there; a
/// run that was stopped goes on. `enfilade_export.json` says what the pictures are like.
/// `options.progress` counts episodes. \throws ArgumentError for options out of range, or episodes
/// without a reference path; FileError, also if the folder has pictures of other options; as
/// agents::run_continuous()
StreamVlnReport write_streamvln(const tasks::ContinuousEpisodes& episodes,
                                const std::shared_ptr<const continuous::Buildings>& buildings,
                                const continuous::SimulatorConfig& simulator,
                                const SceneOfScan& scene_of, const std::filesystem::path& folder,
                                const StreamVlnOptions& pictures = {},
                                const ExportOptions& options = {});

}  // namespace enfilade::exports
