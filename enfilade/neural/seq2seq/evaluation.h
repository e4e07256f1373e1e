/// \file  Room-to-Room episodes through the network: the environment, greedy rollouts and losses of
/// a split.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/agents/episode_batch.h"
#include "enfilade/core/progress.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/seq2seq/seq2seq.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::seq2seq {

/// How many episodes run at once, and where the released code differs from what one expects.
struct R2rEnvironmentConfig {
  std::size_t batch_size = 100;
  std::size_t max_steps = 20;  ///< for which memory is kept; longer trajectories allocate
  models::AfterEnd after_end = models::AfterEnd::kWalksOn;
  models::ForwardTo forward = models::ForwardTo::kNearest;
};

/// A batch of episodes of one split, in SimulatorConfig::room_to_room(). Start: the path's first
/// viewpoint, heading snapped to 30 degrees, elevation 0. `forward` where nothing is ahead, and
/// numbers that are no action, leave the agent where it is. observe() and step() allocate nothing
/// up to max_steps. One thread at a time.
class R2rEnvironment : public Environment {
 public:
  /// `episodes` and `features` (null: none, dimensions() is 0) have to outlive *this.
  /// \throws ArgumentError for a batch_size of 0, or kIntended where goals are hidden
  R2rEnvironment(const tasks::EpisodeSet& episodes, const core::ViewFeatures* features,
                 const R2rEnvironmentConfig& config);

  /// Begins these episodes (indices into EpisodeSet::episodes). Must come before the first
  /// observe(). \throws ArgumentError for another number than batch_size, or an index out of range
  void start(std::span<const std::size_t> episodes);

  std::size_t size() const override { return config_.batch_size; }
  std::size_t dimensions() const override;
  bool has_teacher() const override { return has_teacher_; }  ///< no goal of the split is hidden
  void observe(const EnvironmentView& out) override;
  bool step(std::span<const std::int32_t> actions) override;
  std::span<const std::uint8_t> ended() const override { return batch_.ended(); }

  /// Each agent's trajectory since start(), as in results files: the start, then one entry per
  /// action until `end`, which adds none.
  std::span<const tasks::Trajectory> trajectories() const noexcept { return batch_.trajectories(); }

 private:
  agents::Decision teacher(std::size_t slot) const;
  std::int32_t label(std::size_t slot) const;
  sim::Action action_of(std::size_t slot, std::int32_t action) const;

  const core::ViewFeatures* features_;
  R2rEnvironmentConfig config_;
  bool has_teacher_;
  agents::EpisodeBatch batch_;
  std::vector<sim::Action> actions_;
};

/// A split with its encoded instructions and features. Immutable: any thread may read.
struct PreparedSplit {
  tasks::EpisodeSet episodes;
  models::EncodedInstructions instructions;
  std::optional<core::ViewFeatures> features;  ///< none if the network does not see

  /// Null if there are no features.
  const core::ViewFeatures* view_features() const { return features ? &*features : nullptr; }
};
/// Encodes instructions and looks up features. \param features null without vision
/// \throws as ViewFeatures
PreparedSplit prepare(tasks::EpisodeSet episodes, const tasks::Vocabulary& vocabulary,
                      std::size_t max_words, const features::FeatureSet* features);

/// The actions of one episode, and the attention to the instruction before each.
struct AttentionTrace {
  std::vector<std::int32_t> actions;  ///< `end` included if it was chosen
  /// One weight per word of the row, padding left out; none if the network does not use language.
  std::vector<std::vector<float>> attention;
};

/// The walks of all episodes of a split.
struct GreedyRollout {
  std::vector<tasks::Trajectory> trajectories;  ///< one per episode, in order
  std::vector<AttentionTrace> traces;           ///< likewise
};

/// Sizes of a walk.
struct BatchOptions {
  std::size_t batch_size = 100;  ///< episodes at once
  std::size_t max_steps = 20;    ///< actions of an episode
  Ranks* ranks = nullptr;        ///< processes that do batches in turn; all have all results
};

/// Walks all episodes, with the most likely action at every step and no dropout, to `end` or
/// max_steps.
/// \throws ArgumentError if the network does not fit the split
GreedyRollout rollout_greedily(Network& network, const PreparedSplit& split,
                               const BatchOptions& options = {}, const Progress& progress = {});

/// Options of compute_loss().
struct LossOptions {
  BatchOptions batches;
  RolloutOptions rollout;  ///< its stream is that of the first batch; each batch takes the next
  models::AfterEnd after_end = models::AfterEnd::kWalksOn;
  models::ForwardTo forward = models::ForwardTo::kNearest;
};
/// The loss as the released code logs it: summed over steps, divided by max_steps. Here it is
/// averaged over episodes.
/// \pre options.rollout.feedback is not kArgmax; the split's goals are known
double compute_loss(Network& network, const PreparedSplit& split, const LossOptions& options);

/// Writes the results file and the attention file that `files` names. The latter, unless its name
/// is empty, has the first `attention_episodes` episodes. If the split can be scored, a third as
/// many of the best by SPL follow, and of the worst by navigation error. \throws FileError
void write_rollout(const SplitRollout& files, const GreedyRollout& walk, const PreparedSplit& split,
                   const tasks::Vocabulary& vocabulary, std::size_t attention_episodes = 60);

/// The content of a model directory, without the checkpoint.
struct Model {
  models::ModelConfig config;
  tasks::Vocabulary vocabulary;
  std::uint64_t iteration = 0;  ///< of the weights
  std::unique_ptr<Network> network;
};
/// Loads a model of seq2seq.
/// \throws FileError for a missing file
/// \throws InvalidInput for damaged files, a vocabulary of another size than the network's, or
/// weights that do not fit
/// \throws ArgumentError for another agent's model
/// \throws Error for a device that is not available
Model load_model(const std::filesystem::path& folder, const std::string& device = "cpu");

/// Chooses the most likely action at each step, at most TrainConfig::max_steps (20).
class Seq2SeqAgent : public TrainedAgent {
 public:
  /// From load_model(); usable after enter().
  explicit Seq2SeqAgent(Model model) : model_(std::move(model)) {}

  const models::ModelConfig& config() const noexcept override { return model_.config; }
  std::uint64_t iteration() const noexcept override { return model_.iteration; }
  void enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override;
  std::vector<tasks::Trajectory> walk(const SplitRollout& options,
                                      const Progress& progress) override;

  std::string_view name() const override { return "seq2seq"; }
  void start(std::span<const agents::Observation> batch) override;
  void act(std::span<const agents::Observation> batch,
           std::span<agents::Decision> decisions) override;

 private:
  const core::ViewFeatures* features() const { return split_->view_features(); }

  Model model_;
  std::optional<PreparedSplit> split_;
  std::vector<ScanIndex> scans_;  // by slot
  std::vector<float> seen_;
  std::vector<std::uint8_t> forward_open_;
  std::vector<std::int32_t> actions_;
};

}  // namespace enfilade::neural::seq2seq
