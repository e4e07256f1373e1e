#include "enfilade/neural/train.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/part_file.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/neural/continuous_agent.h"
#include "enfilade/neural/core/learner.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::neural {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kLogEvery = 10;  // iterations a line of training loss

double seconds_of(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

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

// body() of the data, on graphs or in continuous space.
template <class Body>
auto visit(const TrainingData& data, const Body& body) {
  const ContinuousData* const continuous = data.continuous();
  return continuous != nullptr ? body(*continuous) : body(data.graph());
}

const std::string& text_of(const tasks::Episode& episode) { return episode.text; }
const std::string& text_of(const tasks::ContinuousEpisode& episode) {
  return episode.instruction.text;
}

[[noreturn]] void refuse_origin(const models::ModelFiles& files,
                                const std::vector<std::string>& differ) {
  throw ArgumentError(fmt::format("{}: training cannot begin with the weights of this model:\n  {}",
                                  files.folder.string(), fmt::join(differ, "\n  ")));
}

// The model that a training begins with.
struct Origin {
  models::ModelFiles files;
  models::TrainConfig config;
  models::StateFile state;

  fs::path text() const { return files.text(config.text); }
};

std::optional<Origin> open_origin(const models::TrainConfig& config,
                                  const std::optional<fs::path>& folder) {
  if (!folder) return std::nullopt;
  if (config.agent != models::AgentKind::kDuet) {
    throw ArgumentError(fmt::format("the agent {} begins with random weights alone, not with {}",
                                    to_string(config.agent), folder->string()));
  }
  models::ModelFiles files = models::require_model(*folder);
  models::TrainConfig there = models::load_model_config(files.config()).training;
  if (there.agent != config.agent) refuse_origin(files, size_differences(there, config));
  return Origin{files, std::move(there), models::open_state(files.weights())};
}

models::InstructionWords words_of(const models::TrainConfig& config, const TrainingData& data,
                                  const std::optional<Origin>& origin) {
  if (origin) return models::load_instruction_words(origin->files, origin->config);
  return models::InstructionWords(
      tasks::Vocabulary::build(visit(data,
                                     [](const auto& own) {
                                       std::vector<std::string> texts;
                                       for (const auto& episode : own.training.episodes)
                                         texts.push_back(text_of(episode));
                                       return texts;
                                     }),
                               config.least_count));
}

models::TrainConfig completed(models::TrainConfig config, const TrainingData& data,
                              const models::InstructionWords& words,
                              const std::optional<Origin>& origin) {
  const tasks::Vocabulary* const vocabulary = words.vocabulary();
  config.network.vocabulary = vocabulary != nullptr ? vocabulary->size() : words.size();
  const auto& features = data.fingerprint.features;
  config.network.features = config.network.inputs.vision && features ? features->dimensions : 0;
  if (config.agent == models::AgentKind::kSeq2SeqCe) {
    fix_updates(config, data.continuous()->training.episodes.size());
  }
  if (!origin) return config;
  config.text = origin->config.text;
  config.letters = origin->config.letters;
  config.initial_weights = origin->state.file.metadata().at("hash");
  const std::vector<std::string> differ = size_differences(origin->config, config);
  if (!differ.empty()) refuse_origin(origin->files, differ);
  return config;
}

// Checks that the model in the directory has this config and data.
void check_same_model(const models::ModelFiles& files, const models::ModelConfig& now,
                      const models::InstructionWords& words) {
  const models::ModelConfig there = models::load_model_config(files.config());
  std::vector<std::string> found = differences(there.training, now.training);
  for (const Diagnostic& one : differences(there.data, now.data, files.config().string())) {
    found.push_back(fmt::format("{}: {}", one.where, one.message));
  }
  const tasks::Vocabulary* const vocabulary = words.vocabulary();
  if (found.empty() && vocabulary != nullptr &&
      models::load_vocabulary(files, there.training.network).words() != vocabulary->words()) {
    found.emplace_back("vocabulary.txt: other words than those of the training instructions");
  }
  if (found.empty()) return;
  throw ArgumentError(fmt::format(
      "{}: holds a model that was trained otherwise, so training cannot go on; use another folder "
      "or the same options and data:\n  {}",
      files.folder.string(), fmt::join(found, "\n  ")));
}

std::unique_ptr<core::Learner> make_learner(const core::LearnerParts& parts) {
  using models::AgentKind;
  const AgentKind agent = parts.config.agent;
  if (agent == AgentKind::kDuet) {
    return parts.config.stage == models::Stage::kPretrain ? core::make_pretraining_learner(parts)
                                                          : core::make_duet_learner(parts);
  }
  if (agent == AgentKind::kSeq2Seq) return core::make_seq2seq_learner(parts);
  if (agent == AgentKind::kSeq2SeqCe) return core::make_continuous_learner(parts);
  return agent == AgentKind::kSpeaker ? core::make_speaker_learner(parts)
                                      : core::make_panoramic_learner(parts);
}

void check(const Computing& computing, models::AgentKind agent) {
  if (computing.precision == Precision::kFloat32) return;
  if (computing.device == "cpu") {
    throw ArgumentError(
        fmt::format("precision {}: the CPU computes in float32 alone; cards have it",
                    enum_name(computing.precision)));
  }
  const bool own_gradients =
      agent == models::AgentKind::kSeq2Seq || agent == models::AgentKind::kSeq2SeqCe;
  if (own_gradients && computing.precision == Precision::kBfloat16) {
    throw ArgumentError(fmt::format(
        "precision bfloat16: the agent {} is trained in float32 or tf32", to_string(agent)));
  }
}

class Training {
 public:
  Training(const models::TrainConfig& config, const TrainingData& data, const fs::path& directory,
           const Computing& computing, const TrainingListener& listener,
           const std::optional<fs::path>& from)
      : data_(data),
        device_kind_(computing.device.substr(0, computing.device.find(':'))),
        precision_(computing.precision),
        files_{directory},
        listener_(listener),
        origin_(open_origin(config, from)),
        words_(words_of(config, data, origin_)),
        model_{completed(config, data, words_, origin_), data.fingerprint},
        ranks_(computing.ranks != nullptr ? *computing.ranks : alone_),
        lock_(lock()),
        learner_(make_learner({model_.training, words_, core::open_agents_device(computing.device),
                               files_, listener.gathering})) {}

  bool run() {
    if (ranks_.is_first()) remove_left();
    if (!ranks_.alone()) ranks_.agree(facts());
    if (fs::exists(files_.config())) {
      check_same_model(files_, model_, words_);
      load_checkpoint();
    }
    if (iteration_ == 0 && origin_) learner_->begin_with(origin_->state.file);
    // Nobody has written yet: all have seen the same, or say so.
    agree_on_state();
    if (iteration_ >= config().iterations) return finish();
    learner_->prepare(data_, ranks_);
    std::optional<models::TrainingLog> log;
    if (ranks_.is_first()) {
      save_model();
      log.emplace(files_.log(), iteration_);
      log->start(to_json(model_), iteration_);
    }
    begin_ = Clock::now();
    begun_at_ = iteration_;
    while (iteration_ < config().iterations) {
      iterate();
      write_logs(log);
    }
    return true;
  }

 private:
  const models::TrainConfig& config() const { return model_.training; }
  // One process writes; the others would wait for each other's lock.
  std::optional<FolderLock> lock() const {
    if (!ranks_.is_first()) return std::nullopt;
    make_folder(files_.folder);
    return std::optional<FolderLock>(std::in_place, files_.lock());
  }

  // What killed runs left. The lock is held.
  void remove_left() const {
    const OutputFolder out(files_.folder);
    for (const char* folder : {"", "results"}) out.remove_unfinished(folder);
  }

  // By field, so that what differs is named.
  RankFacts facts() const {
    RankFacts facts{{"--device", device_kind_},
                    {"--precision", std::string(enum_name(precision_))}};
    const nlohmann::json fields = nlohmann::json::parse(to_json(model_)).flatten();
    for (const auto& [path, value] : fields.items()) {
      facts[path] = value.dump();
    }
    return facts;
  }

  void agree_on_state() {
    if (ranks_.alone()) return;
    ranks_.agree({{fmt::format("{}: iteration of the checkpoint", files_.folder.string()),
                   std::to_string(iteration_)},
                  {"weights", hash_of_weights()}});
  }

  // Processes that computed otherwise would drift apart.
  std::string hash_of_weights() const {
    std::size_t hash = 0;
    const core::SavedState state = learner_->weights();
    for (const features::NamedArray& array : state.arrays) {
      const std::string_view bytes(reinterpret_cast<const char*>(array.bytes.data()),
                                   array.bytes.size());
      hash = 31 * hash + std::hash<std::string_view>{}(bytes);
    }
    return fmt::format("{:016x}", hash);
  }

  void save_model() const {
    if (!fs::exists(files_.config())) {
      save_words();
      if (data_.continuous() != nullptr && config().network.inputs.vision) save_encoder();
    }
    // After the vocabulary, so that there is no config.json without one. Always written, as the
    // iterations may have changed.
    write_file(files_, files_.config(), to_json(model_));
  }

  void save_words() const {
    if (words_.vocabulary() != nullptr) return words_.vocabulary()->save(files_.vocabulary());
    write_file(files_, files_.text(config().text), read_file(origin_->text()));
  }
  void save_encoder() const {
    const fs::path& weights = data_.continuous()->sight.encoder.weights;
    if (!weights.empty()) write_file(files_, files_.encoder(), read_file(weights));
  }
  bool is_last() const { return iteration_ == config().iterations; }
  bool is_due(std::size_t every) const {
    return every > 0 && (is_last() || iteration_ % every == 0);
  }

  void load_checkpoint() {
    const bool newest = fs::exists(files_.checkpoint());
    if (!newest && !fs::exists(files_.previous_checkpoint())) return;
    try {
      const models::StateFile state =
          models::open_state(newest ? files_.checkpoint() : files_.previous_checkpoint());
      learner_->load_training_state(state.file);
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
    if (!ranks_.is_first()) return false;
    if (!fs::exists(files_.weights()) ||
        models::open_state(files_.weights()).iteration != iteration_) {
      models::write_state(files_.weights(), learner_->weights().arrays, iteration_);
    }
    return false;
  }

  void iterate() {
    const Clock::time_point begin = Clock::now();
    const core::Update update = [this] {
      const core::PrecisionGuard guard(precision_);
      return learner_->update(iteration_);
    }();
    ++iteration_;
    const double whole = seconds_of(Clock::now() - begin);
    last_loss_ = update.loss;
    training_seconds_ += whole;
    data_seconds_ += update.data_seconds;
    stretch_.loss += last_loss_;
    stretch_.seconds += whole;
    ++stretch_length_;
  }

  // \param log of rank 0
  void write_logs(std::optional<models::TrainingLog>& log) {
    const bool checkpoint = is_last() || iteration_ % config().checkpoint_every == 0;
    if (log && (checkpoint || iteration_ % kLogEvery == 0)) write_stretch(*log);
    tell();
    if (is_due(config().evaluate_every)) evaluate(log);
    if (!checkpoint) return;
    agree_on_state();
    // After the log's lines of this iteration: a continued training cuts off what follows them.
    if (log) {
      write_checkpoint(files_, learner_->training_state().arrays, learner_->weights().arrays,
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
        seconds_of(Clock::now() - begin_) / static_cast<double>(iteration_ - begun_at_);
    listener_.iteration({iteration_, config().iterations, last_loss_,
                         pace * static_cast<double>(config().iterations - iteration_),
                         data_seconds_ / training_seconds_});
  }

  void evaluate(std::optional<models::TrainingLog>& log) {
    const std::size_t splits = visit(data_, [](const auto& own) { return own.validation.size(); });
    for (std::size_t k = 0; k < splits; ++k) {
      core::Evaluated evaluated = learner_->evaluate(k, iteration_, files_);
      if (!log) continue;
      if (auto* const speaker = std::get_if<models::SpeakerRecord>(&evaluated)) {
        speaker->iteration = iteration_;
        log->add(*speaker);
        if (listener_.speaker) listener_.speaker(*speaker);
      } else {
        auto* const free = std::get_if<models::EvaluationRecord>(&evaluated);
        if (free != nullptr) free->iteration = iteration_;
        const models::EvaluationRecord record =
            free != nullptr ? *free
                            : record_of(std::get<core::ValidationRollout>(evaluated),
                                        data_.graph().validation[k]);
        log->add(record);
        if (listener_.evaluation) listener_.evaluation(record);
      }
    }
  }

  models::EvaluationRecord record_of(const core::ValidationRollout& walked,
                                     const tasks::EpisodeSet& split) const {
    models::EvaluationRecord record{iteration_, split.split, split.episodes.size(), walked.loss};
    tasks::ScoreOptions options;
    options.bootstrap_samples = 0;
    const tasks::ScoreTable score =
        compute_score(walked.trajectories, split, tasks::own_scorer(), options);
    record.trajectory_length = score.mean("trajectory_length").mean;
    record.nav_error = score.mean("nav_error").mean;
    record.success_rate = score.mean("success").mean;
    record.oracle_success_rate = score.mean("oracle_success").mean;
    record.spl = score.mean("spl").mean;
    return record;
  }

  const TrainingData& data_;
  std::string device_kind_;  // "cpu" or "cuda"
  Precision precision_;
  models::ModelFiles files_;
  const TrainingListener& listener_;
  std::optional<Origin> origin_;
  models::InstructionWords words_;
  models::ModelConfig model_;
  Ranks alone_;
  Ranks& ranks_;
  std::optional<FolderLock> lock_;  // of rank 0
  std::unique_ptr<core::Learner> learner_;
  std::uint64_t iteration_ = 0;  // done
  std::uint64_t begun_at_ = 0;
  double last_loss_ = 0;
  Clock::time_point begin_;
  double training_seconds_ = 0, data_seconds_ = 0;
  models::TrainRecord stretch_;  // sums since the last line of the log
  std::uint64_t stretch_length_ = 0;
};

}  // namespace

TrainingData load_training_data(const dataset::Dataset& dataset, const models::TrainConfig& config,
                                const std::optional<fs::path>& features) {
  TrainingData data;
  GraphData& own = data.graph();
  if (config.network.inputs.vision) {
    if (!features) throw ArgumentError("the agent is to see, so it needs features");
    own.features = features::FeatureSet::open(*features);
    data.fingerprint.features = own.features->info();
  }
  const auto load = [&](const std::string& split, tasks::Instructions instructions) {
    const tasks::Annotations annotations = dataset.annotations(split);
    tasks::EpisodeSet episodes = make_episodes(annotations, dataset.graphs(), instructions);
    core::require_goals(episodes);
    data.fingerprint.add(annotations);
    data.fingerprint.add_graphs(episodes);
    return episodes;
  };
  std::vector<tasks::EpisodeSet> training;
  for (const std::string& split : config.splits) {
    training.push_back(load(split, tasks::Instructions::kAll));
  }
  own.training = join(std::move(training));
  if (config.buildings) {
    tasks::EpisodeSet& set = own.training;
    core::keep_buildings(set, set.paths, *config.buildings, [&](const auto& one) {
      if constexpr (requires { one.scan; })
        return one.scan;
      else
        return set.path_of(one).scan;
    });
  }
  for (const std::string& split : config.validation) {
    own.validation.push_back(load(split, tasks::Instructions::kScored));
  }
  return data;
}

bool train(const models::TrainConfig& config, const TrainingData& data, const fs::path& directory,
           const Computing& computing, const TrainingListener& listener,
           const std::optional<fs::path>& from) {
  validate(config);
  check(computing, config.agent);
  const bool free = config.agent == models::AgentKind::kSeq2SeqCe;
  if (free != (data.continuous() != nullptr)) {
    throw ArgumentError(
        fmt::format("the agent {} is for {}; the data is for the other kind of environment",
                    to_string(config.agent), free ? "continuous environments" : "graphs"));
  }
  const bool sees = data.fingerprint.features && (free || data.graph().features);
  if (config.network.inputs.vision && !sees) {
    throw ArgumentError("the agent is to see, so it needs features");
  }
  visit(data, [](const auto& own) {
    if (!own.training.episodes.empty()) return;
    throw ArgumentError(fmt::format("split {}: no episode to train on", own.training.split));
  });
  return Training(config, data, directory, computing, listener, from).run();
}

}  // namespace enfilade::neural
