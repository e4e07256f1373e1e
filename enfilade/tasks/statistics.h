/// \file  Statistics of a data set: the paper's section 4 for any annotations.
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// Summary of a sample of numbers.
struct Summary {
  std::size_t count = 0;
  double mean = 0, deviation = 0;  ///< sample standard deviation
  double min = 0, median = 0, max = 0;
};
Summary summarise(std::vector<double> values);

/// Largest distance between the distribution functions of two samples (Kolmogorov-Smirnov), in [0,
/// 1]. Also the chance of one as large if both came from one distribution (asymptotic formula; for
/// discrete values too large, i.e. cautious).
/// \pre neither is empty
struct TwoSample {
  double statistic = 0;
  double p_value = 1;
};
TwoSample kolmogorov_smirnov(std::vector<double> a, std::vector<double> b);

/// Facts of some benchmarks beside paths and words. 0 or empty if a split has none.
struct TaskFacts {
  std::size_t hidden_goals = 0;                  ///< paths whose goal is not in the file
  std::map<std::string, std::size_t> languages;  ///< language -> instructions
  std::size_t objects = 0;                       ///< different ones that are goals, by building
  std::size_t targets = 0;                       ///< different names of searched objects
  std::size_t boxes = 0;                         ///< of SOON's goals
  Summary goal_viewpoints;  ///< how many satisfy a goal: see the object, are of the region, ...
  Summary turns;            ///< per dialogue, both people's; instructions without one count 0
  Summary timed_words;      ///< of instructions that have some
  Summary parts;            ///< sub-instructions, likewise
  Summary tokens;           ///< token ids, likewise
};

/// Numbers about the paths and instructions of one split.
struct SplitStatistics {
  std::string split;
  std::size_t scans = 0, paths = 0;
  std::size_t instructions = 0;         ///< all
  std::size_t scored_instructions = 0;  ///< R2R: the first three of each path; else all
  Summary path_length;                  ///< metres along the graph; paths with a known goal only
  std::map<std::size_t, std::size_t> path_edges;  ///< number of edges -> paths
  Summary instruction_length;                     ///< tokens
  std::size_t vocabulary = 0;                     ///< different tokens
  std::size_t vocabulary_5 = 0;                   ///< of those, with 5 or more occurrences
  TaskFacts task;
};

/// Numbers about navigation graphs; means are over all viewpoints or edges.
struct GraphStatistics {
  std::size_t graphs = 0, viewpoints = 0;  ///< included ones
  double viewpoints_per_graph = 0;
  double degree = 0;    ///< mean
  Summary edge_length;  ///< metres, each undirected edge once
};

/// Numbers about a data set.
struct DatasetStatistics {
  std::vector<SplitStatistics> splits;
  SplitStatistics all;  ///< the splits taken together; its split is "all"
  GraphStatistics graphs;
  /// First four words of instructions, most frequent first: the paper's sunburst, cut to `top`.
  std::vector<std::pair<std::string, std::size_t>> first_words;
};

/// \param objects  boxes of REVERIE's goals; without them their viewpoints are not counted
/// \throws as make_episodes() for annotations that do not fit the graphs
DatasetStatistics compute_statistics(std::span<const Annotations> splits,
                                     const std::shared_ptr<const graph::GraphSet>& graphs,
                                     std::size_t top = 20, const ObjectBoxes* objects = nullptr);

/// As text for people, and as JSON.
std::string to_table(const DatasetStatistics& statistics);
std::string to_json(const DatasetStatistics& statistics);

}  // namespace enfilade::tasks
