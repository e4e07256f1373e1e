#include "enfilade/neural/seq2seq/evaluation.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/agents/simple_agents.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/models/decisions.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::neural::seq2seq {
namespace {

constexpr auto kEnd = static_cast<std::int32_t>(SixAction::kStop);

// Calls body(environment, instructions, index of the batch's first episode) for each batch of a
// split, as share_batches(); the last batch may be smaller.
template <class Body>
std::vector<std::string> share_batches(Ranks* ranks, const PreparedSplit& split,
                                       R2rEnvironmentConfig config, const Body& body) {
  Ranks alone;
  std::optional<R2rEnvironment> environment;
  std::vector<std::uint32_t> tokens;
  return core::share_batches(
      ranks != nullptr ? *ranks : alone, split.episodes.episodes.size(), config.batch_size,
      [&](std::span<const std::size_t> episodes) {
        config.batch_size = episodes.size();
        tokens.resize(config.batch_size * split.instructions.max_words());
        split.instructions.gather(episodes, tokens);
        if (!environment || environment->size() != config.batch_size) {
          environment.emplace(split.episodes, split.view_features(), config);
        }
        environment->start(episodes);
        return body(*environment, InstructionBatch{tokens, config.batch_size}, episodes.front());
      });
}

models::EpisodeAttention episode_attention(const GreedyRollout& walk, std::size_t i,
                                           const PreparedSplit& split,
                                           const tasks::Vocabulary& vocabulary) {
  const models::ReadingOrder order = models::reading_order(split.instructions.row(i), vocabulary);
  const graph::NavGraph& graph = split.episodes.graph_of(split.episodes.episodes[i]);
  const AttentionTrace& trace = walk.traces[i];
  models::EpisodeAttention episode{order.words, {}};
  for (std::size_t step = 0; step < trace.actions.size(); ++step) {
    const tasks::TrajectoryPoint& point = walk.trajectories[i].points.at(step);
    const std::vector<float>& row = trace.attention[step];
    std::vector<double> attention;
    for (const std::size_t place : order.places) {
      attention.push_back(place < row.size() ? row[place] : 0);
    }
    const auto action = static_cast<SixAction>(trace.actions[step]);
    episode.steps.push_back({std::string(to_string(action)), std::move(attention),
                             graph.id(point.viewpoint), point.heading.value,
                             point.elevation.value});
  }
  return episode;
}

using models::AfterEnd;
using models::ForwardTo;

sim::SimulatorConfig simulator_config(const R2rEnvironmentConfig& config) {
  sim::SimulatorConfig simulator = sim::SimulatorConfig::room_to_room();
  simulator.batch_size = config.batch_size;  // which the simulator checks
  return simulator;
}

}  // namespace

PreparedSplit prepare(tasks::EpisodeSet episodes, const tasks::Vocabulary& vocabulary,
                      std::size_t max_words, const features::FeatureSet* features) {
  models::EncodedInstructions instructions(episodes, vocabulary, max_words);
  std::optional<core::ViewFeatures> views;
  if (features != nullptr) views.emplace(*features, episodes);
  return {std::move(episodes), std::move(instructions), std::move(views)};
}

GreedyRollout rollout_greedily(Network& network, const PreparedSplit& split,
                               const BatchOptions& options, const Progress& progress) {
  const std::size_t total = split.episodes.episodes.size();
  const std::size_t processes =
      options.ranks != nullptr ? static_cast<std::size_t>(options.ranks->size()) : 1;
  std::size_t walked = 0;
  const auto words_of = [&](const StepRecord& step, std::size_t episode) {
    if (!network.config().inputs.language) return std::size_t{0};
    return std::min(step.words, models::word_count(split.instructions.row(episode)));
  };
  const auto batches = share_batches(
      options.ranks, split, {options.batch_size, options.max_steps, models::AfterEnd::kStays},
      [&](R2rEnvironment& environment, const InstructionBatch& instructions, std::size_t first) {
        std::vector<AttentionTrace> traces(instructions.size);
        const auto observe = [&](const StepRecord& step) {
          for (std::size_t i = 0; i < step.actions.size(); ++i) {
            AttentionTrace& trace = traces[i];
            if (!trace.actions.empty() && trace.actions.back() == kEnd) continue;
            trace.actions.push_back(step.actions[i]);
            const auto row = step.attention.subspan(i * step.words, words_of(step, first + i));
            trace.attention.emplace_back(row.begin(), row.end());
          }
        };
        network.rollout(instructions, environment, {models::Feedback::kArgmax, options.max_steps},
                        observe);
        walked += instructions.size;
        if (progress) progress(std::min(total, walked * processes), total);
        core::ValuePacker packer;
        packer.add(core::packed_trajectories(environment.trajectories()));
        for (const AttentionTrace& trace : traces) {
          packer.add(trace.actions);
          packer.add(trace.attention);
        }
        return packer.take();
      });
  GreedyRollout walk;
  for (const std::string& batch : batches) {
    core::Unpacker unpacker(batch);
    const auto trajectories = unpacker.get<std::string>();
    for (tasks::Trajectory& one : core::unpacked_trajectories({&trajectories, 1})) {
      walk.trajectories.push_back(std::move(one));
    }
    while (!unpacker.done()) {
      AttentionTrace& trace = walk.traces.emplace_back();
      unpacker.read(trace.actions);
      unpacker.read(trace.attention);
    }
  }
  return walk;
}

double compute_loss(Network& network, const PreparedSplit& split, const LossOptions& options) {
  double sum = 0;
  const auto losses = share_batches(
      options.batches.ranks, split,
      {options.batches.batch_size, options.batches.max_steps, options.after_end, options.forward},
      [&](R2rEnvironment& environment, const InstructionBatch& instructions, std::size_t first) {
        RolloutOptions rollout = options.rollout;
        rollout.max_steps = options.batches.max_steps;
        rollout.stream += first / options.batches.batch_size;
        return core::packed(network.rollout(instructions, environment, rollout).loss *
                            static_cast<double>(instructions.size));
      });
  for (const std::string& one : losses) sum += core::unpacked<double>(one);
  const std::size_t total = split.episodes.episodes.size();
  return sum / static_cast<double>(total * options.batches.max_steps);
}

void write_rollout(const SplitRollout& files, const GreedyRollout& walk, const PreparedSplit& split,
                   const tasks::Vocabulary& vocabulary, std::size_t attention_episodes) {
  files.write(files.results, to_json(walk.trajectories, split.episodes));
  if (files.attention.empty()) return;
  std::vector<std::pair<std::string, models::EpisodeAttention>> shown;
  for (const std::size_t i :
       models::shown_episodes(walk.trajectories, split.episodes, attention_episodes)) {
    shown.emplace_back(split.episodes.episodes[i].instruction_id,
                       episode_attention(walk, i, split, vocabulary));
  }
  files.write(files.attention, models::attention_json(shown));
}

R2rEnvironment::R2rEnvironment(const tasks::EpisodeSet& episodes,
                               const core::ViewFeatures* features,
                               const R2rEnvironmentConfig& config)
    : features_(features),
      config_(config),
      has_teacher_(!goals_hidden(episodes)),
      batch_(episodes, simulator_config(config), config.max_steps),
      actions_(config.batch_size) {
  if (config.forward == ForwardTo::kIntended && !has_teacher_) {
    throw ArgumentError(fmt::format(
        "forward to the intended neighbour: the goals of split {} are hidden", episodes.split));
  }
}

std::size_t R2rEnvironment::dimensions() const {
  return features_ == nullptr ? 0 : features_->dimensions();
}

void R2rEnvironment::start(std::span<const std::size_t> episodes) {
  batch_.begin(episodes);
  if (!has_teacher_) return;
  // The first use computes shortest paths, which would slow down a step.
  for (std::size_t i = 0; i < size(); ++i) (void)batch_.distance_to_goal(i);
}

void R2rEnvironment::observe(const EnvironmentView& out) {
  const sim::StateSpans& now = batch_.state();
  const std::size_t n = dimensions();
  for (std::size_t i = 0; i < size(); ++i) {
    if (n > 0) {
      features_->copy(now.scan[i], now.viewpoint[i], now.view_index[i],
                      out.features.subspan(i * n, n));
    }
    out.forward_open[i] = now.navigable_count[i] > 1 ? 1 : 0;
    if (!out.labels.empty()) out.labels[i] = label(i);
  }
}

bool R2rEnvironment::step(std::span<const std::int32_t> actions) {
  EN_CHECK_EQ(actions.size(), size());
  for (std::size_t i = 0; i < size(); ++i) {
    if (batch_.ended(i) && config_.after_end == AfterEnd::kStays) {
      actions_[i] = {};
      continue;
    }
    actions_[i] = action_of(i, actions[i]);
    if (actions[i] == static_cast<std::int32_t>(SixAction::kStop)) batch_.end(i);
  }
  batch_.step(actions_);
  return batch_.running() > 0;
}

agents::Decision R2rEnvironment::teacher(std::size_t slot) const {
  return agents::teacher_decision(batch_.observation(slot), batch_.path(slot).viewpoints.back());
}

std::int32_t R2rEnvironment::label(std::size_t slot) const {
  const bool ended = batch_.ended(slot);
  if (ended && config_.after_end == AfterEnd::kStays) return kIgnoreLabel;
  const SixAction action = six_action_of(teacher(slot));
  if (ended && action == SixAction::kStop) return kIgnoreLabel;
  return static_cast<std::int32_t>(action);
}

sim::Action R2rEnvironment::action_of(std::size_t slot, std::int32_t action) const {
  // Numbers that are no action leave the agent where it is, as `end` does.
  const bool known = action >= 0 && action < kSixActionCount;
  const auto one_of_six = known ? static_cast<SixAction>(action) : SixAction::kStop;
  const sim::Action done = to_action(one_of_six, batch_.state().navigable_count[slot]);
  if (done.index > 0 && config_.forward == ForwardTo::kIntended) {
    const agents::Decision decision = teacher(slot);
    if (decision.index > 0) return {decision.index, {}, {}};
  }
  return done;
}

namespace fs = std::filesystem;

Model load_model(const fs::path& folder, const std::string& device) {
  const models::ModelFiles files = models::require_model(folder);
  models::ModelConfig config = models::load_model_config(files.config());
  if (config.training.agent != models::AgentKind::kSeq2Seq) {
    throw ArgumentError(fmt::format("{}: an agent {}, not seq2seq", folder.string(),
                                    to_string(config.training.agent)));
  }
  tasks::Vocabulary vocabulary = models::load_vocabulary(files, config.training.network);
  const models::StateFile state = models::open_state(files.weights());
  auto network = std::make_unique<Network>(config.training.network, config.training.seed, device);
  network->load_weights(state.file);
  return {std::move(config), std::move(vocabulary), state.iteration, std::move(network)};
}

void Seq2SeqAgent::enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) {
  split_.emplace(prepare(episodes, model_.vocabulary, model_.config.training.network.max_words,
                         usable_features(model_.config, features)));
}

std::vector<tasks::Trajectory> Seq2SeqAgent::walk(const SplitRollout& options,
                                                  const Progress& progress) {
  GreedyRollout walk = rollout_greedily(
      *model_.network, *split_,
      {options.batch_size, model_.config.training.max_steps, options.ranks}, progress);
  if (!options.results.empty() && (options.ranks == nullptr || options.ranks->is_first())) {
    write_rollout(options, walk, *split_, model_.vocabulary);
  }
  return std::move(walk.trajectories);
}

void Seq2SeqAgent::start(std::span<const agents::Observation> batch) {
  const std::size_t words = model_.config.training.network.max_words;
  std::vector<std::uint32_t> tokens;
  tokens.reserve(batch.size() * words);
  scans_.clear();
  for (const agents::Observation& seen : batch) {
    const auto row = model_.vocabulary.encode(seen.episode->text, words);
    tokens.insert(tokens.end(), row.begin(), row.end());
    if (features() != nullptr) scans_.push_back(features()->scan(seen.graph->scan()));
  }
  seen_.resize(batch.size() * model_.config.training.network.features);
  forward_open_.resize(batch.size());
  actions_.resize(batch.size());
  model_.network->begin({tokens, batch.size()}, model_.config.training.max_steps);
}

void Seq2SeqAgent::act(std::span<const agents::Observation> batch,
                       std::span<agents::Decision> decisions) {
  // Stops the agents that have not chosen `end` yet: all episodes began at the same time.
  if (!batch.empty() && batch[0].step >= model_.config.training.max_steps) {
    std::ranges::fill(decisions, agents::Decision::stop_here());
    return;
  }
  for (std::size_t i = 0; i < batch.size(); ++i) {
    forward_open_[i] = batch[i].navigable.size() > 1 ? 1 : 0;
    if (features() == nullptr) continue;
    const std::size_t n = features()->dimensions();
    features()->copy(scans_[i], batch[i].viewpoint, batch[i].view_index,
                     std::span(seen_).subspan(i * n, n));
  }
  model_.network->act(seen_, forward_open_, actions_);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const auto count = static_cast<std::uint32_t>(batch[i].navigable.size());
    decisions[i] = to_decision(static_cast<SixAction>(actions_[i]), count);
  }
}

}  // namespace enfilade::neural::seq2seq
