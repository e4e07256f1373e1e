#include "enfilade/report/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/training_log.h"
#include "enfilade/report/parts/gallery.h"
#include "enfilade/report/parts/page.h"
#include "enfilade/report/parts/parts.h"
#include "enfilade/report/results_table.h"
#include "enfilade/report/run_directory.h"
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

// Builds the page's data, one part after the other.
class Reporter {
 public:
  Reporter(const ReportConfig& config, const dataset::Dataset& data, const Progress& progress)
      : config_(config),
        data_(data),
        floor_(config.benchmark->continuous()),
        progress_(floor_ ? Progress() : progress),
        plans_(data),
        found_(find_runs(config.runs, data, *config.benchmark)),
        runs_(score_runs(found_, data, floor_ ? progress : Progress())),
        synthetic_(data.synthetic()) {
    if (floor_) return;
    for (const std::string& split : data.splits(*config.benchmark)) {
      splits_.push_back(data.annotations(config.benchmark->task, split));
    }
  }

  Json run() {
    step("table", [this] { return Json::parse(to_json(make_table(runs_, synthetic_))); });
    step("curves", [this] { return parts::curves_part(found_); });
    step("errors", [this] { return parts::errors_part(runs_); });
    if (floor_) {
      page_["walks"] = parts::walks_part(runs_, config_.episodes_of_a_kind, synthetic_);
    } else {
      add_graph_parts();
    }
    page_["about"] = about();
    return std::move(page_);
  }

 private:
  static constexpr std::size_t kSteps = 10;

  void add_graph_parts() {
    step("byLength", [this] { return parts::by_length_part(runs_); });
    step("gallery", [this] { return gallery(); });
    step("plans", [this] { return plans(); });
    step("examples", [this] { return parts::examples_part(splits_, data_, config_.examples); });
    step("panoramas", [this] { return parts::panoramas_part(data_, config_.panoramas); });
    step("lengths", [this] { return parts::lengths_part(splits_, runs_.graphs); });
    step("words", [this] { return parts::words_part(splits_); });
  }

  void step(const char* name, const std::function<Json()>& make) {
    page_[name] = make();
    if (progress_) progress_(++done_, kSteps);
  }

  Json gallery() {
    chosen_run_ = parts::choose_run(runs_, found_);
    if (!chosen_run_) return parts::missing("There are no results that can be scored.");
    const tasks::EpisodeSet& episodes = *runs_.split_of(*chosen_run_->run).on_graph();
    chosen_ = choose_episodes(*chosen_run_, episodes, parts::clear_scans(data_),
                              config_.episodes_of_a_kind);
    return gallery_part(*chosen_run_, episodes, chosen_, data_, plans_);
  }

  // The first of each kind in the gallery.
  Json plans() {
    if (!chosen_run_) return parts::missing("There are no results that can be scored.");
    std::vector<parts::ChosenEpisode> first;
    for (const parts::ChosenEpisode& one : chosen_) {
      if (first.empty() || first.back().kind != one.kind) first.push_back(one);
    }
    return plans_part(*chosen_run_->run, *runs_.split_of(*chosen_run_->run).on_graph(), first,
                      plans_);
  }

  // "train 14039, val_seen 1021": of all splits; in continuous space of those that runs have.
  std::string instructions() const {
    std::vector<std::string> counts;
    for (const tasks::Annotations& split : splits_) {
      std::size_t count = 0;
      for (const tasks::PathAnnotation& path : split.paths) count += path.instructions.size();
      counts.push_back(fmt::format("{} {}", split.split, count));
    }
    for (const auto& [name, split] : runs_.splits) {
      if (floor_) counts.push_back(fmt::format("{} {}", name, split.size()));
    }
    return fmt::format("{}", fmt::join(counts, ", "));
  }

  // The head of the page; empty texts are left out.
  Json about() const {
    Json facts = Json::array(), configs = Json::array();
    const auto add = [&facts](const std::string& name, std::string_view value) {
      if (!value.empty()) facts.push_back({name, value});
    };
    if (!config_.benchmark->in_paper) add("benchmark", config_.benchmark->title);
    add("data", fmt::format("{}, {} buildings{}",
                            std::filesystem::weakly_canonical(data_.folder()).filename().string(),
                            floor_ ? runs_.buildings->size() : runs_.graphs->size(),
                            synthetic_ ? " (synthetic model homes)" : ""));
    add("instructions", instructions());
    for (const ModelDirectory& model : found_.models) {
      add("model " + model.agent, model_fact(model));
      configs.push_back({{"name", model.agent}, {"config", config_json(model)}});
    }
    for (const auto& [name, value] : config_.facts) facts.push_back({name, value});
    return {{"title", config_.title},
            {"synthetic", synthetic_},
            {"facts", std::move(facts)},
            {"models", std::move(configs)}};
  }

  const ReportConfig& config_;
  const dataset::Dataset& data_;
  bool floor_;  // in continuous space: the page has fewer parts, and the scoring tells its progress
  Progress progress_;
  parts::BuildingPlans plans_;
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
  return parts::make_page(title, Reporter(config, data, progress).run());
}

}  // namespace enfilade::report
