#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/rng.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/neural/continuous/episode_file.h"
#include "enfilade/neural/continuous/gatherer.h"
#include "enfilade/neural/continuous_agent.h"
#include "enfilade/neural/core/learner.h"
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
                 const models::StateFile& state, std::optional<continuous::SightEncoder> sight)
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
    const continuous::SightRows seen =
        sight_ ? sight_->look(batch, slots, eye_height_) : continuous::SightRows{};
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
  std::optional<continuous::SightEncoder> sight_;
  double eye_height_ = 0;
};

continuous::SightEncoder open_sight(const models::ModelFiles& files,
                                    const models::ModelConfig& config, ContinuousSight sight) {
  const std::optional<features::FeatureInfo>& trained = config.data.features;
  if (!trained) refuse(files.config().string(), "$.data.features", "missing", "the agent sees");
  sight.encoder.name = trained->encoder;
  if (trained->preprocessing == enum_name(Preprocessing::kTorchvision)) {
    sight.encoder.preprocessing = Preprocessing::kTorchvision;
  }
  if (fs::exists(files.encoder())) sight.encoder.weights = files.encoder();
  continuous::SightEncoder opened(sight);
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
        *dataset::Dataset(data).split(*setup.benchmark, split, {.experts = false}).continuous();
    core::require_goals(episodes);
    all.fingerprint.add(episodes);
    return episodes;
  };
  for (const std::string& split : config.splits) join(own->training, load(split));
  if (config.buildings) {
    core::keep_buildings(own->training, own->training.episodes, *config.buildings,
                         [](const auto& episode) { return std::string(episode.scan()); });
  }
  if (own->training.episodes.empty()) {
    throw ArgumentError(fmt::format("{}: no episode to train on", own->training.file));
  }
  if (config.evaluate_every > 0) {
    for (const std::string& split : config.validation) own->validation.push_back(load(split));
  }
  own->buildings = agents::open_buildings(*setup.benchmark, data);
  agents::check_starts(own->training, *own->buildings, setup.simulator.start_reach);
  if (config.network.inputs.vision)
    all.fingerprint.features = continuous::SightEncoder(sight).info();
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
  std::optional<continuous::SightEncoder> eyes;
  if (config.training.network.inputs.vision) eyes.emplace(open_sight(files, config, sight));
  models::InstructionWords words = models::load_instruction_words(files, config.training);
  const models::StateFile state = models::open_state(files.weights());
  return std::make_unique<LikeliestAgent>(std::move(config), std::move(words), state,
                                          std::move(eyes));
}

}  // namespace enfilade::neural

namespace enfilade::neural::continuous {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kAtOnce = 64;  // walks of one building that go on side by side

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

// The ids of each episode's instruction.
std::vector<std::vector<std::int64_t>> read_all(const tasks::ContinuousEpisodes& episodes,
                                                const models::InstructionWords& words,
                                                const models::NetworkConfig& config) {
  std::vector<std::vector<std::int64_t>> all;
  for (const tasks::ContinuousEpisode& episode : episodes.episodes) {
    all.push_back(read_text(words, episode.instruction.text, config));
  }
  return all;
}

class CeLearner : public core::NetworkLearner<CeNetwork> {
 public:
  explicit CeLearner(const core::LearnerParts& parts)
      : NetworkLearner(parts, CeNetwork(sizes_of(parts.config), parts.config.seed, parts.device),
                       {""}),
        files_(parts.files),
        told_(parts.gathering) {}

  void prepare(const TrainingData& data, Ranks& ranks) override {
    NetworkLearner::prepare(data, ranks);
    data_ = data.continuous();
    if (config().network.inputs.vision) sight_.emplace(data_->sight);
    instructions_ = read_all(data_->training, words(), config().network);
  }

  core::Update update(std::uint64_t iteration) override {
    const Clock::time_point begin = Clock::now();
    const UpdatePlace place = place_of(config().seq2seq_ce, config().batch_size, iteration);
    open_sets(place);
    const std::vector<std::size_t>& walks = order(place).at(place.batch);
    const double before = seconds(Clock::now() - begin);
    const double value = learning().learn(walks, iteration, [&](const core::BatchPart& part) {
      return loss_of(views_of(part.episodes), instructions_);
    });
    return {value, before};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    const tasks::ContinuousEpisodes& episodes = data_->validation.at(split);
    Gatherer walker(
        parts(), {.teacher_share = 0, .drawn = false, .last_action = config().max_steps}, episodes);
    const auto walks = run(walker, episodes, config().seed);
    const fs::path file = files.results(episodes.split);
    if (ranks().is_first()) {
      write_file(files, file, to_json(walks, episodes, tasks::ContinuousForm::kR2r));
    }
    models::EvaluationRecord record = measured(walks, episodes);
    record.loss = mean_loss(walker.walks(), read_all(episodes, words(), config().network));
    return record;
  }

 private:
  GathererParts parts() {
    return {&network(), &words(), &config().network, sight_ ? &*sight_ : nullptr};
  }

  std::vector<tasks::ContinuousResult> run(agents::ContinuousAgent& agent,
                                           const tasks::ContinuousEpisodes& episodes,
                                           std::uint64_t seed) {
    agents::ContinuousRunOptions options{
        .batch_size = kAtOnce, .seed = seed, .simulator = data_->setup.simulator};
    options.simulator.most_steps = static_cast<std::uint32_t>(config().max_steps);
    return agents::run_continuous(agent, episodes, data_->buildings, options);
  }

  // Opens the sets up to `place`, and gathers the last one where it is needed for the first time.
  void open_sets(const UpdatePlace& place) {
    while (sets_ < place.sets) {
      ++sets_;
      const bool now = sets_ == place.sets && place.first();
      std::vector<std::size_t> chosen = chosen_for(sets_);
      std::map<std::string, std::vector<std::size_t>> by_scan;
      for (const std::size_t e : chosen) {
        by_scan[std::string(data_->training.episodes[e].scan())].push_back(e);
      }
      std::size_t done = 0;
      const std::string weights =
          now ? core::hash_of(core::on_cpu(network().weights())) : std::string();
      // Each process gathers the walks of some buildings.
      std::size_t building = 0;
      for (const auto& [scan, episodes] : by_scan) {
        const fs::path file = files_.walks(sets_, scan);
        const bool own = static_cast<int>(building++ % static_cast<std::size_t>(ranks().size())) ==
                         ranks().rank();
        if (now && own && !is_there(file, weights)) gather(file, episodes, weights);
        done += episodes.size();
        if (now && told_) told_({sets_, config().seq2seq_ce.sets, done, chosen.size()});
      }
      ranks().meet();
      for (const auto& [scan, episodes] : by_scan) add(files_.walks(sets_, scan));
    }
  }

  std::size_t features() const {
    return config().network.inputs.vision ? config().network.features : 0;
  }

  // Whether these walks were gathered with the weights of that hash.
  bool is_there(const fs::path& file, const std::string& weights) const {
    if (!fs::exists(file)) return false;
    try {
      return EpisodeFile(file, features()).weights() == weights;
    } catch (const InvalidInput&) {
      return false;
    }
  }

  void add(const fs::path& file) {
    if (!fs::exists(file)) {
      throw FileError(fmt::format(
          "{}: there are no such walks, which training was in the middle of learning from; remove "
          "the folder {} to begin anew",
          file.string(), files_.folder.string()));
    }
    const EpisodeFile& walks =
        *opened_.emplace_back(std::make_unique<EpisodeFile>(file, features()));
    for (std::size_t i = 0; i < walks.size(); ++i) {
      walks_.push_back(walks.walk(i));
      lengths_.push_back(walks_.back().steps());
      if (walks_.back().episode >= instructions_.size() || lengths_.back() == 0) {
        refuse(file.string(), "", "wrong-walk", fmt::format("walk {} has no step or episode", i));
      }
    }
    order_of_ = std::nullopt;
  }

  // Passes over all episodes, a set after the other.
  std::vector<std::size_t> chosen_for(std::size_t set) const {
    core::EpisodeOrder order(data_->training.episodes.size(), config().seq2seq_ce.set_walks,
                             config().seed);
    const auto batch = order.batch(set - 1);
    return {batch.begin(), batch.end()};
  }

  void gather(const fs::path& file, const std::vector<std::size_t>& chosen,
              const std::string& weights) {
    tasks::ContinuousEpisodes episodes{data_->training.split, data_->training.file, {}};
    for (const std::size_t e : chosen) {
      episodes.episodes.push_back(data_->training.episodes[e]);
    }
    const double share =
        std::pow(config().seq2seq_ce.teacher_share, static_cast<double>(sets_ - 1));
    Gatherer walker(parts(), {.teacher_share = share}, episodes);
    run(walker, episodes, Rng(config().seed, sets_).next());
    std::vector<RecordedEpisode> walks = walker.walks();
    for (std::size_t i = 0; i < walks.size(); ++i) walks[i].episode = chosen[i];
    const OutputFolder out(files_.folder);
    write_episodes(out.file(file.lexically_relative(files_.folder).string()), walks, weights);
  }

  const std::vector<std::vector<std::size_t>>& order(const UpdatePlace& place) {
    const std::uint64_t pass = place.sets * config().seq2seq_ce.epochs + place.epoch;
    if (order_of_ != pass) {
      order_ = pass_over(lengths_, config().batch_size, config().seed, pass);
      order_of_ = pass;
    }
    return order_;
  }

  std::vector<EpisodeView> views_of(std::span<const std::size_t> walks) const {
    std::vector<EpisodeView> views;
    for (const std::size_t walk : walks) views.push_back(walks_[walk]);
    return views;
  }

  at::Tensor loss_of(const std::vector<EpisodeView>& walks,
                     const std::vector<std::vector<std::int64_t>>& instructions) const {
    const TrajectoryBatch batch = side_by_side(walks, network().sizes());
    std::vector<std::vector<std::int64_t>> texts;
    for (const std::size_t episode : batch.episodes) texts.push_back(instructions[episode]);
    const at::Tensor states = network().walk(network().read(texts), batch.steps,
                                             network().begin(std::ssize(batch.episodes)));
    return inflection_loss(network().score(states), batch.teacher, batch.steps.counts,
                           config().seq2seq_ce.inflection);
  }

  // Of walks of its own, to the teacher's choices there.
  double mean_loss(const std::vector<RecordedEpisode>& walks,
                   const std::vector<std::vector<std::int64_t>>& instructions) const {
    const c10::NoGradGuard no_gradients;
    double sum = 0;
    for (std::size_t i = 0; i < walks.size(); ++i) {
      EpisodeView view = view_of(walks[i]);
      view.episode = i;
      sum += loss_of({view}, instructions).item<double>();
    }
    return sum / static_cast<double>(walks.size());
  }

  models::EvaluationRecord measured(const std::vector<tasks::ContinuousResult>& walks,
                                    const tasks::ContinuousEpisodes& episodes) const {
    const auto scores = agents::score_continuous_walks(walks, episodes, *data_->buildings);
    models::EvaluationRecord record;
    record.split = episodes.split;
    record.episodes = scores.size();
    const auto n = static_cast<double>(scores.size());
    for (const tasks::ContinuousScore& score : scores) {
      record.trajectory_length += score.path_length / n;
      record.nav_error += score.distance_to_goal / n;
      record.success_rate += score.success / n;
      record.oracle_success_rate += score.oracle_success / n;
      if (!std::isnan(score.spl)) record.spl += score.spl / n;  // starts at the goal
    }
    return record;
  }

  models::ModelFiles files_;
  std::function<void(const GatheringProgress&)> told_;
  const ContinuousData* data_ = nullptr;
  std::optional<SightEncoder> sight_;
  std::vector<std::vector<std::int64_t>> instructions_;  // by training episode
  std::size_t sets_ = 0;                                 // opened
  std::vector<std::unique_ptr<EpisodeFile>> opened_;
  std::vector<EpisodeView> walks_;    // of all sets
  std::vector<std::size_t> lengths_;  // their steps
  std::optional<std::uint64_t> order_of_;
  std::vector<std::vector<std::size_t>> order_;  // of that pass
};

}  // namespace
}  // namespace enfilade::neural::continuous

namespace enfilade::neural::core {

std::unique_ptr<Learner> make_continuous_learner(const LearnerParts& parts) {
  return std::make_unique<continuous::CeLearner>(parts);
}

}  // namespace enfilade::neural::core
