#include "enfilade/neural/seq2seq_ce/learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/continuous_agent.h"
#include "enfilade/neural/detail/episode_order.h"
#include "enfilade/neural/detail/optimizer.h"
#include "enfilade/neural/detail/parted_learning.h"
#include "enfilade/neural/seq2seq_ce/batches.h"
#include "enfilade/neural/seq2seq_ce/gatherer.h"
#include "enfilade/tasks/continuous_measures.h"

namespace enfilade::neural::seq2seq_ce {
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

class CeLearner : public detail::Learner {
 public:
  CeLearner(const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
            models::ModelFiles files, c10::Device device,
            std::function<void(const GatheringProgress&)> told)
      : config_(config),
        words_(vocabulary),
        files_(std::move(files)),
        told_(std::move(told)),
        network_(sizes_of(config), config.seed, device),
        optimizer_(detail::optimizer_of(config, {""})) {}

  void prepare(const TrainingData& data, Ranks& ranks) override {
    ranks_ = &ranks;
    learning_.emplace(ranks, config_.parts.value_or(1), network_.weights(), optimizer_);
    data_ = data.continuous.get();
    if (config_.network.inputs.vision) sight_.emplace(data_->sight);
    instructions_ = read_all(data_->training, words_, config_.network);
  }

  detail::Update update(std::uint64_t iteration) override {
    const Clock::time_point begin = Clock::now();
    const Place place = place_of(config_.seq2seq_ce, config_.batch_size, iteration);
    open_sets(place);
    const std::vector<std::size_t>& walks = order(place).at(place.batch);
    const double before = seconds(Clock::now() - begin);
    const double value = learning_->learn(walks, iteration, [&](const detail::BatchPart& part) {
      return loss_of(views_of(part.episodes), instructions_);
    });
    return {value, before};
  }

  detail::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                             const models::ModelFiles& files) override {
    const tasks::ContinuousEpisodes& episodes = data_->validation.at(split);
    Gatherer walker(parts(), {.teacher_share = 0, .drawn = false, .last_action = config_.max_steps},
                    episodes);
    const auto walks = run(walker, episodes, config_.seed);
    const fs::path file = files.results(episodes.split);
    if (ranks_->is_first()) {
      make_folder(file.parent_path());
      write_file_atomically(file, to_json(walks, episodes, tasks::ContinuousResultsForm::kR2r));
    }
    models::EvaluationRecord record = measured(walks, episodes);
    record.loss = mean_loss(walker.walks(), read_all(episodes, words_, config_.network));
    return record;
  }

  Network::State weights() const override { return detail::as_state(network_.weights()); }
  Network::State training_state() const override {
    return detail::as_state(optimizer_.state(network_.weights()));
  }
  void load_training_state(const features::TensorFile& file) override {
    optimizer_.load(network_.weights(), file);
  }

 private:
  WalkerParts parts() {
    return {&network_, &words_, &config_.network, sight_ ? &*sight_ : nullptr};
  }

  std::vector<tasks::ContinuousResult> run(agents::ContinuousAgent& agent,
                                           const tasks::ContinuousEpisodes& episodes,
                                           std::uint64_t seed) {
    agents::ContinuousRunOptions options{
        .batch_size = kAtOnce, .seed = seed, .simulator = data_->benchmark.simulator};
    options.simulator.most_steps = static_cast<std::uint32_t>(config_.max_steps);
    return agents::run_continuous(agent, episodes, data_->buildings, options);
  }

  // Opens the sets up to `place`, and gathers the last one where it is needed for the first time.
  void open_sets(const Place& place) {
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
          now ? detail::hash_of(detail::on_cpu(network_.weights())) : std::string();
      // Each process gathers the walks of some buildings.
      std::size_t building = 0;
      for (const auto& [scan, episodes] : by_scan) {
        const fs::path file = files_.walks(sets_, scan);
        const bool own = static_cast<int>(building++ % static_cast<std::size_t>(ranks_->size())) ==
                         ranks_->rank();
        if (now && own && !is_there(file, weights)) gather(file, episodes, weights);
        done += episodes.size();
        if (now && told_) told_({sets_, config_.seq2seq_ce.sets, done, chosen.size()});
      }
      ranks_->meet();
      for (const auto& [scan, episodes] : by_scan) add(files_.walks(sets_, scan));
    }
  }

  std::size_t features() const {
    return config_.network.inputs.vision ? config_.network.features : 0;
  }

  // Whether these walks were gathered with the weights of that hash.
  bool is_there(const fs::path& file, const std::string& weights) const {
    if (!fs::exists(file)) return false;
    try {
      return WalkFile(file, features()).weights() == weights;
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
    const WalkFile& walks = *opened_.emplace_back(std::make_unique<WalkFile>(file, features()));
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
    detail::EpisodeOrder order(data_->training.episodes.size(), config_.seq2seq_ce.set_walks,
                               config_.seed);
    const auto batch = order.batch(set - 1);
    return {batch.begin(), batch.end()};
  }

  void gather(const fs::path& file, const std::vector<std::size_t>& chosen,
              const std::string& weights) {
    tasks::ContinuousEpisodes episodes{data_->training.split, data_->training.file, {}};
    for (const std::size_t e : chosen) {
      episodes.episodes.push_back(data_->training.episodes[e]);
    }
    const double share = std::pow(config_.seq2seq_ce.teacher_share, static_cast<double>(sets_ - 1));
    Gatherer walker(parts(), {.teacher_share = share}, episodes);
    run(walker, episodes, Rng(config_.seed, sets_).next());
    std::vector<RecordedWalk> walks = walker.walks();
    for (std::size_t i = 0; i < walks.size(); ++i) walks[i].episode = chosen[i];
    make_folder(file.parent_path());
    write_walks(file, walks, weights);
  }

  const std::vector<std::vector<std::size_t>>& order(const Place& place) {
    const std::uint64_t pass = place.sets * config_.seq2seq_ce.epochs + place.epoch;
    if (order_of_ != pass) {
      order_ = pass_over(lengths_, config_.batch_size, config_.seed, pass);
      order_of_ = pass;
    }
    return order_;
  }

  std::vector<WalkView> views_of(std::span<const std::size_t> walks) const {
    std::vector<WalkView> views;
    for (const std::size_t walk : walks) views.push_back(walks_[walk]);
    return views;
  }

  at::Tensor loss_of(const std::vector<WalkView>& walks,
                     const std::vector<std::vector<std::int64_t>>& instructions) const {
    const WalkBatch batch = side_by_side(walks, network_.sizes());
    std::vector<std::vector<std::int64_t>> texts;
    for (const std::size_t episode : batch.episodes) texts.push_back(instructions[episode]);
    const at::Tensor states = network_.walk(network_.read(texts), batch.steps,
                                            network_.begin(std::ssize(batch.episodes)));
    return inflection_loss(network_.score(states), batch.teacher, batch.steps.counts,
                           config_.seq2seq_ce.inflection);
  }

  // Loss of its own rollouts, to the teacher's choices there.
  double mean_loss(const std::vector<RecordedWalk>& walks,
                   const std::vector<std::vector<std::int64_t>>& instructions) const {
    const c10::NoGradGuard no_gradients;
    double sum = 0;
    for (std::size_t i = 0; i < walks.size(); ++i) {
      WalkView view = view_of(walks[i]);
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

  const models::TrainConfig& config_;
  models::InstructionWords words_;
  models::ModelFiles files_;
  std::function<void(const GatheringProgress&)> told_;
  CeNetwork network_;
  detail::Optimizer optimizer_;
  const ContinuousData* data_ = nullptr;
  Ranks* ranks_ = nullptr;
  std::optional<detail::PartedLearning> learning_;
  std::optional<Sight> sight_;
  std::vector<std::vector<std::int64_t>> instructions_;  // by training episode
  std::size_t sets_ = 0;                                 // opened
  std::vector<std::unique_ptr<WalkFile>> opened_;
  std::vector<WalkView> walks_;       // of all sets
  std::vector<std::size_t> lengths_;  // their steps
  std::optional<std::uint64_t> order_of_;
  std::vector<std::vector<std::size_t>> order_;  // of that pass
};

}  // namespace

std::unique_ptr<detail::Learner> make_learner(
    const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
    const models::ModelFiles& files, c10::Device device,
    const std::function<void(const GatheringProgress&)>& told) {
  return std::make_unique<CeLearner>(config, vocabulary, files, device, told);
}

}  // namespace enfilade::neural::seq2seq_ce
