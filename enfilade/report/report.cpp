#include "enfilade/report/report.h"

#include <fmt/format.h>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/training_log.h"
#include "enfilade/report/parts/dataset_parts.h"
#include "enfilade/report/parts/gallery.h"
#include "enfilade/report/parts/page.h"
#include "enfilade/report/parts/picture_parts.h"
#include "enfilade/report/parts/result_parts.h"
#include "enfilade/report/parts/walk_parts.h"
#include "enfilade/report/results_table.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/report/scored_runs.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

namespace enfilade::report {
namespace {

using parts::Json;

// "12 h 3 min", "4 min 10 s"
std::string duration(double seconds) {
  const auto s = static_cast<long>(seconds + 0.5);
  if (s >= 3600) return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
  return s >= 60 ? fmt::format("{} min {} s", s / 60, s % 60) : fmt::format("{} s", s);
}

std::string model_fact(const ModelDirectory& model) {
  const std::filesystem::path file = models::ModelFiles{model.folder}.log();
  std::error_code code;
  if (!std::filesystem::exists(file, code)) return "no log";
  const models::TrainingHistory log = models::load_training_log(file);
  if (log.training.empty()) return "not trained yet";
  return fmt::format("{} iterations, {}", log.training.back().iteration, duration(log.seconds()));
}

Json config_json(const ModelDirectory& model) {
  const std::filesystem::path file = models::ModelFiles{model.folder}.config();
  try {
    return Json::parse(read_file(file));
  } catch (const nlohmann::json::exception& error) {
    throw InvalidInput({{Severity::kError, file.string(), "$", "not-json", error.what()}});
  }
}

// What the head of the page says of the data; empty texts are left out.
struct DataFacts {
  std::string benchmark;
  std::size_t buildings = 0;
  std::string instructions;
};

Json about_json(const ReportConfig& config, const dataset::Dataset& data,
                const std::vector<ModelDirectory>& models, const DataFacts& of_data) {
  Json facts = Json::array();
  const auto add = [&facts](const std::string& name, const std::string& value) {
    if (!value.empty()) facts.push_back({name, value});
  };
  add("benchmark", of_data.benchmark);
  add("data", fmt::format("{}, {} buildings{}",
                          std::filesystem::weakly_canonical(data.folder()).filename().string(),
                          of_data.buildings, data.synthetic() ? " (synthetic model homes)" : ""));
  add("instructions", of_data.instructions);
  Json configs = Json::array();
  for (const ModelDirectory& model : models) {
    add("model " + model.agent, model_fact(model));
    configs.push_back({{"name", model.agent}, {"config", config_json(model)}});
  }
  for (const auto& [name, value] : config.facts) facts.push_back({name, value});
  return {{"title", config.title},
          {"synthetic", data.synthetic()},
          {"facts", std::move(facts)},
          {"models", std::move(configs)}};
}

Json continuous_page(const ReportConfig& config, const dataset::Dataset& data,
                     const Progress& progress) {
  const RunDirectory found = find_runs(config.runs, data, *config.benchmark);
  const ScoredRuns runs = score_runs(found, data, progress);
  std::string instructions;
  for (const auto& [split, episodes] : runs.continuous_splits) {
    instructions +=
        fmt::format("{}{} {}", instructions.empty() ? "" : ", ", split, episodes.episodes.size());
  }
  return {{"table", Json::parse(to_json(make_table(runs, data.synthetic())))},
          {"curves", parts::curves_part(found)},
          {"errors", parts::errors_part(runs)},
          {"walks", parts::walks_part(runs, config.episodes_of_a_kind, data.synthetic())},
          {"about", about_json(config, data, found.models,
                               {std::string(config.benchmark->title), runs.buildings->size(),
                                std::move(instructions)})}};
}

// Builds the page's data, one part after the other.
class Reporter {
 public:
  Reporter(const ReportConfig& config, const dataset::Dataset& data, const Progress& progress)
      : config_(config),
        data_(data),
        progress_(progress),
        found_(find_runs(config.runs, data, *config.benchmark)),
        runs_(score_runs(found_, data)),
        synthetic_(data.synthetic()) {
    const tasks::Task task = config.benchmark->task;
    const bool r2r = task == tasks::Task::kR2r;
    for (const std::string& split : r2r ? data.splits() : data.splits(task)) {
      splits_.push_back(r2r ? data.annotations(split) : data.annotations(task, split));
    }
  }

  Json run() {
    step("table", [this] { return Json::parse(to_json(make_table(runs_, synthetic_))); });
    step("curves", [this] { return parts::curves_part(found_); });
    step("errors", [this] { return parts::errors_part(runs_); });
    step("byLength", [this] { return parts::by_length_part(runs_); });
    step("gallery", [this] { return gallery(); });
    step("plans", [this] { return plans(); });
    step("examples", [this] { return parts::examples_part(splits_, data_, config_.examples); });
    step("panoramas", [this] { return parts::panoramas_part(data_, config_.panoramas); });
    step("lengths", [this] { return parts::lengths_part(splits_, runs_.graphs); });
    step("words", [this] { return parts::words_part(splits_); });
    page_["about"] = about();
    return std::move(page_);
  }

 private:
  static constexpr std::size_t kSteps = 10;

  void step(const char* name, const std::function<Json()>& make) {
    page_[name] = make();
    if (progress_) progress_(++done_, kSteps);
  }

  Json gallery() {
    chosen_run_ = parts::choose_run(runs_, found_);
    if (!chosen_run_) return parts::missing("There are no results that can be scored.");
    const tasks::EpisodeSet& episodes = runs_.splits.at(chosen_run_->run->split);
    chosen_ = choose_episodes(*chosen_run_, episodes, config_.episodes_of_a_kind);
    return gallery_part(*chosen_run_, episodes, chosen_, data_);
  }

  // The first of each kind in the gallery.
  Json plans() {
    if (!chosen_run_) return parts::missing("There are no results that can be scored.");
    std::vector<parts::ChosenEpisode> first;
    for (const parts::ChosenEpisode& one : chosen_) {
      if (first.empty() || first.back().kind != one.kind) first.push_back(one);
    }
    return plans_part(*chosen_run_->run, runs_.splits.at(chosen_run_->run->split), first);
  }

  Json about() const {
    std::string instructions;
    for (const tasks::Annotations& split : splits_) {
      std::size_t count = 0;
      for (const tasks::PathAnnotation& path : split.paths) count += path.instructions.size();
      instructions += fmt::format("{}{} {}", instructions.empty() ? "" : ", ", split.split, count);
    }
    return about_json(
        config_, data_, found_.models,
        {config_.benchmark->in_paper ? std::string() : std::string(config_.benchmark->title),
         runs_.graphs->size(), std::move(instructions)});
  }

  const ReportConfig& config_;
  const dataset::Dataset& data_;
  const Progress& progress_;
  RunDirectory found_;
  ScoredRuns runs_;
  std::vector<tasks::Annotations> splits_;
  bool synthetic_;
  std::optional<parts::GalleryRun> chosen_run_;
  std::vector<parts::ChosenEpisode> chosen_;
  Json page_;
  std::size_t done_ = 0;
};

}  // namespace

std::string make_report(const ReportConfig& config, const dataset::Dataset& data,
                        const Progress& progress) {
  const std::string title = data.synthetic() ? config.title + " (synthetic homes)" : config.title;
  return parts::make_page(title, config.benchmark->continuous()
                                     ? continuous_page(config, data, progress)
                                     : Reporter(config, data, progress).run());
}

}  // namespace enfilade::report
