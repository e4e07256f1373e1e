/// \file  Episodes of the panoramic agent in lock-step, rollouts over them with their losses, and a
/// whole split.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/agents/panorama.h"
#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/sim/candidates.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::panoramic {

/// Where an episode begins and ends.
struct ListenerStart {
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
                   const ListenerStart& start);

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

/// Pads sentences for the encoder. \pre sentences by falling length, none empty
WordBatch batch_words(std::span<const std::vector<std::int64_t>> sentences);

/// How choices of models::Feedback::kSample are made.
enum class Draw : std::uint8_t {
  kRandom,     ///< by the network's probabilities
  kLikeliest,  ///< the likeliest, as in recordings
};

/// Options of a rollout.
struct PanoramicRolloutOptions {
  models::Feedback feedback = models::Feedback::kArgmax;
  std::size_t max_actions = 20;  ///< after which an episode ends where it is
  bool imitate = false;          ///< compute RolloutLosses::imitation
  bool reinforce = false;        ///< compute RolloutLosses::reinforcement
  Draw draw = Draw::kRandom;
  std::uint64_t seed = 1, stream = 0;  ///< of the draws
  double discount = 0.9;               ///< of a reward per step
  double entropy = 0.01;               ///< weight of the entropy
  /// Metres, strictly below: a stop is rewarded with 2.
  double success_distance = tasks::MetricOptions{}.success_distance;
  /// Whether `images` have columns dropped already: drop_environment().
  FeaturesDropped dropped = FeaturesDropped::kByNetwork;
  /// The pictures in place of `images`, on the network's device; null: `images`, sent there at each
  /// step.
  core::ResidentViews* resident = nullptr;
};

/// One step, for an observer; valid during the call, before the agents move.
struct PanoramicStep {
  std::size_t step = 0;
  const StepInput& input;
  const StepOutput& output;
  std::span<const PanoramicEpisode> walks;
  std::span<const std::size_t> choices;  ///< (n); of ended walks meaningless
};
/// Called at each step of a rollout.
using PanoramicObserver = std::function<void(const PanoramicStep&)>;

/// Tensors of a rollout for training. Arrays are [step][row]; where `active` is 0 their values have
/// no meaning.
struct RolloutLosses {
  at::Tensor imitation;      ///< cross-entropy of the teacher's choices, summed, divided by rows
  at::Tensor reinforcement;  ///< advantage actor-critic, divided by the actions taken
  std::size_t steps = 0;
  double environment_seconds = 0;  ///< of looking, moving and teachers
  std::vector<std::vector<double>> rewards, returns, values;
  std::vector<std::vector<std::uint8_t>> active;  ///< 1: the row acted
  std::vector<double> last_values;                ///< of the states after the last step
};

/// Computes rollouts to the end or max_actions. Rewards: the sign of the fall in distance (0 for
/// none), 2 or -2 for a stop. A rollout that reaches the limit has the critic's value of its last
/// state as return.
/// \pre rows of `words` and `walks` belong together
/// \throws ArgumentError for other sizes, or a teacher or reward without goals
RolloutLosses roll_out(PanoramicNetwork& network, const WordBatch& words,
                       std::span<PanoramicEpisode> walks, const ImageSource& images,
                       const PanoramicRolloutOptions& options,
                       const PanoramicObserver& observer = {});

/// Episodes with their instructions as ids, and the features of their buildings. One thread at a
/// time.
class PanoramicSplit {
 public:
  /// `episodes` and `words` have to outlive *this. \param features null without vision
  /// \throws as ViewFeatures
  PanoramicSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
                 const models::TrainConfig& config, const features::FeatureSet* features);
  PanoramicSplit(const PanoramicSplit&) = delete;
  PanoramicSplit& operator=(const PanoramicSplit&) = delete;

  /// Episodes at their starts. Rows are by falling number of words, as the encoder requires.
  struct Prepared {
    std::vector<std::size_t> places;  ///< per row, index into the given episodes
    WordBatch words;
    std::vector<PanoramicEpisode> walks;
  };
  /// \param episodes indices into EpisodeSet::episodes
  Prepared begin(std::span<const std::size_t> episodes);

  const tasks::EpisodeSet& episodes() const noexcept { return episodes_; }
  const ImageSource& images() const noexcept { return images_; }
  /// Likewise, on a card; null for the CPU, or if the agent does not see. The device is the first
  /// one asked for.
  core::ResidentViews* resident(c10::Device device);
  std::size_t max_actions() const noexcept { return max_actions_; }  ///< choices of an episode
  std::span<const std::int64_t> words(std::size_t episode) const { return words_[episode]; }
  const models::InstructionWords& vocabulary() const noexcept { return vocabulary_; }

 private:
  const tasks::EpisodeSet& episodes_;
  const models::InstructionWords& vocabulary_;
  std::size_t max_actions_;
  std::vector<std::vector<std::int64_t>> words_;  // by episode
  std::optional<core::ViewFeatures> features_;
  ImageSource images_;
  std::optional<core::ResidentViews> resident_;
  agents::PanoramaCache panoramas_;
};

/// Called at each step of each batch.
using BatchObserver =
    std::function<void(const PanoramicSplit::Prepared& batch, const PanoramicStep& step)>;

/// Walks these episodes, each with the likeliest choices, up to split.max_actions() of them.
/// \return their trajectories, in their order
std::vector<tasks::Trajectory> rollout_episodes(PanoramicNetwork& network, PanoramicSplit& split,
                                                std::span<const std::size_t> episodes,
                                                const BatchObserver& observer = {});

/// Walks all episodes of a split, and writes the files that `options` names. \return a trajectory
/// per episode, in order \throws FileError
std::vector<tasks::Trajectory> rollout_and_write(PanoramicNetwork& network, PanoramicSplit& split,
                                                 const SplitRollout& options,
                                                 const Progress& progress = {});

}  // namespace enfilade::neural::panoramic
