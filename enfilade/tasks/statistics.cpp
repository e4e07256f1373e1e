#include "enfilade/tasks/statistics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <ranges>
#include <set>
#include <unordered_map>
#include <variant>

#include "enfilade/core/check.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::tasks {
namespace {

constexpr std::size_t kLeastOccurrences = 5;  // occurrences of a word of the vocabulary
constexpr std::size_t kFirstWords = 4;

using Counts = std::unordered_map<std::string, std::size_t>;

std::size_t goal_viewpoints(const Goal& goal) {
  if (const auto* object = std::get_if<SeenObject>(&goal)) return object->seen_from.size();
  if (const auto* region = std::get_if<Region>(&goal)) return region->viewpoints.size();
  const auto* boxes = std::get_if<Boxes>(&goal);
  if (boxes == nullptr) return 0;
  std::set<ViewpointIndex> different;
  for (const Box& box : boxes->boxes) different.insert(box.viewpoint);
  return different.size();
}

// Gathers what some benchmarks have beside paths and words.
class TaskGathering {
 public:
  void add_goal(const PathAnnotation& entry, const Goal& goal) {
    if (entry.goal_hidden()) ++facts_.hidden_goals;
    if (const auto* object = std::get_if<NamedObject>(&entry.goal)) {
      objects_.emplace(entry.scan, object->id);
    }
    if (const auto* region = std::get_if<NamedRegion>(&entry.goal)) add_target(region->target);
    if (const auto* boxes = std::get_if<NamedBoxes>(&entry.goal)) {
      facts_.boxes += boxes->boxes.size();
      for (const NamedBox& box : boxes->boxes) add_target(box.object);
    }
    if (const std::size_t n = goal_viewpoints(goal); n > 0) add(viewpoints_, n);
  }

  void add_details(const InstructionDetails& details, bool dialogue) {
    if (!details.language.empty()) ++facts_.languages[details.language];
    if (dialogue) add(turns_, details.turns.size());
    if (!details.words.empty()) add(words_, details.words.size());
    if (!details.parts.empty()) add(parts_, details.parts.size());
    if (!details.tokens.empty()) add(tokens_, details.tokens.size());
  }

  TaskFacts finish() {
    facts_.objects = objects_.size();
    facts_.targets = targets_.size();
    facts_.goal_viewpoints = summarise(std::move(viewpoints_));
    facts_.turns = summarise(std::move(turns_));
    facts_.timed_words = summarise(std::move(words_));
    facts_.parts = summarise(std::move(parts_));
    facts_.tokens = summarise(std::move(tokens_));
    return std::move(facts_);
  }

 private:
  static void add(std::vector<double>& values, std::size_t n) {
    values.push_back(static_cast<double>(n));
  }

  // Files may leave the name out.
  void add_target(const std::string& name) {
    if (!name.empty()) targets_.insert(name);
  }

  TaskFacts facts_;
  std::set<std::pair<std::string, std::int64_t>> objects_;
  std::set<std::string> targets_;
  std::vector<double> viewpoints_, turns_, words_, parts_, tokens_;
};

// Gathers the numbers of one split, or of several.
class Gathering {
 public:
  explicit Gathering(std::string name) { result_.split = std::move(name); }

  void add_path(const PathAnnotation& entry, const ReferencePath& path,
                const graph::NavGraph& graph) {
    ++result_.paths;
    scans_.insert(entry.scan);
    task_.add_goal(entry, path.goal);
    if (entry.goal_hidden()) return;
    path_lengths_.push_back(length_of(path, graph));
    ++result_.path_edges[path.viewpoints.size() - 1];
  }

  void add_instruction(const std::vector<std::string>& tokens, bool scored) {
    ++result_.instructions;
    for (const std::string& token : tokens) ++words_[token];
    if (!scored) return;
    ++result_.scored_instructions;
    instruction_lengths_.push_back(static_cast<double>(tokens.size()));
  }

  void add_details(const InstructionDetails& details, bool dialogue) {
    task_.add_details(details, dialogue);
  }

  SplitStatistics finish() {
    result_.task = task_.finish();
    result_.scans = scans_.size();
    result_.path_length = summarise(std::move(path_lengths_));
    result_.instruction_length = summarise(std::move(instruction_lengths_));
    result_.vocabulary = words_.size();
    for (const auto& [word, n] : words_) result_.vocabulary_5 += n >= kLeastOccurrences ? 1 : 0;
    return std::move(result_);
  }

 private:
  SplitStatistics result_;
  std::set<std::string> scans_;
  std::vector<double> path_lengths_;
  std::vector<double> instruction_lengths_;
  Counts words_;
  TaskGathering task_;
};

void count_first_words(const std::vector<std::string>& tokens, Counts& counts) {
  if (tokens.empty()) return;
  const auto first = std::views::take(tokens, kFirstWords);
  ++counts[fmt::format("{}", fmt::join(first, " "))];
}

std::vector<std::pair<std::string, std::size_t>> most_frequent(const Counts& counts,
                                                               std::size_t top) {
  std::vector<std::pair<std::string, std::size_t>> list(counts.begin(), counts.end());
  std::ranges::sort(list, [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  });
  list.resize(std::min(list.size(), top));
  return list;
}

GraphStatistics graph_statistics(const graph::GraphSet& graphs) {
  GraphStatistics result;
  graphs.load_all();
  result.graphs = graphs.size();
  std::size_t directed = 0;
  std::vector<double> lengths;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const graph::NavGraph& graph = graphs.graph(ScanIndex(i));
    result.viewpoints += graph.included_count();
    directed += graph.edge_count();
    for (std::size_t v = 0; v < graph.size(); ++v) {
      for (const graph::Edge& edge : graph.edges(ViewpointIndex(v))) {
        // An edge and its reverse count once, from the lower index.
        const bool second = edge.target < ViewpointIndex(v) &&
                            graph.edge(edge.target, ViewpointIndex(v)) != nullptr;
        if (!second) lengths.push_back(edge.length);
      }
    }
  }
  if (result.graphs > 0) {
    result.viewpoints_per_graph =
        static_cast<double>(result.viewpoints) / static_cast<double>(result.graphs);
  }
  if (result.viewpoints > 0) {
    result.degree = static_cast<double>(directed) / static_cast<double>(result.viewpoints);
  }
  result.edge_length = summarise(std::move(lengths));
  return result;
}

}  // namespace

Summary summarise(std::vector<double> values) {
  Summary summary;
  summary.count = values.size();
  if (values.empty()) return summary;
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size());
  for (const double value : values) summary.mean += value / n;
  double squares = 0;
  for (const double value : values) squares += (value - summary.mean) * (value - summary.mean);
  if (values.size() > 1) summary.deviation = std::sqrt(squares / (n - 1));
  summary.min = values.front();
  summary.max = values.back();
  const std::size_t half = values.size() / 2;
  summary.median = values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
  return summary;
}

TwoSample kolmogorov_smirnov(std::vector<double> a, std::vector<double> b) {
  EN_CHECK(!a.empty() && !b.empty());
  std::ranges::sort(a);
  std::ranges::sort(b);
  const auto n = static_cast<double>(a.size());
  const auto m = static_cast<double>(b.size());
  TwoSample result;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const double x = std::min(a[i], b[j]);
    while (i < a.size() && a[i] <= x) ++i;
    while (j < b.size() && b[j] <= x) ++j;
    result.statistic = std::max(result.statistic,
                                std::abs(static_cast<double>(i) / n - static_cast<double>(j) / m));
  }
  // Kolmogorov's distribution; below 0.2 its series converges too slowly and is 1 to 12 digits.
  const double x = result.statistic * std::sqrt(n * m / (n + m));
  if (x < 0.2) return result;
  double sum = 0;
  for (int k = 1; k <= 100; ++k) sum += (k % 2 == 1 ? 2 : -2) * std::exp(-2 * x * x * k * k);
  result.p_value = std::clamp(sum, 0.0, 1.0);
  return result;
}

DatasetStatistics compute_statistics(std::span<const Annotations> splits,
                                     const std::shared_ptr<const graph::GraphSet>& graphs,
                                     std::size_t top, const ObjectBoxes* objects) {
  DatasetStatistics result;
  Gathering all("all");
  Counts first_words;
  for (const Annotations& annotations : splits) {
    Gathering split(annotations.split);
    const std::size_t most = benchmark(annotations.task).scored_instructions;
    const std::vector<ReferencePath> paths = look_up_paths(annotations, *graphs, objects);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const PathAnnotation& entry = annotations.paths[i];
      const graph::NavGraph& graph = graphs->graph(paths[i].scan);
      split.add_path(entry, paths[i], graph);
      all.add_path(entry, paths[i], graph);
      for (std::size_t k = 0; k < entry.instructions.size(); ++k) {
        const std::vector<std::string> tokens = tokenize(entry.instructions[k]);
        const bool scored = most == 0 || k < most;
        split.add_instruction(tokens, scored);
        all.add_instruction(tokens, scored);
        count_first_words(tokens, first_words);
      }
      for (const InstructionDetails& details : entry.details) {
        const bool dialogue = annotations.task == Task::kCvdn;
        split.add_details(details, dialogue);
        all.add_details(details, dialogue);
      }
    }
    result.splits.push_back(split.finish());
  }
  result.all = all.finish();
  result.graphs = graph_statistics(*graphs);
  result.first_words = most_frequent(first_words, top);
  return result;
}

}  // namespace enfilade::tasks
