#include "enfilade/service/evaluation/breakdown.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/agents/run.h"
#include "enfilade/core/names.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/store/database.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::service::evaluation {
namespace {

using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

constexpr std::size_t kMostInMemory = 64U << 20U;  // of all scored submissions in memory

/// An episode's value in metres, or as a share from 0 to 1.
double value_of(const tasks::ScoreTable& score, const tasks::Measure& measure, std::size_t k) {
  const std::size_t place = score.scorer->place_of(measure.name);
  return score.row(k)[place] * score.scorer->metrics[place].scale / measure.whole;
}

/// The group of each episode, from which the bootstrap draws: its path, or its trajectory's id.
std::vector<std::size_t> groups_of(const tasks::Split& split) {
  std::vector<std::size_t> groups;
  if (const auto& set = split.on_graph()) {
    for (const tasks::Episode& one : set->episodes) groups.push_back(set->path_of(one).group);
    return groups;
  }
  std::map<std::string, std::size_t> numbers;
  for (const tasks::ContinuousEpisode& one : split.continuous()->episodes) {
    const std::string id = tasks::text_of(one.trajectory_id);
    groups.push_back(numbers.try_emplace(id, numbers.size()).first->second);
  }
  return groups;
}

/// The trajectories of some episodes.
tasks::Trajectories some_of(const tasks::Trajectories& all, const std::vector<std::size_t>& which) {
  return std::visit(
      [&which](const auto& list) -> tasks::Trajectories {
        std::decay_t<decltype(list)> some;
        for (const std::size_t k : which) some.push_back(list[k]);
        return some;
      },
      all);
}

std::size_t bytes_of(const tasks::Trajectories& trajectories) {
  const auto size = [](const auto& list) {
    std::size_t bytes = 0;
    for (const auto& one : list) {
      if constexpr (requires { one.points; }) {
        bytes += sizeof(one) + one.points.size() * sizeof(one.points.front());
      } else {
        bytes += sizeof(one) + one.positions.size() * (sizeof(Vec3f) + sizeof(Radians) + 1);
      }
    }
    return bytes;
  };
  return std::visit(size, trajectories);
}

/// The width of bins of path lengths, metres: a round number that makes few of them.
double bin_width(double least, double most) {
  double width = 1;
  for (const double next : {2.5, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    if (std::floor(most / width) - std::floor(least / width) < Breakdowns::kMostBins) break;
    width = next;
  }
  return width;
}

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

}  // namespace

/// Results of a phase's split, episode by episode in its order.
struct Breakdowns::Scored {
  const SecretEpisodes* episodes = nullptr;
  tasks::Trajectories trajectories;
  tasks::ScoreTable score;
  std::vector<std::size_t> groups;
  ordered_json parts;

  ordered_json means_of(const std::vector<std::size_t>& which) const {
    tasks::Trajectories some = some_of(trajectories, which);
    const tasks::Split part = tasks::part_of(episodes->split, some);
    const tasks::ScoreTable table =
        agents::compute_score(some, part, episodes->buildings.get(), *score.scorer);
    return {
        {"episodes", which.size()}, {"groups", table.groups}, {"means", exact_means_json(table)}};
  }

  void add_parts() {
    std::map<std::string, std::vector<std::size_t>> buildings;
    std::vector<double> lengths;
    double least = HUGE_VAL, most = 0;
    for (std::size_t k = 0; k < episodes->split.size(); ++k) {
      const tasks::PathSize size = episodes->split.path_size(k);
      buildings[size.scan].push_back(k);
      lengths.push_back(size.length);
      if (!std::isfinite(size.length)) continue;
      least = std::min(least, size.length);
      most = std::max(most, size.length);
    }
    const double width = bin_width(least, most);
    std::map<std::int64_t, std::vector<std::size_t>> bins;
    for (std::size_t k = 0; k < lengths.size(); ++k) {
      if (!std::isfinite(lengths[k])) continue;  // paths of CVDN and others may jump
      bins[static_cast<std::int64_t>(std::floor(lengths[k] / width))].push_back(k);
    }
    parts = {{"buildings", ordered_json::array()}, {"lengths", ordered_json::array()}};
    for (const auto& [scan, which] : buildings) {
      ordered_json one{{"scan", scan}};
      one.update(means_of(which));
      parts["buildings"].push_back(std::move(one));
    }
    for (const auto& [bin, which] : bins) {
      const auto first = static_cast<double>(bin);
      ordered_json one{{"least", first * width}, {"most", (first + 1) * width}};
      one.update(means_of(which));
      parts["lengths"].push_back(std::move(one));
    }
  }

  ordered_json episode_json(std::size_t k) const {
    const tasks::Split& split = episodes->split;
    ordered_json one{{"episode", split.id(k)}};
    if (const auto& set = split.on_graph()) {
      const tasks::Episode& episode = set->episodes[k];
      const graph::NavGraph& graph = set->graph_of(episode);
      const auto& walk = std::get<std::vector<tasks::Trajectory>>(trajectories)[k];
      one["scan"] = graph.scan();
      one["instruction"] = episode.text;
      one["path"] = detail::json_list(set->path_of(episode).viewpoints,
                                      [&graph](ViewpointIndex v) { return graph.id(v); });
      one["trajectory"] = detail::json_list(walk.points, [&graph](
                                                             const tasks::TrajectoryPoint& point) {
        return ordered_json::array({graph.id(point.viewpoint), detail::rounded(point.heading.value),
                                    detail::rounded(point.elevation.value)});
      });
    } else {
      const tasks::ContinuousEpisode& episode = split.continuous()->episodes[k];
      one["scan"] = std::string(episode.scan());
      one["instruction"] = episode.instruction.text;
    }
    auto& values = one["values"] = ordered_json::object();
    for (const tasks::Measure& measure : score.scorer->columns) {
      values[measure.name] = number(value_of(score, measure, k));
    }
    return one;
  }
};

bool has_open_goals(const Site& site, const Phase& phase) {
  if (phase.goals_secret()) return false;
  if (phase.benchmark->continuous()) return true;  // Site refuses open ones that tell secrets
  const PublicSplit* split = site.find_split(phase.split, phase.benchmark->task);
  return split != nullptr && !split->goals_hidden;
}

Breakdowns::Breakdowns(std::shared_ptr<const Site> site, const Submissions& submissions)
    : site_(std::move(site)),
      submissions_(submissions),
      scored_(kMostInMemory, [](const SharedScored& one) {
        return bytes_of(one->trajectories) + one->score.values.size() * sizeof(double);
      }) {}

Breakdowns::~Breakdowns() = default;

Breakdowns::SharedScored Breakdowns::scored(const Submission& submission, const Phase& phase) {
  if (!score_of(submission, phase)) {
    throw Refusal(Reason::kConflict,
                  fmt::format("submission {} has no score of this phase", submission.id));
  }
  return scored_.get(submission.id, [&] {
    const std::scoped_lock lock(scoring_);
    try {
      return std::make_shared<const Scored>(score(submission, phase));
    } catch (const store::DatabaseError&) {
      throw;
    } catch (const Error&) {  // what it says may name files of this machine
      throw Refusal(Reason::kConflict,
                    fmt::format("submission {} can no longer be scored: the data set has changed",
                                submission.id));
    }
  });
}

Breakdowns::Scored Breakdowns::score(const Submission& submission, const Phase& phase) const {
  const SecretEpisodes& episodes = site_->secret_episodes(phase);
  Scored one;
  one.episodes = &episodes;
  one.trajectories =
      tasks::parse_trajectories(submissions_.results(submission.id), "submission", episodes.split);
  one.score = agents::compute_score(one.trajectories, episodes.split, episodes.buildings.get(),
                                    *phase.scorer);
  one.groups = groups_of(episodes.split);
  one.add_parts();
  return one;
}

ordered_json Breakdowns::parts(const Submission& submission, const Phase& phase) {
  return scored(submission, phase)->parts;
}

ordered_json Breakdowns::worst(const Submission& submission, const Phase& phase) {
  const SharedScored one = scored(submission, phase);
  const tasks::Measure& primary = phase.primary_measure();
  const auto columns = phase.measures();
  const auto error = std::ranges::find(columns, tasks::Better::kLower, &tasks::Measure::better);
  // The larger, the worse. No value is worst.
  const auto badness = [&](std::size_t k) {
    const double value = value_of(one->score, primary, k);
    const double away = error == columns.end() ? 0 : value_of(one->score, *error, k);
    return std::pair(std::isnan(value) ? HUGE_VAL : -value, std::isnan(away) ? HUGE_VAL : away);
  };
  std::vector<std::size_t> order(one->score.episodes);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t count = std::min(order.size(), kWorst);
  std::ranges::stable_sort(order, std::ranges::greater{}, badness);
  order.resize(count);
  return detail::json_list(order, [&one](std::size_t k) { return one->episode_json(k); });
}

ordered_json Breakdowns::episode(const Submission& submission, const Phase& phase,
                                 std::string_view id) {
  const SharedScored one = scored(submission, phase);
  const auto found = std::ranges::find(one->score.ids, id);
  if (found == one->score.ids.end()) {
    throw Refusal(Reason::kNotFound,
                  fmt::format("submission {} has no episode {}", submission.id, quote(id)));
  }
  return one->episode_json(static_cast<std::size_t>(found - one->score.ids.begin()));
}

ordered_json Breakdowns::compare(const Submission& first, const Submission& second,
                                 const Phase& phase) {
  const SharedScored a = scored(first, phase), b = scored(second, phase);
  const std::size_t n = a->score.episodes;
  const tasks::BootstrapOptions options{.threads = 1};  // others are served meanwhile
  std::size_t better = 0, worse = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const tasks::Measure& primary = phase.primary_measure();
    const double x = value_of(a->score, primary, k), y = value_of(b->score, primary, k);
    if (y > x) ++better;
    if (y < x) ++worse;
  }
  ordered_json out{{"first", first.id},
                   {"second", second.id},
                   {"episodes", n},
                   {"groups", a->score.groups},
                   {"samples", options.samples},
                   {"better", better},
                   {"worse", worse},
                   {"means", ordered_json::object()}};
  for (const tasks::Measure& measure : phase.measures()) {
    std::vector<double> of_first, of_second;
    std::vector<std::size_t> groups;
    for (std::size_t k = 0; k < n; ++k) {
      const double x = value_of(a->score, measure, k), y = value_of(b->score, measure, k);
      if (std::isnan(x) || std::isnan(y)) continue;
      of_first.push_back(x);
      of_second.push_back(y);
      groups.push_back(a->groups[k]);
    }
    ordered_json& one = out["means"][measure.name];
    one["first"] = number(a->score.mean(measure.name).mean / measure.whole);
    one["second"] = number(b->score.mean(measure.name).mean / measure.whole);
    if (groups.empty()) continue;
    const auto found = tasks::paired_bootstrap(of_first, of_second, 1, groups, options).front();
    one["difference"] = number(found.difference.mean);
    one["low"] = number(found.difference.low);
    one["high"] = number(found.difference.high);
    one["p"] = found.p;
  }
  return out;
}

}  // namespace enfilade::service::evaluation
