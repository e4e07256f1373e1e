#include "enfilade/tasks/statistics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <ranges>
#include <set>
#include <unordered_map>

#include "enfilade/core/check.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::tasks {
namespace {

constexpr std::size_t kLeastOccurrences = 5;  // occurrences of a word of the vocabulary
constexpr std::size_t kFirstWords = 4;

using Counts = std::unordered_map<std::string, std::size_t>;

// Gathers the numbers of one split, or of several.
class Gathering {
 public:
  explicit Gathering(std::string name) { result_.split = std::move(name); }

  void add_path(const PathAnnotation& entry, const ReferencePath& path,
                const graph::NavGraph& graph) {
    ++result_.paths;
    scans_.insert(entry.scan);
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

  SplitStatistics finish() {
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
        // Of an edge and its reverse, only the one from the lower index counts.
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
                                     std::size_t top) {
  DatasetStatistics result;
  Gathering all("all");
  Counts first_words;
  for (const Annotations& annotations : splits) {
    Gathering split(annotations.split);
    const std::vector<ReferencePath> paths = look_up_paths(annotations, *graphs);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const PathAnnotation& entry = annotations.paths[i];
      const graph::NavGraph& graph = graphs->graph(paths[i].scan);
      split.add_path(entry, paths[i], graph);
      all.add_path(entry, paths[i], graph);
      for (std::size_t k = 0; k < entry.instructions.size(); ++k) {
        const std::vector<std::string> tokens = tokenize(entry.instructions[k]);
        split.add_instruction(tokens, k < kScoredInstructions);
        all.add_instruction(tokens, k < kScoredInstructions);
        count_first_words(tokens, first_words);
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
