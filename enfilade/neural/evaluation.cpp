#include "enfilade/neural/evaluation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/attention.h"

namespace enfilade::neural {
namespace {

constexpr auto kEnd = static_cast<std::int32_t>(SixAction::kStop);

// Walks through a split batch by batch, in its order; the last batch may be smaller.
class Batches {
 public:
  Batches(const PreparedSplit& split, const R2rEnvironmentConfig& config)
      : split_(split), config_(config) {}

  // body(environment, instructions, index of the batch's first episode)
  template <class Body>
  void for_each(const Body& body) {
    const std::size_t total = split_.episodes.episodes.size();
    std::optional<R2rEnvironment> environment;
    for (std::size_t first = 0; first < total; first += config_.batch_size) {
      const std::size_t n = std::min(config_.batch_size, total - first);
      episodes_.resize(n);
      std::iota(episodes_.begin(), episodes_.end(), first);
      tokens_.resize(n * split_.instructions.max_words());
      split_.instructions.gather(episodes_, tokens_);
      if (!environment || environment->size() != n) {
        R2rEnvironmentConfig config = config_;
        config.batch_size = n;
        environment.emplace(split_.episodes, split_.view_features(), config);
      }
      environment->start(episodes_);
      body(*environment, InstructionBatch{tokens_, n}, first);
    }
  }

 private:
  const PreparedSplit& split_;
  R2rEnvironmentConfig config_;
  std::vector<std::size_t> episodes_;
  std::vector<std::uint32_t> tokens_;
};

std::size_t length_of(std::span<const std::uint32_t> row) {
  return static_cast<std::size_t>(std::ranges::find(row, r2r::Vocabulary::kPad) - row.begin());
}

void check_batch(std::size_t batch_size) {
  if (batch_size == 0) throw ArgumentError("batch size 0: at least 1 is needed");
}

// Episodes that write_walk() tells about: the first ones, those that succeeded best (of SPLs that
// are alike the longest path), and those that ended furthest from their goals.
std::set<std::size_t> shown_episodes(const GreedyWalk& walk, const r2r::EpisodeSet& episodes,
                                     std::size_t count) {
  const std::size_t total = walk.trajectories.size();
  std::set<std::size_t> shown;
  for (std::size_t i = 0; i < std::min(count, total); ++i) shown.insert(i);
  if (goals_hidden(episodes)) return shown;
  const auto metrics = score_trajectories(walk.trajectories, episodes, {}, 0);
  std::vector<std::size_t> sorted(total);
  std::iota(sorted.begin(), sorted.end(), std::size_t{0});
  const auto take_first = [&](const auto& key) {
    std::ranges::stable_sort(sorted, std::ranges::greater{}, key);
    shown.insert(sorted.begin(),
                 sorted.begin() + std::min<std::ptrdiff_t>(std::ssize(sorted),
                                                           static_cast<std::ptrdiff_t>(count / 3)));
  };
  take_first([&](std::size_t i) {
    return std::tuple(std::round(20 * metrics[i].spl), metrics[i].shortest);
  });
  take_first([&](std::size_t i) { return metrics[i].nav_error; });
  return shown;
}

models::AttentionStep attention_step(const AttentionTrace& trace, std::size_t step,
                                     const models::ReadingOrder& order,
                                     const r2r::TrajectoryPoint& point,
                                     const graph::NavGraph& graph) {
  models::AttentionStep result{std::string(to_string(static_cast<SixAction>(trace.actions[step]))),
                               {},
                               graph.id(point.viewpoint),
                               point.heading.value,
                               point.elevation.value};
  const std::vector<float>& row = trace.attention[step];
  for (const std::size_t place : order.places) {
    result.attention.push_back(place < row.size() ? row[place] : 0);
  }
  return result;
}

models::EpisodeAttention episode_attention(const GreedyWalk& walk, std::size_t i,
                                           const PreparedSplit& split,
                                           const r2r::Vocabulary& vocabulary) {
  const models::ReadingOrder order = models::reading_order(split.instructions.row(i), vocabulary);
  const graph::NavGraph& graph = split.episodes.graph_of(split.episodes.episodes[i]);
  models::EpisodeAttention episode{order.words, {}};
  for (std::size_t step = 0; step < walk.traces[i].actions.size(); ++step) {
    episode.steps.push_back(
        attention_step(walk.traces[i], step, order, walk.trajectories[i].points.at(step), graph));
  }
  return episode;
}

}  // namespace

PreparedSplit prepare(r2r::EpisodeSet episodes, const r2r::Vocabulary& vocabulary,
                      std::size_t max_words, const features::FeatureSet* features) {
  models::EncodedInstructions instructions(episodes, vocabulary, max_words);
  std::optional<ViewFeatures> views;
  if (features != nullptr) views.emplace(*features, episodes);
  return {std::move(episodes), std::move(instructions), std::move(views)};
}

GreedyWalk walk_greedily(Network& network, const PreparedSplit& split, const WalkOptions& options,
                         const Progress& progress) {
  check_batch(options.batch_size);
  const std::size_t total = split.episodes.episodes.size();
  GreedyWalk walk;
  walk.trajectories.reserve(total);
  walk.traces.resize(total);
  const auto words_of = [&](const StepRecord& step, std::size_t episode) {
    if (!network.config().inputs.language) return std::size_t{0};
    return std::min(step.words, length_of(split.instructions.row(episode)));
  };
  Batches batches(split, {options.batch_size, options.max_steps, models::AfterEnd::kStays});
  batches.for_each(
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
        for (const r2r::Trajectory& one : environment.trajectories())
          walk.trajectories.push_back(one);
        if (progress) progress(walk.trajectories.size(), total);
      });
  return walk;
}

double compute_loss(Network& network, const PreparedSplit& split, const LossOptions& options) {
  check_batch(options.walk.batch_size);
  Batches batches(
      split, {options.walk.batch_size, options.walk.max_steps, options.after_end, options.forward});
  RolloutOptions rollout = options.rollout;
  rollout.max_steps = options.walk.max_steps;
  double sum = 0;
  batches.for_each(
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
                const r2r::Vocabulary& vocabulary, std::size_t attention_episodes) {
  for (const auto& file : {results, attention}) make_folder(file.parent_path());
  write_file_atomically(results, to_json(walk.trajectories, split.episodes));
  std::vector<std::pair<std::string, models::EpisodeAttention>> shown;
  for (const std::size_t i : shown_episodes(walk, split.episodes, attention_episodes)) {
    shown.emplace_back(split.episodes.episodes[i].instruction_id,
                       episode_attention(walk, i, split, vocabulary));
  }
  write_file_atomically(attention, models::attention_json(shown));
}

}  // namespace enfilade::neural
