#include "enfilade/neural/trained_agent.h"

#include <fmt/format.h>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

#include "enfilade/agents/panorama.h"
#include "enfilade/core/errors.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/duet/duet_split.h"
#include "enfilade/neural/panoramic/panoramic_episode.h"
#include "enfilade/neural/seq2seq/evaluation.h"

namespace enfilade::neural {
namespace {

// Computes the whole trajectory when an episode begins: a building does not change during it,
// and what a network sees at a viewpoint is known before. So trajectories come from the same
// code, batch by batch, in the simulator and over whole splits.
class PlannedAgent : public TrainedAgent {
 public:
  explicit PlannedAgent(models::ModelConfig config, std::uint64_t iteration,
                        agents::Turning turning)
      : config_(std::move(config)), iteration_(iteration), turning_(turning) {}

  const models::ModelConfig& config() const noexcept override { return config_; }
  std::uint64_t iteration() const noexcept override { return iteration_; }
  // The kind, as in config.json.
  std::string_view name() const override { return to_string(config_.training.agent); }
  void enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override {
    prepare(episodes, usable_features(config_, features));
    episodes_ = &episodes;
    panoramas_ = std::make_unique<agents::PanoramaCache>(episodes.graphs);
    slots_.clear();
  }

  void start(std::span<const agents::Observation> batch) override {
    std::vector<std::size_t> episodes;
    for (const agents::Observation& seen : batch) {
      episodes.push_back(static_cast<std::size_t>(seen.episode - episodes_->episodes.data()));
    }
    slots_.clear();
    for (const tasks::Trajectory& trajectory : walk(episodes)) {
      Slot slot{agents::Route(turning_),
                {trajectory.turning_point, trajectory.object, trajectory.point}};
      std::vector<ViewpointIndex> way;
      for (const tasks::TrajectoryPoint& point : trajectory.points) {
        // An entry a turn, or the start: the agent is there already.
        if (!way.empty() ? way.back() != point.viewpoint
                         : point.viewpoint != trajectory.points.front().viewpoint) {
          way.push_back(point.viewpoint);
        }
      }
      slot.route.set(way);
      slots_.push_back(std::move(slot));
    }
  }

  void act(std::span<const agents::Observation> batch,
           std::span<agents::Decision> decisions) override {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (batch[i].ended) continue;
      const ScanIndex scan = episodes_->graphs->at(batch[i].graph->scan());
      const auto next = slots_[i].route.next(batch[i], panoramas_->at({scan, batch[i].viewpoint}));
      decisions[i] = next ? *next : agents::Decision::stop_with(slots_[i].answer);
    }
  }

 protected:
  // enter() of the kind. \param features that it uses; null if it does not see
  virtual void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) = 0;
  // Greedy walks of these episodes of those that were entered, in their order.
  virtual std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) = 0;
  using TrainedAgent::walk;

 private:
  struct Slot {
    agents::Route route;
    agents::Answer answer;
  };

  models::ModelConfig config_;
  std::uint64_t iteration_;
  agents::Turning turning_;
  const tasks::EpisodeSet* episodes_ = nullptr;
  std::unique_ptr<agents::PanoramaCache> panoramas_;
  std::vector<Slot> slots_;
};

// \tparam Split made of episodes, words, a TrainConfig and features, and of objects if it is a
// split of an agent that may name one; rollout_episodes() and rollout_and_write() of Network and
// Split are found beside them
template <class Network, class Split>
class ViewpointAgent : public PlannedAgent {
 public:
  ViewpointAgent(models::ModelConfig config, models::InstructionWords words,
                 std::uint64_t iteration, Network network, agents::Turning turning)
      : PlannedAgent(std::move(config), iteration, turning),
        words_(std::move(words)),
        network_(std::move(network)) {}

  void set_objects(const std::shared_ptr<const features::ObjectSet>& objects) override {
    objects_ = objects;
  }
  std::vector<tasks::Trajectory> walk(const SplitRollout& options,
                                      const Progress& progress) override {
    return rollout_and_write(network_, *split_, options, progress);
  }

 protected:
  void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override {
    const models::TrainConfig& training = config().training;
    if constexpr (kShowsObjects) {
      split_ = std::make_unique<Split>(episodes, words_, training, features, objects_);
    } else {
      split_ = std::make_unique<Split>(episodes, words_, training, features);
    }
  }
  std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) override {
    return rollout_episodes(network_, *split_, episodes);
  }

 private:
  using Objects = std::shared_ptr<const features::ObjectSet>;
  static constexpr bool kShowsObjects =
      std::is_constructible_v<Split, const tasks::EpisodeSet&, const models::InstructionWords&,
                              const models::TrainConfig&, const features::FeatureSet*, Objects>;

  models::InstructionWords words_;
  Network network_;
  Objects objects_;
  std::unique_ptr<Split> split_;
};

}  // namespace

namespace fs = std::filesystem;

std::unique_ptr<TrainedAgent> load_trained_agent(const fs::path& folder,
                                                 const std::string& device_name) {
  const models::ModelFiles files = models::require_model(folder);
  const models::ModelConfig config = models::load_model_config(files.config());
  const models::AgentKind kind = config.training.agent;
  if (kind == models::AgentKind::kSeq2Seq) {
    return std::make_unique<seq2seq::Seq2SeqAgent>(seq2seq::load_model(folder, device_name));
  }
  if (kind == models::AgentKind::kSpeaker) {
    throw ArgumentError(fmt::format("{}: a speaker, which describes paths and does not walk them",
                                    folder.string()));
  }
  if (kind == models::AgentKind::kSeq2SeqCe) {
    throw ArgumentError(fmt::format("{}: a continuous agent, not one of the graph: --task r2r-ce",
                                    folder.string()));
  }
  const c10::Device device = core::open_agents_device(device_name);
  models::InstructionWords words = models::load_instruction_words(files, config.training);
  const models::StateFile state = models::open_state(files.weights());
  // EnvDrop's trajectories have an entry a turn, and it turns to the right only. DUET's have none.
  if (kind == models::AgentKind::kDuet) {
    return std::make_unique<ViewpointAgent<duet::DuetNetwork, duet::DuetSplit>>(
        config, std::move(words), state.iteration,
        duet::DuetNetwork(duet_sizes(config.training), state.file, device),
        agents::Turning::kShorter);
  }
  using panoramic::PanoramicNetwork;
  return std::make_unique<ViewpointAgent<PanoramicNetwork, panoramic::PanoramicSplit>>(
      config, std::move(words), state.iteration,
      PanoramicNetwork(panoramic_sizes(config.training), state.file, device),
      agents::Turning::kRight);
}

}  // namespace enfilade::neural
