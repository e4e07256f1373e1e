/// \file  Experts' trajectories as pictures and actions, in the files that train video models.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/exports/options.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/image/image.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::exports {

/// Appearance of a building.
struct BuildingLook {
  std::shared_ptr<const continuous::Scene> scene;
  /// Panoramas of that scene, which give pixels their colours where they see them; null: the mesh's
  /// own.
  std::shared_ptr<const continuous::Photographs> photographs = nullptr;
};
/// Called once a scan, from one thread.
using LookOfScan = std::function<BuildingLook(const std::string&)>;

/// Input of the expert. It follows each episode's reference path, within 0.5 m of points on the way
/// and 0.25 m of the end, as VLN-CE's experts do.
struct ExpertWalks {
  const tasks::ContinuousEpisodes& episodes;
  std::shared_ptr<const continuous::Buildings> buildings;
  continuous::SimulatorConfig simulator;
  LookOfScan look_of;
};

/// Size of the pictures, and selection of trajectories.
struct WalkPictures {
  /// 640 x 480 pixels, 79 degrees from left to right, as StreamVLN and NaVid have.
  Camera camera{640, 480, degrees(63.4534)};
  int quality = 90;                ///< of JPEG, 1 to 100
  std::size_t most_actions = 498;  ///< longer trajectories are left out, as in StreamVLN's data
  std::string data = "r2r";        ///< "r2r" or "rxr": in names of folders
  /// Source of colours; look_of() has photographs for kPanoramas.
  continuous::Appearance appearance = continuous::Appearance::kMesh;
};

/// Views at some poses of a trajectory: a picture of three channels each.
/// \param poses  indices into walk.positions
/// \param eyes  of the trajectory's building only
/// \param eye_height  metres above the floor
/// \pre the trajectory has headings; every pose is one of it
/// \throws as continuous::Eyes::render()
std::vector<image::Image8> draw_poses(const tasks::ContinuousResult& walk,
                                      std::span<const std::size_t> poses, continuous::Eyes& eyes,
                                      const Camera& camera, double eye_height);

/// How much was done.
struct WalkReport {
  std::size_t episodes = 0;  ///< with all pictures
  std::size_t kept = 0;      ///< of them, those that an earlier run had written
  std::size_t too_long = 0;  ///< left out
  std::size_t pictures = 0;
};

// All have a picture before each action, the stop included. A trajectory's files appear when all
// its pictures are rendered; a stopped run is continued. `enfilade_export.json` has the pictures'
// options. `options.progress` counts trajectories. All throw ArgumentError for options out of
// range, and episodes without a reference path. They throw FileError, also if the folder has
// pictures of other options. They throw the errors of agents::run_continuous().

/// StreamVLN's form, below `folder`: `images/<scan>_<data>_<id, six digits>/rgb/001.jpg`, and
/// `annotations.json`: `[{"id": 525, "video": "images/<scan>_r2r_000525", "instructions": ["..."],
/// "actions": [-1, 1, 2, ...]}]`. Action -1 is the beginning, 1 forward, 2 left, 3 right, one per
/// picture. The stop at the end is not written, as in the released data.
WalkReport write_streamvln(const ExpertWalks& walks, const std::filesystem::path& folder,
                           const WalkPictures& pictures = {}, const ExportOptions& options = {});

/// NaVILA's form, below `folder`: `R2R/train/<id>/frame_0.jpg` and `R2R/annotations.json` (RxR, and
/// the split's name, likewise). It has one entry per decision, `{"video_id": "<id>-<decision>",
/// "q": instruction, "a": "The next action is move forward 75 cm.", "frames": ["<id>/frame_0.jpg",
/// ...]}`, with all pictures so far. Up to three equal actions are one decision: 25 to 75 cm, or
/// one to three turns. Each decision is there once; the released file repeats turns, short steps
/// and stops to balance them.
WalkReport write_navila(const ExpertWalks& walks, const std::filesystem::path& folder,
                        const WalkPictures& pictures = {}, const ExportOptions& options = {});

/// Pictures and numbers of a data set of LeRobot, in `folder`/enfilade_export.parts. The Python
/// function enfilade.exports.write_lerobot() makes the tables of them, of either version.
/// - `000000/frame_000000.jpg`: one picture per action
/// - `000000.rows.json`: `{"actions": [...], "states": [[x, y, z, heading], ...], "pixels": {"min":
///   [r, g, b], "q01", "q10", "q50", "q90", "q99", "max", "mean", "std"}}`. States are metres of
///   the floor and radians, world frame. Pixels are those before JPEG, 0 to 1; "q01" is the least
///   value that 1 % of them do not exceed.
/// - `episodes.json`: `{"split", "width", "height", "chunk", "episodes": [{"instruction",
///   "length"}, ...]}`. `chunk` is the number of tables per folder of version 2.1.
///
/// Trajectories that have a table are not rendered again. Python's `tables.json` names the tables,
/// `000000.json` has a trajectory's statistics. \throws InvalidInput for another `tables.json`
WalkReport write_lerobot_parts(const ExpertWalks& walks, const std::filesystem::path& folder,
                               const WalkPictures& pictures = {},
                               const ExportOptions& options = {});

}  // namespace enfilade::exports
