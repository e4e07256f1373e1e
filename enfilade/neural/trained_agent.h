/// \file  A trained agent of any kind, loaded from its model directory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
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
  /// What the agent attended to and how it chose, episode by episode, to write; empty: none.
  std::filesystem::path attention = {};
  /// Processes that walk batches in turn; all have all trajectories then, and rank 0 writes the
  /// files. Null: this one alone.
  Ranks* ranks = nullptr;
};

/// Chooses what is most likely, without dropout. As an Agent it walks in the simulator's
/// room_to_room() configuration, up to the actions it was trained with. One thread at a time.
class TrainedAgent : public agents::Agent {
 public:
  virtual const models::ModelConfig& config() const noexcept = 0;
  virtual std::uint64_t iteration() const noexcept = 0;  ///< of the weights

  /// What viewpoints show of objects, for an agent that names one; before enter(). Others leave it.
  virtual void set_objects(const std::shared_ptr<const features::ObjectSet>& /*objects*/) {}
  /// The episodes to walk in, and what is seen there; before all that follows. `episodes` have to
  /// stay until the next enter(). \param features null if the agent does not see
  /// \throws ArgumentError if it sees and there are none, or their size is not the network's, and
  /// likewise for objects; InvalidInput for viewpoints that have none
  virtual void enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) = 0;
  /// Walks all episodes, in their order: the trajectories of run_agent(), faster.
  /// \throws FileError for files that cannot be written
  virtual std::vector<tasks::Trajectory> walk(const SplitRollout& options,
                                              const Progress& progress = {}) = 0;
};

/// Loads any model. \throws FileError for a missing file; InvalidInput for damaged files, a
/// vocabulary of another size than the network's, or weights that do not fit; Error for a device
/// that is not available, ArgumentError for another name
std::unique_ptr<TrainedAgent> load_trained_agent(const std::filesystem::path& folder,
                                                 const std::string& device = "cpu");

}  // namespace enfilade::neural
