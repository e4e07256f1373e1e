#include "enfilade/tasks/continuous_measures.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"

namespace enfilade::tasks {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

constexpr std::array kMeasures{
    ContinuousMeasure{"path_length", "TL (m)", 1,
                      [](const ContinuousScore& s) { return s.path_length; }},
    ContinuousMeasure{"distance_to_goal", "NE (m)", 1,
                      [](const ContinuousScore& s) { return s.distance_to_goal; }},
    ContinuousMeasure{"success", "SR (%)", 100, [](const ContinuousScore& s) { return s.success; }},
    ContinuousMeasure{"oracle_success", "OSR (%)", 100,
                      [](const ContinuousScore& s) { return s.oracle_success; }},
    ContinuousMeasure{"spl", "SPL (%)", 100, [](const ContinuousScore& s) { return s.spl; }},
    ContinuousMeasure{"ndtw", "nDTW (%)", 100, [](const ContinuousScore& s) { return s.ndtw; }},
    ContinuousMeasure{"sdtw", "SDTW (%)", 100, [](const ContinuousScore& s) { return s.sdtw; }},
    ContinuousMeasure{"ndtw_fastdtw", "nDTW, by fastdtw (%)", 100,
                      [](const ContinuousScore& s) { return s.ndtw_fastdtw; }},
    ContinuousMeasure{"steps_taken", "actions", 1,
                      [](const ContinuousScore& s) { return s.steps_taken; }},
    ContinuousMeasure{"collisions", "collisions", 1,
                      [](const ContinuousScore& s) { return s.collisions.value_or(kNone); }}};

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

const ContinuousEpisode& episode_of(const ContinuousResult& walk,
                                    const ContinuousEpisodes& episodes) {
  return episodes.episodes.at(walk.episode);
}

}  // namespace

std::span<const ContinuousMeasure> continuous_measures() noexcept { return kMeasures; }

ContinuousMeasures measure(std::span<const ContinuousScore> scores,
                           std::span<const ContinuousResult> walks,
                           const ContinuousEpisodes& episodes) {
  if (scores.empty() || scores.size() != walks.size()) {
    throw ArgumentError(fmt::format("{} scores of {} walks; one of each, and one at least",
                                    scores.size(), walks.size()));
  }
  std::vector<double> values;
  std::vector<std::size_t> groups;
  std::map<std::string, std::size_t> trajectories;
  for (std::size_t k = 0; k < scores.size(); ++k) {
    for (const ContinuousMeasure& m : kMeasures) values.push_back(m.value(scores[k]));
    const std::string id = text_of(episode_of(walks[k], episodes).trajectory_id);
    groups.push_back(trajectories.try_emplace(id, trajectories.size()).first->second);
  }
  return {scores.size(), trajectories.size(), bootstrap_means(values, kMeasures.size(), groups)};
}

std::string to_table(const ContinuousMeasures& measures) {
  std::string text = fmt::format("{} episodes of {} trajectories\n{:<22}{:>9}   95 % interval\n",
                                 measures.episodes, measures.trajectories, "", "mean");
  for (std::size_t k = 0; k < kMeasures.size(); ++k) {
    const double unit = kMeasures[k].unit;
    const MeanInterval& m = measures.means[k];
    if (std::isnan(m.mean)) continue;
    text += fmt::format("{:<22}{:>9.2f}   [{:.2f}, {:.2f}]\n", kMeasures[k].title, unit * m.mean,
                        unit * m.low, unit * m.high);
  }
  return text;
}

std::string to_json(const ContinuousMeasures& measures, std::span<const ContinuousScore> scores,
                    std::span<const ContinuousResult> walks, const ContinuousEpisodes& episodes,
                    bool per_episode) {
  Json all{{"split", episodes.split},
           {"episodes", measures.episodes},
           {"trajectories", measures.trajectories}};
  Json& means = all["means"] = Json::object();
  for (std::size_t k = 0; k < kMeasures.size(); ++k) {
    const MeanInterval& m = measures.means[k];
    means[std::string(kMeasures[k].name)] = {
        {"mean", number(m.mean)}, {"low", number(m.low)}, {"high", number(m.high)}};
  }
  if (per_episode) {
    Json& entries = all["per_episode"] = Json::object();
    for (std::size_t k = 0; k < scores.size(); ++k) {
      Json& entry = entries[text_of(episode_of(walks[k], episodes).id)];
      for (const ContinuousMeasure& m : kMeasures) {
        entry[std::string(m.name)] = number(m.value(scores[k]));
      }
    }
  }
  return all.dump(1) + "\n";
}

}  // namespace enfilade::tasks
