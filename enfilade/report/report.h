/// \file  The report: one HTML page that shows what was trained, how well it does, and on what.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::report {

/// What the report is about, and what a page can hold.
struct ReportConfig {
  std::vector<std::filesystem::path> runs;  ///< as find_runs() takes them
  /// What the results are of. In continuous space the page has a table, training, where agents
  /// stop, and maps of walks.
  const tasks::Benchmark* benchmark = &tasks::benchmark(tasks::Task::kR2r);
  std::string title = "Vision-and-language navigation";
  /// Named facts for its head, in order, such as {"machine", "..."}; what the data and the runs say
  /// of themselves comes before them.
  std::vector<std::pair<std::string, std::string>> facts;
  std::size_t examples = 3;            ///< paths at random, with their instructions
  std::size_t panoramas = 16;          ///< buildings, at most
  std::size_t episodes_of_a_kind = 3;  ///< best, worst, random: three times as many in all
};

/// An HTML document of a few megabytes that needs no other file and no network. Parts whose input
/// is missing (no pictures, no model) are named in one line at its end, with the reason. Pictures
/// are of buildings with at least 256 texels a face where there are any. The same input gives the
/// same page, except the random word that names its own scripts to the browser.
/// \throws as find_runs(), score_runs(), models::load_training_log() and
/// models::load_recorded_split(); Error if this build has no D3; errors of broken panoramas
std::string make_report(const ReportConfig& config, const dataset::Dataset& data,
                        const Progress& progress = {});

}  // namespace enfilade::report
