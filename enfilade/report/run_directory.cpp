#include "enfilade/report/run_directory.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/files.h"

namespace enfilade::report {
namespace {

namespace fs = std::filesystem;

// The order of the paper's table, then by name; seeds by their number ("-10" after "-2").
std::tuple<std::size_t, std::string, std::size_t, std::string> rank(const std::string& agent) {
  constexpr std::array<std::string_view, 5> kFirst{"shortest", "reference", "random", "teacher",
                                                   "student"};
  const std::string base(without_seed(agent));
  const auto known = std::ranges::find_if(
      kFirst, [&](std::string_view name) { return std::string_view(base).starts_with(name); });
  return {static_cast<std::size_t>(known - kFirst.begin()), base, agent.size(), agent};
}

// Whether the folder is a model directory.
bool is_model(const fs::path& folder) {
  std::error_code code;
  return fs::exists(models::ModelFiles{folder}.config(), code);
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder, code)) paths.push_back(entry.path());
  if (code) throw FileError(fmt::format("{}: {}", folder.string(), code.message()));
  std::ranges::sort(paths);
  return paths;
}

// "val_seen.json.gz" -> "val_seen". No value for files with other endings.
std::optional<std::string> json_stem(const fs::path& file) { return name_before(file, ".json"); }

// The files of a folder that may be results.
std::vector<fs::path> json_files(const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code)) return {};
  std::vector<fs::path> files;
  for (const fs::path& path : entries(folder)) {
    if (json_stem(path) && fs::is_regular_file(path, code)) files.push_back(path);
  }
  return files;
}

// Enough for the first pose of a walk.
std::string beginning_of(const fs::path& file) {
  return text_beginning(file, std::size_t{64} << 10U);
}

// The first character of a text that is not blank; none of an empty one.
char first_sign(const fs::path& file) {
  const std::string text = text_beginning(file, 1024);
  const std::string_view first = trimmed(text);
  return first.empty() ? '\0' : first.front();
}

// The files that are named, and those in named folders and their results/.
std::vector<fs::path> candidates(std::span<const fs::path> named) {
  std::vector<fs::path> files;
  for (const fs::path& name : named) {
    const fs::path one = find_text_file(name);
    std::error_code code;
    if (!fs::exists(one, code)) continue;  // find_runs() says so
    if (!fs::is_directory(one, code)) {
      files.push_back(one);
      continue;
    }
    for (const fs::path& folder : {one, one / "results"}) {
      for (const fs::path& file : json_files(folder)) files.push_back(file);
    }
  }
  return files;
}

class Finder {
 public:
  Finder(const dataset::Dataset& data, const tasks::Benchmark& benchmark)
      : data_(data), begin_(benchmark.continuous() ? '{' : '[') {
    found_.benchmark = &benchmark;
  }

  void add(const fs::path& name) {
    const fs::path named = find_text_file(name);
    std::error_code code;
    if (!fs::exists(named, code)) {
      throw FileError(fmt::format(
          "{}: there is none; a results file or the folder of a run is expected", named.string()));
    }
    if (fs::is_directory(named, code)) {
      add_folder(named);
    } else {
      add_file(named);
    }
  }

  RunDirectory take() {
    const auto by_agent = [](const auto& a, const auto& b) {
      return rank(a.agent) < rank(b.agent);
    };
    std::ranges::stable_sort(found_.results, by_agent);
    std::ranges::stable_sort(found_.models, by_agent);
    return std::move(found_);
  }

 private:
  bool has_split(const std::string& split) const {
    return data_.has_split(*found_.benchmark, split);
  }
  // A file that is of neither is loaded, which says what is wrong with it.
  bool is_other(const fs::path& file) const {
    const char first = first_sign(file);
    return first != begin_ && (first == '[' || first == '{');
  }

  void add_folder(const fs::path& folder) {
    if (is_model(folder)) {
      add_model(folder);
      return;
    }
    add_results_of(folder);
    std::error_code code;
    if (fs::is_directory(folder / "results", code)) add_results_of(folder / "results");
    if (!fs::is_directory(folder / "models", code)) return;
    for (const fs::path& path : entries(folder / "models")) {
      if (is_model(path)) add_model(path);
    }
  }

  void add_model(const fs::path& folder) {
    // weakly_canonical(): "models/student/" and "." have no filename().
    const fs::path whole = fs::weakly_canonical(folder);
    const std::string agent = whole.filename().string();
    if (!models_.insert(whole).second) return;
    found_.models.push_back({folder, agent});
    std::error_code code;
    if (!fs::is_directory(folder / "results", code)) return;
    for (const fs::path& path : entries(folder / "results")) {
      const auto split = json_stem(path);
      if (!split || !has_split(*split) || is_other(path)) continue;
      add_results(path, agent, *split);
    }
  }

  void add_results_of(const fs::path& folder) {
    for (const fs::path& path : entries(folder)) {
      if (!json_stem(path) || is_other(path)) continue;
      if (const auto name = parse(path)) add_results(path, name->first, name->second);
    }
  }

  void add_file(const fs::path& file) {
    // "models/student/results/val_seen.json": its agent is the folder's name.
    const fs::path whole = fs::weakly_canonical(file);
    const fs::path owner = whole.parent_path().parent_path();
    const std::string split = json_stem(whole).value_or(whole.stem().string());
    if (is_model(owner) && has_split(split)) {
      add_results(file, owner.filename().string(), split);
      return;
    }
    const auto name = parse(file);
    if (!name) {
      throw LookupError(
          fmt::format("{}: its name says no split of {}; AGENT_SPLIT.json is expected, such as "
                      "random_val_unseen.json",
                      file.string(), data_.folder().string()));
    }
    add_results(file, name->first, name->second);
  }

  // "random_val_unseen.json" -> random, val_unseen. The longest split that fits, so that an agent
  // may have "_" in its name, and a split too.
  std::optional<std::pair<std::string, std::string>> parse(const fs::path& file) {
    const std::string stem = json_stem(file).value_or(file.stem().string());
    for (std::size_t at = stem.find('_', 1); at != std::string::npos; at = stem.find('_', at + 1)) {
      const std::string split = stem.substr(at + 1);
      if (has_split(split)) return std::pair(stem.substr(0, at), split);
    }
    return std::nullopt;
  }

  void add_results(const fs::path& file, const std::string& agent, const std::string& split) {
    for (const ResultsFile& other : found_.results) {
      if (other.agent != agent || other.split != split) continue;
      std::error_code code;
      if (fs::equivalent(other.file, file, code)) return;
      if (file == other.file.string() + ".gz") return;  // packed beside it: the plain one counts
      throw LookupError(fmt::format("{} and {} are both of agent {} on {}; name one of them",
                                    other.file.string(), file.string(), agent, split));
    }
    found_.results.push_back({file, agent, split});
  }

  const dataset::Dataset& data_;
  char begin_;  // of results files
  RunDirectory found_;
  std::set<fs::path> models_;
};

}  // namespace

std::string_view without_seed(std::string_view agent) noexcept {
  const std::size_t end = agent.find_last_not_of("0123456789");
  const bool seeded =
      end != std::string_view::npos && end > 0 && end + 1 < agent.size() && agent[end] == '-';
  return seeded ? agent.substr(0, end) : agent;
}

bool is_oracle(std::string_view agent) noexcept {
  const std::string_view name = without_seed(agent);
  return name == "shortest" || name == "reference";
}

namespace {

// That of walks in continuous space, by the first record; none if results of the graph come first.
const tasks::Benchmark* find_continuous(std::span<const fs::path> named) {
  for (const fs::path& file : candidates(named)) {
    std::string text = beginning_of(file);
    std::erase_if(text, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
    if (text.starts_with('[')) return nullptr;  // of the graph
    const std::string_view record = std::string_view(text).substr(0, text.find('}'));
    const auto has = [record](std::string_view what) {
      return record.find(what) != std::string_view::npos;
    };
    if (!record.starts_with("{\"")) continue;
    if (has("\"instruction_id\":") && has("\"path\":[[")) {
      return &tasks::benchmark("rxr-ce");
    }
    if (has("\":[{\"") && has("\"position\":[") && has("\"stop\":")) {
      return &tasks::benchmark("r2r-ce");
    }
  }
  return nullptr;
}

}  // namespace

const tasks::Benchmark* find_benchmark_of_runs(std::span<const fs::path> named) {
  if (const tasks::Benchmark* found = find_continuous(named)) return found;
  for (const fs::path& file : candidates(named)) {
    if (const auto task = tasks::find_task_of_results(read_text_file(file))) {
      return &tasks::benchmark(*task);
    }
  }
  return nullptr;
}

RunDirectory find_runs(std::span<const fs::path> named, const dataset::Dataset& data,
                       const tasks::Benchmark& benchmark) {
  Finder finder(data, benchmark);
  for (const fs::path& path : named) finder.add(path);
  RunDirectory found = finder.take();
  if (found.results.empty() && found.models.empty()) {
    std::vector<std::string> names;
    for (const fs::path& path : named) names.push_back(path.string());
    throw LookupError(fmt::format(
        "{}: no results file AGENT_SPLIT.json and no model directory, here or in results/ and "
        "models/",
        fmt::join(names, ", ")));
  }
  return found;
}

namespace {

using tasks::Trajectories;

RunScores score(const Trajectories& trajectories, const tasks::Split& split,
                const continuous::Buildings* buildings) {
  const tasks::Benchmark& benchmark = split.benchmark();
  const auto by = [&](const tasks::Scorer& scorer) {
    return agents::compute_score(trajectories, split, buildings, scorer);
  };
  RunScores scores{by(split.on_graph() ? tasks::own_scorer() : benchmark.scorers.front())};
  if (!benchmark.table_scorer.empty()) {
    scores.by_task = by(benchmark.scorer(benchmark.table_scorer));
  }
  return scores;
}

// Empty in continuous space.
std::map<std::string, RunScores> score_languages(const Trajectories& trajectories,
                                                 const tasks::Split& split) {
  std::map<std::string, RunScores> scores;
  if (!split.on_graph() || !split.benchmark().languages) return scores;
  std::map<std::string, std::vector<tasks::Trajectory>> by_language;
  for (const auto& one : std::get<std::vector<tasks::Trajectory>>(trajectories)) {
    const std::string& language = split.on_graph()->episodes[one.episode].details.language;
    if (!language.empty()) by_language[language].push_back(one);
  }
  for (auto& [language, walks] : by_language) {
    Trajectories part = std::move(walks);
    const tasks::Split there = part_of(split, part);
    scores.emplace(language, score(part, there, nullptr));
  }
  return scores;
}

}  // namespace

ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress) {
  const tasks::Benchmark& benchmark = *found.benchmark;
  ScoredRuns scored;
  scored.benchmark = &benchmark;
  scored.buildings = agents::open_buildings(benchmark, data.folder());
  if (!scored.buildings) scored.graphs = data.graphs();
  std::size_t done = 0;
  for (const ResultsFile& file : found.results) {
    if (!scored.splits.contains(file.split)) {
      scored.splits.emplace(file.split, data.split(benchmark, file.split));
    }
    const tasks::Split& split = scored.splits.at(file.split);
    if (split.goals_hidden()) {
      scored.left_out.push_back(
          fmt::format("{} on {}: the goals of this split are hidden", file.agent, file.split));
    } else {
      ScoredRun& run = scored.runs.emplace_back(ScoredRun{file.agent, file.split});
      run.trajectories = tasks::load_trajectories(file.file, split);
      run.scores = score(run.trajectories, split, scored.buildings.get());
      run.languages = score_languages(run.trajectories, split);
    }
    if (progress) progress(++done, found.results.size());
  }
  return scored;
}

}  // namespace enfilade::report
