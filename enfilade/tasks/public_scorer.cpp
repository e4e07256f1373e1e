#include "enfilade/tasks/public_scorer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks {
namespace {

using enum MeanRule;

constexpr std::string_view kHamt = "cshizhe/VLN-HAMT c8b9ee1";
constexpr std::string_view kDuet = "cshizhe/VLN-DUET 93e8b23";
constexpr std::string_view kValan =
    "google-research/valan 9fc6e38 r2r/eval_metric.py on the connectivity graph";
constexpr std::string_view kR4rAuthors = "google-research/google-research r4r/{cls,dtw}.py";
constexpr std::string_view kReverie = "YuankaiQi/REVERIE 0fe0955 eval_release.py";
constexpr std::string_view kCvdn = "mmurray/cvdn 97a4ae9 tasks/NDH/eval.py";
constexpr std::string_view kSoon = "ZhuFengdaaa/SOON 84d6285 r2r_src/eval.py";

// HAMT's metrics are DUET's except one: HAMT has one entry per action.
template <std::size_t kSize>
consteval std::array<ScorerMetric, kSize - 1> without_action_steps(
    const std::array<ScorerMetric, kSize>& metrics) {
  std::array<ScorerMetric, kSize - 1> left{};
  std::ranges::copy_if(metrics, left.begin(), [](const ScorerMetric& metric) {
    return std::string_view(metric.name) != "action_steps";
  });
  return left;
}

constexpr auto kDuetMetrics = std::to_array<ScorerMetric>({
    {"nav_error"},
    {"oracle_error"},
    {"action_steps"},
    {"trajectory_steps", "steps"},
    {"trajectory_lengths", "lengths"},
    {"success", "sr", kPlain, 100},
    {"spl", nullptr, kPlain, 100},
    {"oracle_success", "oracle_sr", kPlain, 100},
    {"DTW", nullptr, kNone},
    {"nDTW", nullptr, kPlain, 100},
    {"SDTW", nullptr, kPlain, 100},
    {"CLS", nullptr, kPlain, 100},
});
constexpr auto kHamtMetrics = without_action_steps(kDuetMetrics);
constexpr auto kValanMetrics = std::to_array<ScorerMetric>({
    {"ne"},
    {"sr"},
    {"osr"},
    {"spl"},
    {"path_length"},
    {"num_steps"},
    {"dtw_over_length"},
    {"ndtw"},
    {"sdtw"},
    {"cls"},
});
constexpr auto kR4rMetrics = std::to_array<ScorerMetric>({
    {"dtw"},
    {"ndtw"},
    {"sdtw"},
    {"cls", nullptr, kNone},
});
constexpr auto kBackMetrics = std::to_array<ScorerMetric>({
    {"nav_error"},
    {"trajectory_steps", "steps"},
    {"trajectory_lengths", "lengths"},
    {"success", "sr", kPlain, 100},
    {"spl", nullptr, kPlain, 100},
    {"DTW", nullptr, kNone},
    {"nDTW", nullptr, kPlain, 100},
    {"SDTW", nullptr, kPlain, 100},
    {"CLS", nullptr, kPlain, 100},
});
constexpr auto kReverieOfficialMetrics = std::to_array<ScorerMetric>({
    {"length"},
    {"success_rate"},
    {"oracle success_rate"},
    {"spl"},
    {"rgs"},
    {"rgspl"},
    {"shortest", nullptr, kNone},
});
constexpr auto kReverieDuetMetrics = std::to_array<ScorerMetric>({
    {"action_steps"},
    {"trajectory_steps", "steps"},
    {"trajectory_lengths", "lengths"},
    {"success", "sr", kPlain, 100},
    {"oracle_success", "oracle_sr", kPlain, 100},
    {"spl", nullptr, kPlain, 100},
    {"rgs", nullptr, kPlain, 100},
    {"rgspl", nullptr, kPlain, 100},
});
constexpr auto kReverieHamtMetrics = without_action_steps(kReverieDuetMetrics);
constexpr auto kCvdnOfficialMetrics = std::to_array<ScorerMetric>({
    {"length"},
    {"nav_error"},
    {"oracle success_rate"},
    {"success_rate"},
    {"spl"},
    {"oracle path_success_rate"},
    {"dist_to_end_reduction"},
});
constexpr auto kCvdnHamtMetrics = std::to_array<ScorerMetric>({
    {"trajectory_steps", "steps"},
    {"trajectory_lengths", "lengths"},
    {"success", "sr", kPlain, 100},
    {"oracle_success", "oracle_sr", kPlain, 100},
    {"spl", nullptr, kPlain, 100},
    {"gp"},
});
constexpr auto kProgressMetrics = std::to_array<ScorerMetric>({{"gp"}});
constexpr auto kSoonDuetMetrics = std::to_array<ScorerMetric>({
    {"det_success", "det_sr", kPlain, 100},
    {"action_steps", nullptr, kNone},
    {"trajectory_steps", "steps"},
    {"trajectory_lengths", "lengths"},
    {"nav_error"},
    {"oracle_error"},
    {"success", "sr", kPlain, 100},
    {"oracle_success", "oracle_sr", kPlain, 100},
    {"goal_progress"},
    {"spl", nullptr, kPlain, 100},
    {"det_spl", nullptr, kPlain, 100},
});
constexpr auto kSoonOfficialMetrics = std::to_array<ScorerMetric>({
    {"nav_error"},
    {"oracle_error"},
    {"steps"},
    {"lengths"},
    {"heading_errors", nullptr, kWhereDefined},
    {"elevation_errors", nullptr, kWhereDefined},
    {"point_det_errors", nullptr, kWhereDefined},
    {"goal_progress"},
    {"det_success_rate", nullptr, kGuarded},
    {"nav_success_rate", nullptr, kGuarded},
    {"oracle_rate", nullptr, kGuarded},
    {"spl"},
    {"success_rate"},
});

template <void (*kFormula)(const scorers::Scored&, scorers::Out)>
void run(const graph::NavGraph& graph, const ReferencePath& reference, const Trajectory& trajectory,
         std::span<double> out) {
  kFormula({graph, reference, trajectory}, out);
}

// By task, in the order of Task.
constexpr auto kScorers = std::to_array<PublicScorer>({
    {Task::kR2r, "duet", kDuet, kDuetMetrics, run<scorers::duet>},
    {Task::kR2r, "hamt", kHamt, kHamtMetrics, run<scorers::hamt>},
    {Task::kR2r, "valan", kValan, kValanMetrics, run<scorers::valan>},
    {Task::kR2r, "r4r_public", kR4rAuthors, kR4rMetrics, run<scorers::r4r_public>},
    {Task::kR2rLast, "hamt", kHamt, kHamtMetrics, run<scorers::hamt>},
    {Task::kR2rBack, "hamt", kHamt, kBackMetrics, run<scorers::hamt_back>},
    {Task::kR4r, "hamt", kHamt, kHamtMetrics, run<scorers::hamt>},
    {Task::kR4r, "duet", kDuet, kDuetMetrics, run<scorers::duet>},
    {Task::kR4r, "r4r_public", kR4rAuthors, kR4rMetrics, run<scorers::r4r_public>},
    {Task::kR4r, "valan", kValan, kValanMetrics, run<scorers::valan>},
    {Task::kRxr, "hamt", kHamt, kHamtMetrics, run<scorers::hamt>},
    {Task::kRxr, "r4r_public", kR4rAuthors, kR4rMetrics, run<scorers::r4r_public>},
    {Task::kRxr, "valan", kValan, kValanMetrics, run<scorers::valan>},
    {Task::kReverie, "official", kReverie, kReverieOfficialMetrics, run<scorers::reverie_official>},
    {Task::kReverie, "duet", kDuet, kReverieDuetMetrics, run<scorers::reverie_duet>},
    {Task::kReverie, "hamt", kHamt, kReverieHamtMetrics, run<scorers::reverie_hamt>},
    {Task::kCvdn, "official planner_path", kCvdn, kCvdnOfficialMetrics, run<scorers::cvdn_planner>},
    {Task::kCvdn, "official player_path", kCvdn, kCvdnOfficialMetrics, run<scorers::cvdn_player>},
    {Task::kCvdn, "official trusted_path", kCvdn, kCvdnOfficialMetrics, run<scorers::cvdn_trusted>},
    {Task::kCvdn, "hamt", kHamt, kCvdnHamtMetrics, run<scorers::cvdn_hamt>},
    {Task::kCvdn, "valan", kValan, kProgressMetrics, run<scorers::cvdn_valan>},
    {Task::kSoon, "duet", kDuet, kSoonDuetMetrics, run<scorers::soon_duet>},
    {Task::kSoon, "official", kSoon, kSoonOfficialMetrics, run<scorers::soon_official>},
});

double mean(const PublicScorer& scorer, std::size_t metric, std::span<const double> values) {
  const std::size_t width = scorer.metrics.size();
  const MeanRule rule = scorer.metrics[metric].rule;
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t at = metric; at < values.size(); at += width) {
    if (rule == kWhereDefined && std::isnan(values[at])) continue;
    sum += values[at];
    ++n;
  }
  if (rule == kNone || n == 0) return std::numeric_limits<double>::quiet_NaN();
  constexpr double kGuard = 1e-9;  // SOON's released scorer adds it to the number of episodes
  return sum / (static_cast<double>(n) + (rule == kGuarded ? kGuard : 0)) *
         scorer.metrics[metric].scale;
}

}  // namespace

std::span<const PublicScorer> public_scorers() noexcept { return kScorers; }

std::span<const PublicScorer> public_scorers(Task task) noexcept {
  const auto [begin, end] = std::ranges::equal_range(kScorers, task, {}, &PublicScorer::task);
  return {begin, end};
}

const PublicScorer& public_scorer(Task task, std::string_view name) {
  const auto known = public_scorers(task);
  const auto found = std::ranges::find(known, name, &PublicScorer::name);
  if (found != known.end()) return *found;
  std::vector<std::string_view> names;
  for (const PublicScorer& one : known) names.push_back(one.name);
  throw LookupError(
      fmt::format("no scorer {:?} for this task; there are {}", name, fmt::join(names, ", ")));
}

std::vector<double> summarise(const PublicScorer& scorer, std::span<const double> values) {
  const std::size_t width = scorer.metrics.size();
  EN_CHECK_EQ(values.size() % width, std::size_t{0});
  std::vector<double> means(width);
  for (std::size_t metric = 0; metric < width; ++metric) {
    means[metric] = mean(scorer, metric, values);
  }
  return means;
}

}  // namespace enfilade::tasks
