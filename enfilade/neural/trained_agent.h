/// \file  A trained agent of any kind, loaded from its model directory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/object_set.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural {

/// How a whole split is walked.
struct SplitRollout {
  std::size_t batch_size = 100;        ///< episodes at once
  std::filesystem::path results = {};  ///< a results file to write; empty: none
  /// File of the agent's attention and choices, episode by episode; empty: none.
  std::filesystem::path attention = {};
  /// Processes that share the batches; all have all trajectories then, and rank 0 writes the files.
  /// Null: this one alone.
  Ranks* ranks = nullptr;
  /// The model's folder, if the files belong into it: no link below it is followed. Empty: a user
  /// names the folder of the files, which may be a link.
  std::filesystem::path model = {};

  /// Writes one of the files. \throws FileError
  void write(const std::filesystem::path& file, std::string_view content) const {
    models::write_file({model.empty() ? file.parent_path() : model}, file, content);
  }
};

/// Chooses the most likely action, without dropout. As an Agent it uses the simulator's
/// room_to_room() configuration, with at most as many actions as in training. One thread at a time.
class TrainedAgent : public agents::Agent {
 public:
  virtual const models::ModelConfig& config() const noexcept = 0;
  virtual std::uint64_t iteration() const noexcept = 0;  ///< of the weights

  /// Objects of viewpoints, for an agent that names one; before enter(). Others ignore it.
  virtual void set_objects(const std::shared_ptr<const features::ObjectSet>& /*objects*/) {}
  /// Sets the episodes and their features; before the functions below. `episodes` have to stay
  /// until the next enter().
  /// \param features null without vision
  /// \throws ArgumentError if it uses vision and there are none, or their size is not the
  /// network's, and likewise for objects; InvalidInput for viewpoints that have none
  virtual void enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) = 0;
  /// Computes the trajectories of all episodes, in their order: those of run_agent(), faster.
  /// \throws FileError for files that cannot be written
  virtual std::vector<tasks::Trajectory> walk(const SplitRollout& options,
                                              const Progress& progress = {}) = 0;
};

/// Loads any model.
/// \throws FileError for a missing file
/// \throws InvalidInput for damaged files, a vocabulary of another size than the network's, or
/// weights that do not fit
/// \throws Error for a device that is not available, ArgumentError for another name
std::unique_ptr<TrainedAgent> load_trained_agent(const std::filesystem::path& folder,
                                                 const std::string& device = "cpu");

}  // namespace enfilade::neural
