#include "enfilade/models/decision_recorder.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <tuple>

#include "enfilade/core/check.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::models {
namespace {

std::optional<double> wider(const std::optional<float>& value) {
  return value ? std::optional<double>(*value) : std::nullopt;
}

DecisionStep with_names(const RecordedStep& step, const graph::NavGraph& graph) {
  DecisionStep named{.viewpoint = graph.id(step.viewpoint),
                     .heading = step.heading.value,
                     .elevation = step.elevation.value,
                     .attention = {step.attention.begin(), step.attention.end()},
                     .choices = {},
                     .chosen = step.chosen,
                     .way = {},
                     .map_share = wider(step.map_share),
                     .nodes = {},
                     .object = step.object};
  for (const RecordedChoice& choice : step.choices) {
    named.choices.push_back({choice.viewpoint ? graph.id(*choice.viewpoint) : std::string(),
                             choice.probability, wider(choice.map), wider(choice.view)});
  }
  for (const ViewpointIndex v : step.way) named.way.push_back(graph.id(v));
  for (const RecordedNode& node : step.nodes) {
    named.nodes.push_back({graph.id(node.viewpoint), node.visited, wider(node.stop)});
  }
  return named;
}

}  // namespace

std::vector<float> probabilities(std::span<const float> logits) {
  std::vector<float> result(logits.size());
  if (logits.empty()) return result;
  const float most = *std::ranges::max_element(logits);
  double sum = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    result[i] = std::exp(logits[i] - most);
    sum += static_cast<double>(result[i]);
  }
  for (float& one : result) one = static_cast<float>(static_cast<double>(one) / sum);
  return result;
}

DecisionRecorder::DecisionRecorder(AgentKind agent, std::size_t episodes)
    : agent_(agent), recorded_(episodes) {}

void DecisionRecorder::read(std::size_t episode, std::vector<std::string> words) {
  EN_CHECK_LT(episode, recorded_.size());
  recorded_[episode] = {std::move(words), {}};
}

void DecisionRecorder::add(std::size_t episode, RecordedStep step) {
  EN_CHECK_LT(episode, recorded_.size());
  Episode& to = recorded_[episode];
  EN_CHECK_LT(step.chosen, step.choices.size());
  if (!step.attention.empty()) EN_CHECK_EQ(step.attention.size(), to.words.size());
  to.steps.push_back(std::move(step));
}

std::size_t DecisionRecorder::steps(std::size_t episode) const {
  EN_CHECK_LT(episode, recorded_.size());
  return recorded_[episode].steps.size();
}

EpisodeDecisions DecisionRecorder::episode(std::size_t episode,
                                           const tasks::EpisodeSet& episodes) const {
  EN_CHECK_LT(episode, recorded_.size());
  const graph::NavGraph& graph = episodes.graph_of(episodes.episodes[episode]);
  EpisodeDecisions named{std::string(to_string(agent_)), recorded_[episode].words, {}};
  for (const RecordedStep& step : recorded_[episode].steps) {
    named.steps.push_back(with_names(step, graph));
  }
  return named;
}

void DecisionRecorder::write(const std::filesystem::path& file, const tasks::EpisodeSet& episodes,
                             const std::vector<tasks::Trajectory>& trajectories,
                             std::size_t count) const {
  EN_CHECK_EQ(episodes.episodes.size(), recorded_.size());
  std::vector<std::pair<std::string, EpisodeDecisions>> shown;
  for (const std::size_t i : shown_episodes(trajectories, episodes, count)) {
    shown.emplace_back(episodes.episodes[i].instruction_id, episode(i, episodes));
  }
  make_folder(file.parent_path());
  write_file_atomically(file, decisions_json(shown));
}

std::set<std::size_t> shown_episodes(const std::vector<tasks::Trajectory>& trajectories,
                                     const tasks::EpisodeSet& episodes, std::size_t count) {
  const std::size_t total = trajectories.size();
  std::set<std::size_t> shown;
  for (std::size_t i = 0; i < std::min(count, total); ++i) shown.insert(i);
  if (goals_hidden(episodes)) return shown;
  const auto metrics = score_trajectories(trajectories, episodes, {}, 0);
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

}  // namespace enfilade::models
