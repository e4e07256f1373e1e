#include "enfilade/report/parts/parts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/tasks/statistics.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::report::parts {
namespace {

constexpr double kMetresABin = 2;     // of path lengths
constexpr std::size_t kPoints = 400;  // of a curve, at most: charts have few more pixels
// Bins with fewer paths are left out.
constexpr std::size_t kFewestPaths = 5;

// All agents but "shortest", in their order: [{"agent", "splits": {split: one(runs)}}].
template <class Run, class One>
Json by_agent(const std::vector<Run>& all_runs, const One& one) {
  std::vector<std::string> agents;
  std::map<std::string, std::map<std::string, std::vector<const Run*>>> groups;
  for (const Run& run : all_runs) {
    const std::string agent(without_seed(run.agent));
    if (is_oracle(agent)) continue;
    if (!groups.contains(agent)) agents.push_back(agent);
    groups[agent][run.split].push_back(&run);
  }
  if (agents.empty()) {
    return missing("No agent but Shortest and Reference has results that can be scored.");
  }
  Json all = Json::array();
  for (const std::string& agent : agents) {
    Json splits = Json::object();
    for (const auto& [split, runs] : groups[agent]) splits[split] = one(runs);
    all.push_back({{"agent", agent}, {"splits", std::move(splits)}});
  }
  return {{"agents", std::move(all)}};
}

struct LengthBin {
  std::size_t episodes = 0;
  double successes = 0;
  std::set<std::size_t> paths;
};

Json success_by_length(const std::vector<const ScoredRun*>& runs, const ScoredRuns& scored) {
  std::map<std::size_t, LengthBin> bins;
  for (const ScoredRun* run : runs) {
    const tasks::EpisodeSet& episodes = *scored.split_of(*run).on_graph();
    for (std::size_t i = 0; i < run->scores.ours.episodes; ++i) {
      const tasks::EpisodeMetrics m = metrics_of(run->scores.ours, i);
      if (!std::isfinite(m.shortest)) continue;
      LengthBin& bin = bins[static_cast<std::size_t>(m.shortest / kMetresABin)];
      ++bin.episodes;
      bin.successes += m.success;
      bin.paths.insert(episodes.episodes[i].path);
    }
  }
  Json all = Json::array();
  for (const auto& [k, bin] : bins) {
    if (bin.paths.size() < kFewestPaths) continue;
    const double share = bin.successes / static_cast<double>(bin.episodes);
    const auto interval = wilson_interval(share, static_cast<double>(bin.paths.size()));
    all.push_back({{"from", kMetresABin * static_cast<double>(k)},
                   {"to", kMetresABin * static_cast<double>(k + 1)},
                   {"paths", bin.paths.size()},
                   {"success", share},
                   {"low", interval.low},
                   {"high", interval.high}});
  }
  return all;
}

Json run_json(const std::string& name, const models::TrainingHistory& log) {
  Json training = Json::array();
  for (const LossPoint& point : training_curve(log.training, kPoints)) {
    training.push_back({{"iteration", point.iteration}, {"loss", point.loss}});
  }
  Json splits = Json::object();
  for (const models::EvaluationRecord& record : log.evaluations) {
    splits[record.split].push_back({{"iteration", static_cast<double>(record.iteration)},
                                    {"loss", record.loss},  // null if it is not finite
                                    {"error", record.nav_error},
                                    {"success", record.success_rate}});
  }
  return {{"run", name}, {"train", std::move(training)}, {"evaluations", std::move(splits)}};
}

// When an episode succeeds, in the order of GoalKind.
struct SuccessRule {
  bool near;  // by stopping near a place, however many steps are left
  const char* text;
};
constexpr SuccessRule kRules[] = {
    {true, "An episode succeeds if it is less than 3 m."},
    {true,
     "Where the agent named no viewpoint within 3 m of the turning point, the distance goes "
     "through that point. An episode succeeds if the named viewpoint and the end are at most 3 m "
     "off."},
    {false,
     "The goal is the nearest viewpoint that sees the object; an episode succeeds where it is "
     "seen."},
    {false, "The goal is the nearest viewpoint of the region; an episode succeeds in it."},
    {false,
     "The goal is the nearest viewpoint with a box of the object; an episode succeeds there, or "
     "less than 3 m from the end of the path."},
    {true, "An episode succeeds if the agent says stop and it is less than 3 m."},
};
static_assert(std::size(kRules) == static_cast<std::size_t>(tasks::GoalKind::kPoint) + 1);

// What the distance to the goal is called and how it is measured, in the order of WorldKind.
struct ErrorWords {
  const char *metric, *measured;
};
constexpr ErrorWords kErrors[] = {{"nav_error", "along the graph"},
                                  {"distance_to_goal", "along the floor"}};

constexpr double kWordsABin = 5;
constexpr std::size_t kFirstWords = 4;
constexpr double kThinnest = 0.003;  // of the circle: about a degree

Json summary_json(std::vector<double> values) {
  const tasks::Summary s = tasks::summarise(std::move(values));
  return {{"mean", s.mean}, {"median", s.median}, {"min", s.min}, {"max", s.max}};
}

Json lengths_of(const tasks::Annotations& split, const graph::GraphSet& graphs) {
  Histogram paths{kMetresABin, {}, 0}, words{kWordsABin, {}, 0};
  std::vector<double> metres, tokens;
  for (const tasks::ReferencePath& path : look_up_paths(split, graphs)) {
    if (path.viewpoints.size() < 2) continue;  // the goal is hidden
    metres.push_back(length_of(path, graphs.graph(path.scan)));
    paths.add(metres.back());
  }
  for (const tasks::PathAnnotation& path : split.paths) {
    for (const std::string& text : path.instructions) {
      tokens.push_back(static_cast<double>(tasks::tokenize(text).size()));
      words.add(tokens.back());
    }
  }
  Json json{{"split", split.split}, {"words", to_json(words)}};
  json["wordsSummary"] = tokens.empty() ? Json(nullptr) : summary_json(std::move(tokens));
  if (metres.empty()) return json;
  json["paths"] = to_json(paths);
  json["pathsSummary"] = summary_json(std::move(metres));
  return json;
}

// Instructions by the words that they begin with.
struct Branch {
  std::size_t count = 0;
  std::map<std::string, Branch> next;
};

Json branch_json(const std::string& word, const Branch& branch, double least) {
  Json json{{"word", word}, {"count", branch.count}};
  std::vector<std::pair<std::string, const Branch*>> thick;
  for (const auto& [text, child] : branch.next) {
    if (static_cast<double>(child.count) >= least) thick.emplace_back(text, &child);
  }
  std::ranges::stable_sort(thick, std::ranges::greater{},
                           [](const auto& pair) { return pair.second->count; });
  if (!thick.empty()) json["next"] = Json::array();
  for (const auto& [text, child] : thick) {
    json["next"].push_back(branch_json(text, *child, least));
  }
  return json;
}

}  // namespace

ShareInterval wilson_interval(double share, double n) noexcept {
  constexpr double kZ = 1.959964;  // quantile 0.975 of the normal distribution
  const double centre = (share + kZ * kZ / (2 * n)) / (1 + kZ * kZ / n);
  const double half =
      kZ / (1 + kZ * kZ / n) * std::sqrt(share * (1 - share) / n + kZ * kZ / (4 * n * n));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

std::vector<LossPoint> training_curve(std::span<const models::TrainRecord> records,
                                      std::size_t most) {
  if (most == 0) throw ArgumentError("most: 0, not at least 1");
  const std::size_t each = std::max<std::size_t>(1, (records.size() + most - 1) / most);
  std::vector<LossPoint> curve;
  for (std::size_t begin = 0; begin < records.size(); begin += each) {
    const auto part = records.subspan(begin, std::min(each, records.size() - begin));
    const auto n = static_cast<double>(part.size());
    LossPoint mean;
    for (const models::TrainRecord& record : part) {
      mean.iteration += static_cast<double>(record.iteration) / n;
      mean.loss += record.loss / n;
    }
    curve.push_back(mean);
  }
  return curve;
}

Json errors_part(const ScoredRuns& scored) {
  const tasks::Benchmark& benchmark = *scored.benchmark;
  const ErrorWords& words = kErrors[static_cast<std::size_t>(benchmark.world)];
  const SuccessRule& rule = kRules[static_cast<std::size_t>(benchmark.goal)];
  Json part = by_agent(scored.runs, [&words](const std::vector<const ScoredRun*>& runs) {
    Histogram histogram{1, {}, 0};
    for (const ScoredRun* run : runs) {
      for (std::size_t i = 0; i < run->scores.ours.episodes; ++i) {
        const double metres = run->scores.ours.value(i, words.metric);
        if (std::isfinite(metres)) histogram.add(metres);
      }
    }
    return to_json(histogram);
  });
  part["measured"] = words.measured;
  part["rule"] = rule.text;
  part["radius"] = rule.near ? Json(tasks::MetricOptions{}.success_distance) : Json(nullptr);
  return part;
}

Json by_length_part(const ScoredRuns& scored) {
  return by_agent(scored.runs, [&scored](const std::vector<const ScoredRun*>& runs) {
    return success_by_length(runs, scored);
  });
}

Json curves_part(const RunDirectory& found) {
  if (found.models.empty()) return missing("No model was trained here.");
  Json all = Json::array();
  for (const ModelDirectory& model : found.models) {
    const std::filesystem::path file = models::ModelFiles{model.folder}.log();
    std::error_code code;
    if (!std::filesystem::exists(file, code)) continue;
    const std::string agent(without_seed(model.agent));
    if (all.empty() || all.back()["agent"] != agent) {
      all.push_back({{"agent", agent}, {"runs", Json::array()}});
    }
    all.back()["runs"].push_back(run_json(model.agent, models::load_training_log(file)));
  }
  if (all.empty()) return missing("The model directories have no log.jsonl.");
  return {{"agents", std::move(all)}};
}

Json missing(const std::string& why) { return {{"missing", why}}; }

void Histogram::add(double value) {
  EN_CHECK(std::isfinite(value) && value >= 0);
  const auto bin = static_cast<std::size_t>(value / width);
  if (bin >= counts.size()) counts.resize(bin + 1);
  ++counts[bin];
  ++total;
}

Json to_json(const Histogram& histogram) {
  return {{"width", histogram.width}, {"total", histogram.total}, {"counts", histogram.counts}};
}

Json lengths_part(const std::vector<tasks::Annotations>& splits,
                  const std::shared_ptr<const graph::GraphSet>& graphs) {
  if (splits.empty()) return missing("There are no annotations in the data set.");
  Json all = Json::array();
  for (const tasks::Annotations& split : splits) all.push_back(lengths_of(split, *graphs));
  return {{"splits", all}};
}

Json words_part(const std::vector<tasks::Annotations>& splits) {
  Branch root;
  for (const tasks::Annotations& split : splits) {
    for (const tasks::PathAnnotation& path : split.paths) {
      for (const std::string& text : path.instructions) {
        const std::vector<std::string> words = tasks::tokenize(text);
        Branch* branch = &root;
        ++branch->count;
        for (std::size_t i = 0; i < std::min(words.size(), kFirstWords); ++i) {
          branch = &branch->next[words[i]];
          ++branch->count;
        }
      }
    }
  }
  if (root.count == 0) return missing("There are no instructions in the data set.");
  return branch_json("", root, kThinnest * static_cast<double>(root.count));
}

}  // namespace enfilade::report::parts
