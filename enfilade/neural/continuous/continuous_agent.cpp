#include "enfilade/neural/continuous_agent.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/core/errors.h"
#include "enfilade/neural/continuous/gatherer.h"
#include "enfilade/neural/trained_agent.h"

namespace enfilade::neural {
namespace {

namespace fs = std::filesystem;
using enfilade::continuous::Action;

void check_benchmark(const agents::ContinuousSetup& setup) {
  if (setup.benchmark->form == tasks::ContinuousForm::kR2r) return;
  throw ArgumentError(fmt::format(
      "task {}: the agent has four actions, and does not look up and down; r2r-ce is allowed",
      setup.benchmark->name));
}

std::shared_ptr<const enfilade::continuous::Buildings> open_buildings(
    const fs::path& data, const agents::ContinuousSetup& setup) {
  const fs::path folder = data / setup.navigation_folder();
  if (!fs::is_directory(folder)) {
    throw FileError(
        fmt::format("{}: no such folder of navigation meshes; `enfilade continuous {}` makes it",
                    folder.string(), data.string()));
  }
  return std::make_shared<const enfilade::continuous::Buildings>(folder);
}

// Leaves only the episodes in the first `most` scans, in their order.
void keep_buildings(tasks::ContinuousEpisodes& episodes, std::size_t most) {
  std::vector<std::string> scans;
  for (const tasks::ContinuousEpisode& episode : episodes.episodes) {
    if (std::ranges::find(scans, episode.scan()) == scans.end()) scans.emplace_back(episode.scan());
  }
  if (scans.size() < most) {
    throw ArgumentError(
        fmt::format("buildings: {}, but split {} has {}", most, episodes.split, scans.size()));
  }
  scans.resize(most);
  std::erase_if(episodes.episodes, [&](const tasks::ContinuousEpisode& episode) {
    return std::ranges::find(scans, episode.scan()) == scans.end();
  });
}

void require_goals(const tasks::ContinuousEpisodes& episodes) {
  if (!goals_hidden(episodes)) return;
  throw ArgumentError(
      fmt::format("split {}: its goals are hidden, so it cannot be trained on or validated with",
                  episodes.split));
}

void join(tasks::ContinuousEpisodes& all, tasks::ContinuousEpisodes more) {
  if (all.episodes.empty()) {
    all = std::move(more);
    return;
  }
  all.split += "+" + more.split;
  all.episodes.insert(all.episodes.end(), std::make_move_iterator(more.episodes.begin()),
                      std::make_move_iterator(more.episodes.end()));
}

// What differs of an encoder from that of training.
std::vector<std::string> encoder_differences(const features::FeatureInfo& there,
                                             const features::FeatureInfo& here) {
  std::vector<std::string> found;
  const auto compare = [&](const char* what, const auto& was, const auto& is) {
    if (was != is) found.push_back(fmt::format("{} {}, not {}", what, is, was));
  };
  compare("encoder", there.encoder, here.encoder);
  compare("numbers a picture", there.dimensions, here.dimensions);
  compare("preprocessing", there.preprocessing, here.preprocessing);
  compare("weights", there.weights, here.weights);
  return found;
}

class LikeliestAgent final : public TrainedContinuousAgent {
 public:
  LikeliestAgent(models::ModelConfig config, models::InstructionWords words,
                 const models::StateFile& state, std::optional<continuous::Sight> sight)
      : config_(std::move(config)),
        words_(std::move(words)),
        iteration_(state.iteration),
        network_(continuous::sizes_of(config_.training), state.file),
        states_(network_),
        sight_(std::move(sight)) {}

  const models::ModelConfig& config() const noexcept override { return config_; }
  std::uint64_t iteration() const noexcept override { return iteration_; }
  std::string_view name() const override { return to_string(config_.training.agent); }

  void start(std::size_t slot, const agents::ContinuousObservation& seen,
             const enfilade::continuous::SimulatorConfig& config) override {
    states_.start(slot, continuous::read_text(words_, seen.episode->instruction.text,
                                              config_.training.network));
    eye_height_ = config.eye_height;
  }

  void act(std::span<const agents::ContinuousObservation> batch,
           std::span<Action> actions) override {
    const std::vector<std::size_t> slots = continuous::walking(batch);
    const continuous::Seen seen =
        sight_ ? sight_->look(batch, slots, eye_height_) : continuous::Seen{};
    const std::vector<std::int64_t> likeliest = states_.likeliest(slots, seen);
    for (std::size_t k = 0; k < slots.size(); ++k) {
      const bool last = batch[slots[k]].step + 1 >= config_.training.max_steps;
      const std::int64_t choice = last ? 0 : likeliest[k];
      states_.tell(slots[k], choice);
      actions[slots[k]] = static_cast<Action>(choice);
    }
  }

 private:
  models::ModelConfig config_;
  models::InstructionWords words_;
  std::uint64_t iteration_;
  continuous::CeNetwork network_;
  continuous::EpisodeStates states_;
  std::optional<continuous::Sight> sight_;
  double eye_height_ = 0;
};

continuous::Sight open_sight(const models::ModelFiles& files, const models::ModelConfig& config,
                             ContinuousSight sight) {
  const std::optional<features::FeatureInfo>& trained = config.data.features;
  if (!trained) refuse(files.config().string(), "$.data.features", "missing", "the agent sees");
  sight.encoder.name = trained->encoder;
  if (trained->preprocessing == to_string(Preprocessing::kTorchvision)) {
    sight.encoder.preprocessing = Preprocessing::kTorchvision;
  }
  if (fs::exists(files.encoder())) sight.encoder.weights = files.encoder();
  continuous::Sight opened(sight);
  std::vector<std::string> differ = encoder_differences(*trained, opened.info());
  if (config.training.network.features != opened.info().dimensions) {
    differ.push_back(fmt::format("the network was made for {} numbers a picture",
                                 config.training.network.features));
  }
  if (differ.empty()) return opened;
  throw ArgumentError(fmt::format("{}: not the encoder that the agent was trained with:\n  {}",
                                  files.encoder().string(), fmt::join(differ, "\n  ")));
}

}  // namespace

TrainingData load_continuous_data(const fs::path& data, const agents::ContinuousSetup& setup,
                                  const models::TrainConfig& config, const ContinuousSight& sight) {
  check_benchmark(setup);
  auto own = std::make_shared<ContinuousData>();
  own->setup = setup;
  own->sight = sight;
  TrainingData all;
  const auto load = [&](const std::string& split) {
    tasks::ContinuousEpisodes episodes =
        agents::load_continuous_split(*setup.benchmark, data, split);
    require_goals(episodes);
    all.fingerprint.add(episodes);
    return episodes;
  };
  for (const std::string& split : config.splits) join(own->training, load(split));
  if (config.buildings) keep_buildings(own->training, *config.buildings);
  if (own->training.episodes.empty()) {
    throw ArgumentError(fmt::format("{}: no episode to train on", own->training.file));
  }
  if (config.evaluate_every > 0) {
    for (const std::string& split : config.validation) own->validation.push_back(load(split));
  }
  own->buildings = open_buildings(data, setup);
  agents::check_starts(own->training, *own->buildings, setup.simulator.start_reach);
  if (config.network.inputs.vision) all.fingerprint.features = continuous::Sight(sight).info();
  all.episodes = std::move(own);
  return all;
}

std::unique_ptr<TrainedContinuousAgent> load_continuous_agent(const fs::path& folder,
                                                              const ContinuousSight& sight) {
  const models::ModelFiles files = models::require_model(folder);
  models::ModelConfig config = models::load_model_config(files.config());
  if (config.training.agent != models::AgentKind::kSeq2SeqCe) {
    throw ArgumentError(
        fmt::format("{}: an agent {}, of the graph; continuous episodes need --walk-graph",
                    folder.string(), to_string(config.training.agent)));
  }
  std::optional<continuous::Sight> eyes;
  if (config.training.network.inputs.vision) eyes.emplace(open_sight(files, config, sight));
  models::InstructionWords words = models::load_instruction_words(files, config.training);
  const models::StateFile state = models::open_state(files.weights());
  return std::make_unique<LikeliestAgent>(std::move(config), std::move(words), state,
                                          std::move(eyes));
}

}  // namespace enfilade::neural
