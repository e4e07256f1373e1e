#include "enfilade/neural/evaluation.h"

#include <algorithm>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/models/attention.h"
#include "enfilade/models/decision_recorder.h"
#include "enfilade/neural/detail/batches.h"

namespace enfilade::neural {
namespace {

constexpr auto kEnd = static_cast<std::int32_t>(SixAction::kStop);

// Calls body(environment, instructions, index of the batch's first episode) for each batch of a
// split, in its order; the last batch may be smaller.
template <class Body>
void for_each_batch(const PreparedSplit& split, R2rEnvironmentConfig config, const Body& body) {
  std::optional<R2rEnvironment> environment;
  std::vector<std::uint32_t> tokens;
  detail::for_each_batch(
      split.episodes.episodes.size(), config.batch_size,
      [&](std::span<const std::size_t> episodes) {
        config.batch_size = episodes.size();
        tokens.resize(config.batch_size * split.instructions.max_words());
        split.instructions.gather(episodes, tokens);
        if (!environment || environment->size() != config.batch_size) {
          environment.emplace(split.episodes, split.view_features(), config);
        }
        environment->start(episodes);
        body(*environment, InstructionBatch{tokens, config.batch_size}, episodes.front());
      });
}

models::EpisodeAttention episode_attention(const GreedyWalk& walk, std::size_t i,
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
  std::optional<ViewFeatures> views;
  if (features != nullptr) views.emplace(*features, episodes);
  return {std::move(episodes), std::move(instructions), std::move(views)};
}

GreedyWalk walk_greedily(Network& network, const PreparedSplit& split, const WalkOptions& options,
                         const Progress& progress) {
  const std::size_t total = split.episodes.episodes.size();
  GreedyWalk walk;
  walk.trajectories.reserve(total);
  walk.traces.resize(total);
  const auto words_of = [&](const StepRecord& step, std::size_t episode) {
    if (!network.config().inputs.language) return std::size_t{0};
    return std::min(step.words, models::word_count(split.instructions.row(episode)));
  };
  for_each_batch(
      split, {options.batch_size, options.max_steps, models::AfterEnd::kStays},
      [&](R2rEnvironment& environment, const InstructionBatch& instructions, std::size_t first) {
        const auto observe = [&](const StepRecord& step) {
          for (std::size_t i = 0; i < step.actions.size(); ++i) {
            AttentionTrace& trace = walk.traces[first + i];
            if (!trace.actions.empty() && trace.actions.back() == kEnd) continue;
            trace.actions.push_back(step.actions[i]);
            const auto row = step.attention.subspan(i * step.words, words_of(step, first + i));
            trace.attention.emplace_back(row.begin(), row.end());
          }
        };
        network.rollout(instructions, environment, {models::Feedback::kArgmax, options.max_steps},
                        observe);
        const auto walked = environment.trajectories();
        walk.trajectories.insert(walk.trajectories.end(), walked.begin(), walked.end());
        if (progress) progress(walk.trajectories.size(), total);
      });
  return walk;
}

double compute_loss(Network& network, const PreparedSplit& split, const LossOptions& options) {
  RolloutOptions rollout = options.rollout;
  rollout.max_steps = options.walk.max_steps;
  double sum = 0;
  for_each_batch(
      split, {options.walk.batch_size, options.walk.max_steps, options.after_end, options.forward},
      [&](R2rEnvironment& environment, const InstructionBatch& instructions, std::size_t) {
        sum += network.rollout(instructions, environment, rollout).loss *
               static_cast<double>(instructions.size);
        ++rollout.stream;
      });
  const std::size_t total = split.episodes.episodes.size();
  return sum / static_cast<double>(total * rollout.max_steps);
}

void write_walk(const std::filesystem::path& results, const std::filesystem::path& attention,
                const GreedyWalk& walk, const PreparedSplit& split,
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

}  // namespace enfilade::neural
