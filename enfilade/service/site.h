/// \file  The data set of a server, in a public part and a secret one.
#pragma once
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/service/goal_keys.h"
#include "enfilade/service/phases.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/split.h"

namespace enfilade::service {

/// The public form of a split: if its goals are secret, each path has only its start, and no goal
/// of any kind.
struct PublicSplit {
  tasks::Annotations annotations;
  bool goals_hidden = false;
};

/// A phase's episodes with their goals, for scoring.
struct SecretEpisodes {
  tasks::Split split;
  std::shared_ptr<const continuous::Buildings> buildings = {};  ///< null on graphs
  GoalKeys keys = {};                                           ///< empty for open goals
};

/// The phase with secret goals that shares the most with other goals.
struct SharedSecret {
  const Phase* phase = nullptr;  ///< null: none shares any
  SharedKeys keys = {};
};

/// Graphs, panoramas and annotations of a data set, and the phases of an evaluation. Immutable:
/// any thread may read it. Secret annotations are in secret_episodes() only, which only scoring
/// uses. A split that gives secret goals away (SharedKeys::tells()) is public without its goals,
/// and so is one of a secret phase's split and paths (find_secret()). Splits of R4R whose texts
/// tell secret ends are left out. So are splits of CVDN whose dialogues begin where secret paths
/// do, as later ones start on the way. Those that are a phase themselves stay.
class Site {
 public:
  /// Opens a data set in a layout of dataset::Dataset: graphs, the splits train, val_seen,
  /// val_unseen and test of each benchmark, and those of the phases. Without phases, each split of
  /// R2R except train whose goals are in the data set is a phase. A phase of REVERIE takes the
  /// boxes of objects from the data set. A continuous one takes the navigation meshes (and, for
  /// open goals, the experts' trajectories).
  /// \throws FileError
  /// \throws InvalidInput for files that can't be used, goals off the floor, and secret goals of
  /// REVERIE whose ids name the objects
  /// \throws InvalidInput for secret goals that check_public_file() refuses
  /// \throws InvalidInput for secret goals in a folder of the data set, links followed, as people
  /// copy data sets to others
  /// \throws InvalidInput for a phase with open goals that gives secret ones away
  /// \throws LookupError for a continuous episode in a building without a graph or a navigation
  /// mesh
  static std::shared_ptr<const Site> open(const std::filesystem::path& data,
                                          std::vector<Phase> phases = {});

  const graph::GraphSet& graphs() const noexcept { return *graphs_; }
  const std::shared_ptr<const graph::GraphSet>& shared_graphs() const noexcept { return graphs_; }
  const scan::PanoramaSet& panoramas() const noexcept { return *panoramas_; }
  const std::vector<PublicSplit>& splits() const noexcept { return splits_; }
  /// Null for an unknown split.
  const PublicSplit* find_split(std::string_view name,
                                tasks::Task task = tasks::Task::kR2r) const noexcept;
  const std::vector<Phase>& phases() const noexcept { return phases_; }
  const Phase* find_phase(std::string_view name) const noexcept;  ///< null for an unknown phase
  /// With goals. Never to be shown. \pre phase is one of phases()
  const SecretEpisodes& secret_episodes(const Phase& phase) const;
  /// Of public goals; the largest share.
  SharedSecret find_shared(const GoalKeys& keys) const;
  /// For the organiser: a sentence for each file of the data set that has secret goals.
  const std::vector<std::string>& notices() const noexcept { return notices_; }
  /// How many rooms of a scan have viewpoints; no value if the data set has no regions.
  std::optional<std::size_t> rooms(ScanIndex scan) const;
  /// Objects by the viewpoints that see them, read at the first call; null if the data set has
  /// none.
  /// \throws InvalidInput, again at each call, without reading the broken file again
  const tasks::ObjectBoxes* objects() const;
  const dataset::Dataset& data() const noexcept { return data_; }
  /// The data set's folder, and those that are searched for its panoramas.
  const std::filesystem::path& folder() const noexcept { return data_.folder(); }
  const std::vector<std::filesystem::path>& image_folders() const noexcept {
    return image_folders_;
  }
  /// Synthetic homes: every page that shows them must say that they are synthetic.
  bool synthetic() const noexcept { return synthetic_; }

 private:
  Site(const std::filesystem::path& data, std::vector<Phase> phases);
  void read_splits();
  void read_split(tasks::Task task, const std::string& name);
  void check_goals_are_elsewhere() const;
  void read_phases();
  void hide_goals();
  bool hide_in(PublicSplit& split, const std::set<std::string, std::less<>>& scans);
  std::string reason_to_leave_out(const tasks::Annotations& annotations,
                                  std::span<const tasks::ReferencePath> paths,
                                  const SharedSecret& shared) const;
  void look_at_continuous();
  void check_open_phases() const;
  void count_rooms();

  dataset::Dataset data_;
  mutable std::mutex objects_mutex_;
  mutable std::exception_ptr broken_objects_;  // the error of objects()
  std::shared_ptr<const graph::GraphSet> graphs_;
  std::shared_ptr<const scan::PanoramaSet> panoramas_;
  std::vector<PublicSplit> splits_;
  std::vector<Phase> phases_;
  std::vector<SecretEpisodes> secret_;  // as phases_
  std::vector<std::size_t> rooms_;      // by ScanIndex; empty if unknown
  std::vector<std::filesystem::path> image_folders_;
  std::vector<std::string> notices_;
  bool synthetic_;
};

}  // namespace enfilade::service
