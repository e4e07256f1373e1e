#include "enfilade/neural/seq2seq/evaluation.h"

#include <algorithm>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/models/attention.h"
#include "enfilade/models/decision_recorder.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/split_rollout.h"

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
        core::Packer packer;
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

void write_rollout(const std::filesystem::path& results, const std::filesystem::path& attention,
                   const GreedyRollout& walk, const PreparedSplit& split,
                   const tasks::Vocabulary& vocabulary, std::size_t attention_episodes) {
  make_folder(results.parent_path());
  write_file_atomically(results, to_json(walk.trajectories, split.episodes));
  if (attention.empty()) return;
  make_folder(attention.parent_path());
  std::vector<std::pair<std::string, models::EpisodeAttention>> shown;
  for (const std::size_t i :
       models::shown_episodes(walk.trajectories, split.episodes, attention_episodes)) {
    shown.emplace_back(split.episodes.episodes[i].instruction_id,
                       episode_attention(walk, i, split, vocabulary));
  }
  write_file_atomically(attention, models::attention_json(shown));
}

}  // namespace enfilade::neural::seq2seq
