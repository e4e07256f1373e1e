// Score tables as JSON and as text: enfilade/tasks/score_table.h.
#include <fmt/format.h>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::tasks {
namespace {

using Json = nlohmann::ordered_json;

bool is_own(const ScoreTable& table) { return table.scorer == &own_scorer(); }
bool on_floor(const ScoreTable& table) { return table.scorer->on_floor != nullptr; }

Json means_json(const ScoreTable& table) {
  Json means = Json::object();
  for (std::size_t k = 0; k < table.means.size(); ++k) {
    const ScorerMetric& metric = table.scorer->metrics[k];
    if (metric.rule == MeanRule::kNone) continue;
    Json& entry = means[metric.mean_name()];
    entry["mean"] = table.means[k].mean;  // what is not finite becomes null
    if (table.options.bootstrap_samples == 0) continue;
    entry["low"] = table.means[k].low;
    entry["high"] = table.means[k].high;
  }
  return means;
}

// The files of own_scorer() and "vlnce" do not name them: they were the only ones of their kind.
Json summary_json(const ScoreTable& table, bool named) {
  Json all = Json::object();
  if (on_floor(table)) {
    if (named || table.scorer != &table.benchmark->scorers.front()) {
      all = {{"task", table.benchmark->name}, {"scorer", table.scorer->name}};
    }
    all["split"] = table.split;
    all["episodes"] = table.episodes;
    all["trajectories"] = table.groups;
    if (!table.floor.empty()) all["floor"] = table.floor;
  } else if (is_own(table)) {
    if (named) all = {{"task", table.benchmark->name}, {"scorer", table.scorer->name}};
    all["split"] = table.split;
    all["episodes"] = table.episodes;
    all["options"] = {{"success_distance", table.options.metrics.success_distance},
                      {"bootstrap_samples", table.options.bootstrap_samples},
                      {"bootstrap_seed", table.options.bootstrap_seed},
                      {"confidence", BootstrapOptions{}.confidence}};
  } else {
    all = {{"task", table.benchmark->name},
           {"split", table.split},
           {"scorer", table.scorer->name},
           {"source", table.scorer->source},
           {"episodes", table.episodes}};
  }
  all["means"] = means_json(table);
  return all;
}

double number_of(const Json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

MeanInterval mean_of(const Json& entry) {
  const double mean = number_of(entry.at("mean"));
  if (!entry.contains("low")) return {mean, mean, mean};
  return {mean, number_of(entry.at("low")), number_of(entry.at("high"))};
}

ScoreTable read(const Json& all) {
  ScoreTable table;
  const bool floor = all.contains("trajectories");
  table.benchmark = &benchmark(all.value("task", std::string(floor ? "r2r-ce" : "r2r")));
  table.scorer = &table.benchmark->scorer(all.value("scorer", std::string()));
  table.split = all.at("split").get<std::string>();
  table.episodes = all.at("episodes").get<std::size_t>();
  if (floor) table.groups = all.at("trajectories").get<std::size_t>();
  table.floor = all.value("floor", std::string());
  if (all.contains("options")) {
    const Json& options = all.at("options");
    table.options.metrics.success_distance = options.at("success_distance").get<double>();
    table.options.bootstrap_samples = options.at("bootstrap_samples").get<int>();
    table.options.bootstrap_seed = options.at("bootstrap_seed").get<std::uint64_t>();
  }
  const Json& means = all.at("means");
  for (const ScorerMetric& metric : table.scorer->metrics) {
    const auto found = means.find(metric.mean_name());
    const double none = std::numeric_limits<double>::quiet_NaN();
    table.means.push_back(found == means.end() ? MeanInterval{none, none, none} : mean_of(*found));
    if (found != means.end() && !found->contains("low")) table.options.bootstrap_samples = 0;
  }
  if (!all.contains("per_episode")) return table;
  for (const auto& [id, row] : all.at("per_episode").items()) {
    table.ids.push_back(id);
    for (const ScorerMetric& metric : table.scorer->metrics) {
      table.values.push_back(number_of(row.at(metric.name)));
    }
  }
  return table;
}

struct Line {
  std::string_view label, metric;
  double scale;
  int digits;
};

std::string own_table(const ScoreTable& table, bool reference) {
  const std::array<Line, 9> lines{
      {{"TL (m)", "trajectory_length", 1, 2},
       {"NE (m)", "nav_error", 1, 2},
       {"SR (%)", "success", 100, 1},
       {"OSR (%)", "oracle_success", 100, 1},
       {reference ? "SPL* (%)" : "SPL (%)", reference ? "spl_refpath" : "spl", 100, 1},
       {"nDTW (%)", "ndtw_collapsed", 100, 1},
       {"sDTW (%)", "sdtw_collapsed", 100, 1},
       {"CLS (%)", "cls", 100, 1},
       {"steps", "steps", 1, 2}}};
  const bool intervals = table.options.bootstrap_samples > 0;
  std::string text = fmt::format("{}: {} episodes\n", table.split, table.episodes);
  text += fmt::format("{:<10}{:>8}{}\n", "", "mean", intervals ? "   95 % interval" : "");
  for (const Line& line : lines) {
    const MeanInterval& mean = table.mean(line.metric);
    const auto show = [&line](double value) {
      return fmt::format("{:.{}f}", line.scale * value, line.digits);
    };
    text += fmt::format("{:<10}{:>8}", line.label, show(mean.mean));
    if (intervals) text += fmt::format("   [{}, {}]", show(mean.low), show(mean.high));
    text += '\n';
  }
  text += "nDTW, sDTW: turns on the spot taken once (in JSON ndtw_collapsed; ndtw counts them)\n";
  if (reference) text += "* against the length of the reference path\n";
  return text;
}

// Titles and units of the metrics of continuous space.
constexpr auto kFloorLines = std::to_array<Line>({
    {"TL (m)", "path_length", 1, 2},
    {"NE (m)", "distance_to_goal", 1, 2},
    {"SR (%)", "success", 100, 2},
    {"OSR (%)", "oracle_success", 100, 2},
    {"SPL (%)", "spl", 100, 2},
    {"nDTW (%)", "ndtw", 100, 2},
    {"SDTW (%)", "sdtw", 100, 2},
    {"nDTW, by fastdtw (%)", "ndtw_fastdtw", 100, 2},
    {"actions", "steps_taken", 1, 2},
    {"collisions", "collisions", 1, 2},
});

std::string floor_table(const ScoreTable& table) {
  std::string text;
  if (table.scorer != &table.benchmark->scorers.front()) {
    text = fmt::format("scored as {} ({})\n", table.scorer->name, table.scorer->source);
  }
  text += fmt::format("{} episodes of {} trajectories\n{:<22}{:>9}   95 % interval\n",
                      table.episodes, table.groups, "", "mean");
  if (!table.floor.empty()) text += fmt::format("{:<22}{:>9}\n", "floor", table.floor);
  for (const Line& line : kFloorLines) {
    const auto& metrics = table.scorer->metrics;
    const bool has = std::ranges::any_of(
        metrics, [&line](const ScorerMetric& metric) { return line.metric == metric.name; });
    if (!has || std::isnan(table.mean(line.metric).mean)) continue;
    const MeanInterval& mean = table.mean(line.metric);
    text += fmt::format("{:<22}{:>9.2f}   [{:.2f}, {:.2f}]\n", line.label, line.scale * mean.mean,
                        line.scale * mean.low, line.scale * mean.high);
  }
  return text;
}

// Means by language, as columns; empty if the episodes name none.
std::string languages_table(const ScoreTable& table) {
  std::map<std::string, std::vector<double>> values;
  for (std::size_t i = 0; i < table.languages.size(); ++i) {
    if (table.languages[i].empty()) continue;
    const auto row = table.row(i);
    auto& of = values[table.languages[i]];
    of.insert(of.end(), row.begin(), row.end());
  }
  if (values.empty()) return {};
  std::string text = fmt::format("\n{:<26}", "by language");
  for (const auto& [language, of] : values) text += fmt::format("{:>10}", language);
  text += fmt::format("\n{:<26}", "episodes");
  for (const auto& [language, of] : values) {
    text += fmt::format("{:>10}", of.size() / table.scorer->metrics.size());
  }
  text += '\n';
  for (std::size_t k = 0; k < table.means.size(); ++k) {
    const ScorerMetric& metric = table.scorer->metrics[k];
    if (metric.rule == MeanRule::kNone) continue;
    text += fmt::format("{:<26}", metric.mean_name());
    for (const auto& [language, of] : values) {
      text += fmt::format("{:>10.4f}", summarise(*table.scorer, of)[k]);
    }
    text += '\n';
  }
  return text;
}

std::string public_table(const ScoreTable& table) {
  std::string text =
      fmt::format("{} {}: {} episodes, scored as {} ({})\n", table.benchmark->title, table.split,
                  table.episodes, table.scorer->name, table.scorer->source);
  const bool intervals = table.options.bootstrap_samples > 0;
  text += fmt::format("{:<26}{:>10}{}\n", "", "mean", intervals ? "   95 % interval" : "");
  for (std::size_t k = 0; k < table.means.size(); ++k) {
    const ScorerMetric& metric = table.scorer->metrics[k];
    if (metric.rule == MeanRule::kNone) continue;
    const MeanInterval& mean = table.means[k];
    text += fmt::format("{:<26}{:>10.4f}", metric.mean_name(), mean.mean);
    if (intervals) text += fmt::format("   [{:.4f}, {:.4f}]", mean.low, mean.high);
    text += '\n';
  }
  return text + languages_table(table);
}

}  // namespace

std::string to_json(const ScoreTable& table, bool per_episode) {
  Json all = summary_json(table, false);
  if (per_episode) {
    Json& entries = all["per_episode"] = Json::object();
    for (std::size_t i = 0; i < table.ids.size(); ++i) {
      Json& entry = entries[table.ids[i]];
      const auto row = table.row(i);
      for (std::size_t k = 0; k < row.size(); ++k) entry[table.scorer->metrics[k].name] = row[k];
    }
  }
  return all.dump(1) + "\n";
}

std::string to_record(const ScoreTable& table) { return summary_json(table, true).dump(); }

ScoreTable from_json(std::string_view json) {
  try {
    return read(Json::parse(json));
  } catch (const nlohmann::json::exception& error) {
    throw InvalidInput({{Severity::kError, "score", "$", "not-a-score", error.what()}});
  }
}

std::string to_table(const ScoreTable& table, SplLength spl) {
  if (on_floor(table)) return floor_table(table);
  return is_own(table) ? own_table(table, spl == SplLength::kReference) : public_table(table);
}

}  // namespace enfilade::tasks
