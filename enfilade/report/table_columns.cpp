// What the table of each benchmark shows, and what others published.
#include <array>
#include <limits>

#include "enfilade/report/results_table.h"

namespace enfilade::report {
namespace {

using tasks::Task;

constexpr double kAny = -std::numeric_limits<double>::infinity();

constexpr auto kR2r = std::to_array<TableColumn>({
    {"trajectory_length", "TL (m)"},
    {"nav_error", "NE (m)"},
    {"success", "SR (%)", 100, 1},
    {"oracle_success", "OSR (%)", 100, 1},
    {"spl", "SPL (%)", 100, 1},
});
// SPL against the length of the reference path, as HAMT has it.
constexpr auto kR2rLast = std::to_array<TableColumn>({
    {"trajectory_length", "TL (m)", 1, 2, "lengths"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
    {"success", "SR (%)", 100, 1, "sr"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle_sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
});
constexpr auto kR2rBack = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
    {"trajectory_length", "TL (m)", 1, 2, "lengths"},
});
// The star: turns on the spot are taken once (docs/design/dtw-of-turns.md).
constexpr auto kR4r = std::to_array<TableColumn>({
    {"ndtw_collapsed", "nDTW* (%)", 100, 1},
    {"sdtw_collapsed", "SDTW* (%)", 100, 1},
    {"cls", "CLS (%)", 100, 1, "CLS"},
    {"ndtw", "nDTW (%)", 100, 1, "nDTW"},
    {"success", "SR (%)", 100, 1, "sr"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
});
constexpr auto kRxr = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "sr"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
    {"ndtw_collapsed", "nDTW* (%)", 100, 1},
    {"sdtw_collapsed", "SDTW* (%)", 100, 1},
    {"ndtw", "nDTW (%)", 100, 1, "nDTW"},
    {"sdtw", "SDTW (%)", 100, 1, "SDTW"},
});
constexpr auto kReverie = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "success_rate"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle success_rate"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"rgs", "RGS (%)", 100, 1, "rgs"},
    {"rgspl", "RGSPL (%)", 100, 1, "rgspl"},
});
constexpr auto kCvdn = std::to_array<TableColumn>({
    {"goal_progress", "GP (m)", 1, 2, "gp", kAny},
    {"success", "SR (%)", 100, 1, "sr"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle_sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"trajectory_length", "TL (m)", 1, 2, "lengths"},
});
constexpr auto kSoon = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle_sr"},
    {"detection_spl", "FSPL (%)", 100, 1, "det_spl"},
    {"detection", "found (%)", 100, 1, "det_sr"},
});

constexpr auto kContinuous = std::to_array<TableColumn>({
    {"path_length", "TL (m)"},
    {"distance_to_goal", "NE (m)"},
    {"success", "SR (%)", 100, 1},
    {"oracle_success", "OSR (%)", 100, 1},
    {"spl", "SPL (%)", 100, 1},
    {"ndtw", "nDTW (%)", 100, 1},
    {"sdtw", "SDTW (%)", 100, 1},
});

constexpr const char* kNaviLlm = "README of zd11024/NaviLLM";
constexpr const char* kNavGpt2 = "README of GengzeZhou/NavGPT-2";

// Read in these texts on 2026-11-22.
constexpr auto kResults = std::to_array<PublishedResult>({
    {Task::kR2r, "Speaker-Follower, greedy", "its README", 0.355, {}, {}},
    {Task::kR2r,
     "EnvDrop with back-translation, PyTorch 1.7.1",
     "README of airsplay/R2R-EnvDrop",
     0.535,
     0.488,
     {}},
    {Task::kR2r, "NaviLLM", kNaviLlm, 0.67, 0.59, {}},
    {Task::kR2r, "NavGPT-2 XL", kNavGpt2, 0.6989, 0.5886, {}},
    {Task::kR2r, "NavGPT-2 XXL", kNavGpt2, 0.7382, 0.6106, {}},
    {Task::kReverie, "NaviLLM", kNaviLlm, 0.4215, 0.3568, {}},
    {Task::kReverie, "NaviLLM without pretraining", kNaviLlm, 0.4456, 0.3663, {}},
    {Task::kCvdn, "NaviLLM", kNaviLlm, {}, {}, 6.16},
    {Task::kSoon, "NaviLLM", kNaviLlm, 0.3833, 0.2924, {}},
});

}  // namespace

std::span<const TableColumn> table_columns(const tasks::Benchmark& benchmark) noexcept {
  if (benchmark.continuous()) return kContinuous;
  switch (benchmark.task) {
    case Task::kR2r:
      return kR2r;
    case Task::kR2rLast:
      return kR2rLast;
    case Task::kR2rBack:
      return kR2rBack;
    case Task::kR4r:
      return kR4r;
    case Task::kRxr:
      return kRxr;
    case Task::kReverie:
      return kReverie;
    case Task::kCvdn:
      return kCvdn;
    case Task::kSoon:
      return kSoon;
  }
  return kR2r;
}

std::span<const PublishedResult> published_results() noexcept { return kResults; }

}  // namespace enfilade::report
