#include "enfilade/neural/trainer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <chrono>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/models/folder_lock.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/neural/detail/episode_order.h"
#include "enfilade/neural/evaluation.h"
#include "enfilade/tasks/score.h"

namespace enfilade::neural {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kLogEvery = 10;  // iterations a line of training loss

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

// Forwards all calls to an environment and adds up their time.
class TimedEnvironment : public Environment {
 public:
  explicit TimedEnvironment(Environment& inner) : inner_(inner) {}
  Clock::duration spent() const noexcept { return spent_; }

  std::size_t size() const override { return inner_.size(); }
  std::size_t dimensions() const override { return inner_.dimensions(); }
  bool has_teacher() const override { return inner_.has_teacher(); }
  std::span<const std::uint8_t> ended() const override { return inner_.ended(); }
  void observe(const EnvironmentView& out) override {
    const Clock::time_point begin = Clock::now();
    inner_.observe(out);
    spent_ += Clock::now() - begin;
  }
  bool step(std::span<const std::int32_t> actions) override {
    const Clock::time_point begin = Clock::now();
    const bool walking = inner_.step(actions);
    spent_ += Clock::now() - begin;
    return walking;
  }

 private:
  Environment& inner_;
  Clock::duration spent_{};
};

// The episodes of several splits as one.
tasks::EpisodeSet join(std::vector<tasks::EpisodeSet> sets) {
  tasks::EpisodeSet all = std::move(sets.front());
  for (std::size_t k = 1; k < sets.size(); ++k) {
    const std::size_t first = all.paths.size();
    all.split += "+" + sets[k].split;
    all.paths.insert(all.paths.end(), sets[k].paths.begin(), sets[k].paths.end());
    for (tasks::Episode& episode : sets[k].episodes) {
      episode.path += first;
      all.episodes.push_back(std::move(episode));
    }
  }
  return all;
}

models::TrainConfig completed(models::TrainConfig config, const TrainingData& data,
                              const tasks::Vocabulary& vocabulary) {
  config.network.vocabulary = vocabulary.size();
  config.network.features =
      config.network.inputs.vision && data.features ? data.features->info().dimensions : 0;
  return config;
}

void require_goals(const tasks::EpisodeSet& episodes) {
  if (!goals_hidden(episodes)) return;
  throw ArgumentError(
      fmt::format("split {}: its goals are hidden, so it cannot be trained on or validated with",
                  episodes.split));
}

// Checks that the model in the directory has this config and data.
void check_same_model(const models::ModelFiles& files, const models::ModelConfig& now,
                      const tasks::Vocabulary& vocabulary) {
  const models::ModelConfig there = models::load_model_config(files.config());
  std::vector<std::string> found = differences(there.training, now.training);
  for (const Diagnostic& one : differences(there.data, now.data, files.config().string())) {
    found.push_back(fmt::format("{}: {}", one.where, one.message));
  }
  if (found.empty() &&
      models::load_vocabulary(files, there.training.network).words() != vocabulary.words()) {
    found.emplace_back("vocabulary.txt: other words than those of the training instructions");
  }
  if (found.empty()) return;
  throw ArgumentError(fmt::format(
      "{}: holds a model that was trained otherwise, so training cannot go on; use another folder "
      "or the same options and data:\n  {}",
      files.folder.string(), fmt::join(found, "\n  ")));
}

class Training {
 public:
  Training(const models::TrainConfig& config, const TrainingData& data, const fs::path& directory,
           const std::string& device, const TrainingListener& listener)
      : data_(data),
        files_{directory},
        listener_(listener),
        vocabulary_(models::training_vocabulary(data.training, config.least_count)),
        model_{completed(config, data, vocabulary_), data.fingerprint},
        lock_((make_folder(directory), files_.lock())),
        network_(model_.training.network, config.seed, device) {}

  bool run() {
    if (fs::exists(files_.config())) {
      check_same_model(files_, model_, vocabulary_);
      load_checkpoint();
      if (iteration_ >= config().iterations) return finish();
    } else {
      vocabulary_.save(files_.vocabulary());
    }
    // After the vocabulary, so that there is no config.json without one. Always written, as the
    // iterations may have changed.
    write_file_atomically(files_.config(), to_json(model_));
    prepare_data();
    R2rEnvironment environment(
        training_->episodes, training_->view_features(),
        {config().batch_size, config().max_steps, config().after_end, config().forward});
    models::TrainingLog log(files_.log(), iteration_);
    log.start(to_json(model_), iteration_);
    begin_ = Clock::now();
    begun_at_ = iteration_;
    while (iteration_ < config().iterations) {
      iterate(environment);
      write_logs(log);
    }
    return true;
  }

 private:
  const models::TrainConfig& config() const { return model_.training; }
  bool is_last() const { return iteration_ == config().iterations; }
  bool is_due(std::size_t every) const {
    return every > 0 && (is_last() || iteration_ % every == 0);
  }
  const features::FeatureSet* features() const {
    return config().network.inputs.vision ? &*data_.features : nullptr;
  }

  void load_checkpoint() {
    const bool newest = fs::exists(files_.checkpoint());
    if (!newest && !fs::exists(files_.previous_checkpoint())) return;
    try {
      const models::StateFile state =
          models::open_state(newest ? files_.checkpoint() : files_.previous_checkpoint());
      network_.load_training_state(state.file);
      iteration_ = state.iteration;
    } catch (const InvalidInput& error) {
      if (!newest || !fs::exists(files_.previous_checkpoint())) throw;
      std::vector<Diagnostic> faults = error.diagnostics();
      faults.push_back({Severity::kError, files_.checkpoint().string(), "", "broken-checkpoint",
                        fmt::format("remove it to go on from the one before, {}",
                                    files_.previous_checkpoint().string())});
      throw InvalidInput(std::move(faults));
    }
    if (listener_.resumed) listener_.resumed(iteration_);
  }

  // The process may have been killed between the last checkpoint and its weights.
  bool finish() {
    if (!fs::exists(files_.weights()) ||
        models::open_state(files_.weights()).iteration != iteration_) {
      models::write_state(files_.weights(), network_.weights().arrays, iteration_);
    }
    return false;
  }

  void prepare_data() {
    const std::size_t words = config().network.max_words;
    training_.emplace(prepare(data_.training, vocabulary_, words, features()));
    if (config().evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : data_.validation) {
        validation_.push_back(prepare(split, vocabulary_, words, features()));
      }
    }
    order_.emplace(data_.training.episodes.size(), config().batch_size, config().seed);
    tokens_.resize(config().batch_size * words);
  }

  void iterate(R2rEnvironment& environment) {
    const Clock::time_point begin = Clock::now();
    const auto episodes = order_->batch(iteration_);
    training_->instructions.gather(episodes, tokens_);
    environment.start(episodes);
    const Clock::duration before = Clock::now() - begin;
    TimedEnvironment timed(environment);
    RolloutOptions rollout{config().feedback, config().max_steps, true, config().seed, iteration_};
    const InstructionBatch batch{tokens_, config().batch_size};
    last_loss_ = network_.rollout_with_gradients(batch, timed, rollout).loss /
                 static_cast<double>(config().max_steps);
    network_.update(config().adam);
    ++iteration_;
    const Clock::duration whole = Clock::now() - begin;
    training_time_ += whole;
    data_time_ += before + timed.spent();
    stretch_.loss += last_loss_;
    stretch_.seconds += seconds(whole);
    ++stretch_length_;
  }

  void write_logs(models::TrainingLog& log) {
    const bool checkpoint = is_last() || iteration_ % config().checkpoint_every == 0;
    if (checkpoint || iteration_ % kLogEvery == 0) write_stretch(log);
    tell();
    if (is_due(config().evaluate_every)) evaluate(log);
    // After the log's lines of this iteration: a continued training cuts off what follows them.
    if (checkpoint) {
      write_checkpoint(files_, network_.training_state().arrays, network_.weights().arrays,
                       iteration_);
    }
  }

  void write_stretch(models::TrainingLog& log) {
    log.add(models::TrainRecord{iteration_, stretch_.loss / static_cast<double>(stretch_length_),
                                stretch_.seconds});
    stretch_ = {};
    stretch_length_ = 0;
  }

  void tell() const {
    if (!listener_.iteration) return;
    const double pace =
        seconds(Clock::now() - begin_) / static_cast<double>(iteration_ - begun_at_);
    listener_.iteration({iteration_, config().iterations, last_loss_,
                         pace * static_cast<double>(config().iterations - iteration_),
                         seconds(data_time_) / seconds(training_time_)});
  }

  void evaluate(models::TrainingLog& log) {
    for (const PreparedSplit& split : validation_) {
      const models::EvaluationRecord record = evaluate(split);
      log.add(record);
      if (listener_.evaluation) listener_.evaluation(record);
    }
  }

  models::EvaluationRecord evaluate(const PreparedSplit& split) {
    const std::string& name = split.episodes.split;
    const WalkOptions walk_options{config().batch_size, config().max_steps};
    // Other random numbers than training's; streams apart from those of other iterations.
    const std::uint64_t seed = config().seed ^ stream_of(name.data(), name.size());
    const LossOptions loss{walk_options,
                           {config().feedback, config().max_steps, true, seed, iteration_ << 20U},
                           config().after_end,
                           config().forward};
    models::EvaluationRecord record{iteration_, name, split.episodes.episodes.size(),
                                    compute_loss(network_, split, loss)};
    const GreedyWalk walk = walk_greedily(network_, split, walk_options);
    write_walk(files_.results(name), files_.attention(name), walk, split, vocabulary_);
    tasks::ScoreOptions options;
    options.bootstrap_samples = 0;
    const tasks::Score score = compute_score(walk.trajectories, split.episodes, options);
    record.trajectory_length = score.mean("trajectory_length").mean;
    record.nav_error = score.mean("nav_error").mean;
    record.success_rate = score.mean("success").mean;
    record.oracle_success_rate = score.mean("oracle_success").mean;
    record.spl = score.mean("spl").mean;
    return record;
  }

  const TrainingData& data_;
  models::ModelFiles files_;
  const TrainingListener& listener_;
  tasks::Vocabulary vocabulary_;
  models::ModelConfig model_;
  models::FolderLock lock_;
  Network network_;
  std::optional<PreparedSplit> training_;
  std::vector<PreparedSplit> validation_;
  std::optional<detail::EpisodeOrder> order_;
  std::vector<std::uint32_t> tokens_;
  std::uint64_t iteration_ = 0;  // done
  std::uint64_t begun_at_ = 0;
  double last_loss_ = 0;
  Clock::time_point begin_;
  Clock::duration training_time_{}, data_time_{};
  models::TrainRecord stretch_;  // sums since the last line of the log
  std::uint64_t stretch_length_ = 0;
};

}  // namespace

TrainingData load_training_data(const dataset::Dataset& dataset, const models::TrainConfig& config,
                                const std::optional<fs::path>& features) {
  TrainingData data;
  if (config.network.inputs.vision) {
    if (!features) throw ArgumentError("the agent is to see, so it needs features");
    data.features = features::FeatureSet::open(*features);
    data.fingerprint.features = data.features->info();
  }
  const auto load = [&](const std::string& split, tasks::Instructions instructions) {
    const tasks::Annotations annotations = dataset.annotations(split);
    tasks::EpisodeSet episodes = make_episodes(annotations, dataset.graphs(), instructions);
    require_goals(episodes);
    data.fingerprint.add(annotations);
    data.fingerprint.add_graphs(episodes);
    return episodes;
  };
  std::vector<tasks::EpisodeSet> training;
  for (const std::string& split : config.splits) {
    training.push_back(load(split, tasks::Instructions::kAll));
  }
  data.training = join(std::move(training));
  for (const std::string& split : config.validation) {
    data.validation.push_back(load(split, tasks::Instructions::kScored));
  }
  return data;
}

bool train(const models::TrainConfig& config, const TrainingData& data, const fs::path& directory,
           const std::string& device, const TrainingListener& listener) {
  validate(config);
  if (config.network.inputs.vision && !data.features) {
    throw ArgumentError("the agent is to see, so it needs features");
  }
  if (data.training.episodes.empty()) {
    throw ArgumentError(fmt::format("split {}: no episode to train on", data.training.split));
  }
  return Training(config, data, directory, device, listener).run();
}

}  // namespace enfilade::neural
