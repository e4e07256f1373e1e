#include "tests/conformance/doubtful.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::tests {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using tasks::Task;

std::string first_words(const std::string& text) {
  const std::size_t colon = text.find(':');
  return text.substr(0, colon);
}

// An entry of R2R's form around a recorded reference path.
Json entry_of(const Json& input, const Json& all) {
  // Of the first input, which has every instruction of the path.
  const Json& complete = all.at("behaviour").front().at("predictions");
  const auto id = complete.front().at("instr_id").get<std::string>();
  Json entry{{"path_id", std::stoi(id.substr(0, id.find('_')))},
             {"scan", input.at("scan")},
             {"heading", 0},
             {"path", input.at("reference")},
             {"distance", 1},
             {"instructions", Json::array()}};
  for (std::size_t k = 0; k < complete.size(); ++k) entry["instructions"].push_back("Go.");
  if (input.contains("midstop")) entry["midstop"] = input["midstop"];
  return Json::array({entry});
}

// Of REVERIE, an id stands for an entry of the real files.
Json entry_named(const std::string& id, const fs::path& data) {
  for (const char* file : {"reverie/v1/REVERIE_val_unseen.json", "reverie/v1/REVERIE_val_seen.json",
                           "reverie/v2/REVERIE_val_unseen.json"}) {
    for (const Json& entry : Json::parse(read_text_file(data / file))) {
      if (entry.at("id") == id) return Json::array({entry});
    }
  }
  throw FileError(fmt::format("{}: no entry {:?} of REVERIE", data.string(), id));
}

Json annotations_of(const Json& input, const Json& all, const fs::path& data) {
  if (!input.contains("annotations") || input["annotations"].is_null()) return entry_of(input, all);
  const Json& annotations = input["annotations"];
  return annotations.is_string() ? entry_named(annotations.get<std::string>(), data) : annotations;
}

std::string codes_of(const InvalidInput& refused) {
  std::set<std::string> codes;
  for (const Diagnostic& fault : refused.diagnostics()) codes.insert(fault.code);
  return fmt::format("fault: {}", fmt::join(codes, ", "));
}

bool same_means(const tasks::ScoreTable& score, const Json& means) {
  for (std::size_t k = 0; k < score.means.size(); ++k) {
    const tasks::ScorerMetric& metric = score.scorer->metrics[k];
    if (metric.rule == tasks::MeanRule::kNone) continue;
    const auto theirs = means.find(metric.mean_name());
    if (theirs == means.end()) return false;
    const double ours = score.means[k].mean;
    if (theirs->is_string() ? !std::isnan(ours) : std::abs(ours - theirs->get<double>()) > 1e-9) {
      return false;
    }
  }
  return true;
}

// "official, its validation mode" is the official one.
std::string scorer_name(const std::string& name) { return name.substr(0, name.find(',')); }

std::string ours_of(const Json& input, const Json& annotations, Task task,
                    const std::shared_ptr<const graph::GraphSet>& graphs,
                    const tasks::ObjectBoxes& objects) {
  try {
    const auto episodes = tasks::make_episodes(
        tasks::parse_annotations(annotations.dump(), "annotations", "made", task), graphs,
        tasks::Instructions::kAll, &objects);
    const auto results = tasks::parse_results(input.at("predictions").dump(), "results", episodes);
    const auto& scorer =
        tasks::benchmark(task).scorer(scorer_name(input.at("scorer").get<std::string>()));
    const auto score =
        tasks::compute_score(results.trajectories, episodes, scorer, {.bootstrap_samples = 0});
    const Json& outcome = input.at("outcome");
    const bool means = outcome.contains("means") && !outcome["means"].contains("error");
    if (!means) return "scored";
    return same_means(score, outcome["means"]) ? "the same means" : "other means";
  } catch (const InvalidInput& refused) {
    return codes_of(refused);
  } catch (const ArgumentError&) {
    return "fault: the goal is hidden";
  }
}

std::string theirs_of(const Json& outcome) {
  if (outcome.contains("error")) return first_words(outcome["error"].get<std::string>());
  const Json& means = outcome.at("means");
  return means.contains("error") ? first_words(means["error"].get<std::string>()) : "means";
}

}  // namespace

std::vector<DoubtfulInput> doubtful_inputs(const fs::path& file, const fs::path& data,
                                           const std::shared_ptr<const graph::GraphSet>& graphs) {
  std::vector<DoubtfulInput> rows;
  try {
    const Json all = Json::parse(read_file(file));
    std::string name = file.stem().string();
    std::replace(name.begin(), name.end(), '_', '-');
    const Task task = tasks::benchmark(name, tasks::WorldKind::kGraph).task;
    const auto objects = task == Task::kReverie
                             ? tasks::ObjectBoxes::load(data / "reverie/BBox.json.gz")
                             : tasks::ObjectBoxes();
    for (const Json& input : all.at("behaviour")) {
      rows.push_back({input.at("scorer").get<std::string>(), input.at("case").get<std::string>(),
                      theirs_of(input.at("outcome")),
                      ours_of(input, annotations_of(input, all, data), task, graphs, objects)});
    }
  } catch (const Json::exception& error) {
    throw FileError(fmt::format("{}: not of the form expected: {}", file.string(), error.what()));
  }
  return rows;
}

}  // namespace enfilade::tests
