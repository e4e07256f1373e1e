#include "enfilade/report/parts/walk_parts.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/draw/top_down.h"
#include "enfilade/report/parts/dataset_parts.h"
#include "enfilade/report/parts/picture_parts.h"

namespace enfilade::report::parts {
namespace {

using Json = nlohmann::ordered_json;
using Role = draw::WalkedLine::Role;

// Each agent's first run on a split, in the order of the runs.
std::vector<const ScoredRun*> first_runs(const ScoredRuns& runs, const std::string& split) {
  std::vector<const ScoredRun*> first;
  std::set<std::string_view> agents;
  for (const ScoredRun& run : runs.runs) {
    if (run.split == split && agents.insert(without_seed(run.agent)).second) first.push_back(&run);
  }
  return first;
}

struct Chosen {
  const char* kind;
  std::size_t episode;
};

// By how far from the goal a run stopped. Its walks are in the order of the episodes.
std::vector<Chosen> choose(const ScoredRun& run, std::size_t of_a_kind) {
  std::vector<std::size_t> order(run.scores.ours.episodes);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    const auto rank = [&run](std::size_t k) {
      return std::pair(-run.scores.ours.value(k, "spl"),
                       run.scores.ours.value(k, "distance_to_goal"));
    };
    return rank(a) < rank(b);
  });
  std::vector<Chosen> chosen;
  std::set<std::size_t> taken;
  const auto take = [&](const char* kind, std::size_t place) {
    const std::size_t k = order[std::min(place, order.size() - 1)];
    if (taken.insert(k).second) chosen.push_back({kind, run.walks[k].episode});
  };
  for (std::size_t i = 0; i < of_a_kind; ++i) take("best", i);
  for (std::size_t i = 0; i < of_a_kind; ++i) take("median", order.size() / 2 + i);
  for (std::size_t i = 0; i < of_a_kind; ++i)
    take("worst", order.size() - 1 - std::min(i, order.size() - 1));
  return chosen;
}

Json map_of(const Chosen& one, const std::vector<const ScoredRun*>& agents,
            const tasks::ContinuousEpisodes& episodes, const continuous::Buildings& buildings,
            bool synthetic) {
  const tasks::ContinuousEpisode& episode = episodes.episodes.at(one.episode);
  const std::string scan(episode.scan());
  std::vector<draw::WalkedLine> lines;
  if (episode.reference_path) lines.push_back({Role::kReference, *episode.reference_path, ""});
  Json ends = Json::array();
  for (const ScoredRun* run : agents) {
    for (std::size_t k = 0; k < run->walks.size(); ++k) {
      if (run->walks[k].episode != one.episode) continue;
      lines.push_back({Role::kAgent, draw::walked_points(run->walks[k].positions), run->agent});
      ends.push_back({{"agent", run->agent},
                      // null if it is not finite
                      {"distance", run->scores.ours.value(k, "distance_to_goal")},
                      {"success", run->scores.ours.value(k, "success") > 0}});
    }
  }
  draw::TopDownOptions options;
  options.title = fmt::format("{}, episode {} ({}){}", scan, tasks::text_of(episode.id), one.kind,
                              synthetic ? " (SYNTHETIC)" : "");
  options.note = episode.instruction.text;
  const std::string svg =
      draw::top_down_svg(buildings.floor(buildings.at(scan)).floor(), lines, options);
  return {{"scan", scan},
          {"episode", tasks::text_of(episode.id)},
          {"kind", one.kind},
          {"agents", std::move(ends)},
          {"picture", data_uri("image/svg+xml", svg)}};
}

}  // namespace

Json walks_part(const ScoredRuns& runs, std::size_t of_a_kind, bool synthetic) {
  if (runs.runs.empty()) return missing("There are no results that can be scored.");
  const bool unseen = std::ranges::any_of(
      runs.runs, [](const ScoredRun& run) { return run.split == "val_unseen"; });
  const std::string split = unseen ? "val_unseen" : runs.runs.front().split;
  const std::vector<const ScoredRun*> agents = first_runs(runs, split);
  const ScoredRun* judge = agents.back();
  for (const ScoredRun* run : agents) {
    if (!is_oracle(run->agent)) judge = run;
  }
  Json all = Json::array();
  for (const Chosen& one : choose(*judge, of_a_kind)) {
    all.push_back(
        map_of(one, agents, runs.continuous_splits.at(split), *runs.buildings, synthetic));
  }
  return {{"agent", judge->agent}, {"split", split}, {"walks", std::move(all)}};
}

}  // namespace enfilade::report::parts
