// Every scorer of every benchmark: its metrics by the names that its code prints, and the columns
// that tables and leaderboards show of it.
#include <algorithm>
#include <array>
#include <string_view>

#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {
namespace {

using enum MeanRule;

constexpr std::string_view kOfHamt = "cshizhe/VLN-HAMT c8b9ee1";
constexpr std::string_view kOfDuet = "cshizhe/VLN-DUET 93e8b23";
constexpr std::string_view kOfValan =
    "google-research/valan 9fc6e38 r2r/eval_metric.py on the connectivity graph";
constexpr std::string_view kOfR4rAuthors = "google-research/google-research r4r/{cls,dtw}.py";
constexpr std::string_view kOfReverie = "YuankaiQi/REVERIE 0fe0955 eval_release.py";
constexpr std::string_view kOfCvdn = "mmurray/cvdn 97a4ae9 tasks/NDH/eval.py";
constexpr std::string_view kOfSoon = "ZhuFengdaaa/SOON 84d6285 r2r_src/eval.py";
constexpr std::string_view kOfVlnCe =
    "jacobkrantz/VLN-CE 729d141 habitat_extensions/measures.py, nDTW and SDTW exact";
constexpr std::string_view kOfEtpNav = "MarSaKi/ETPNav 8dec13a ss_trainer_ETP.py";

// Metrics with plain means of their own names.
template <class... Names>
consteval std::array<ScorerMetric, sizeof...(Names)> plain(Names... names) {
  return {ScorerMetric{names}...};
}

// All but some.
template <std::size_t kSize, class... Names>
consteval std::array<ScorerMetric, kSize - sizeof...(Names)> without(
    const std::array<ScorerMetric, kSize>& metrics, Names... names) {
  std::array<ScorerMetric, kSize - sizeof...(Names)> left{};
  std::ranges::copy_if(metrics, left.begin(), [&](const ScorerMetric& metric) {
    return ((std::string_view(metric.name) != names) && ...);
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
constexpr auto kHamtMetrics = without(kDuetMetrics, "action_steps");  // HAMT has an entry an action
constexpr auto kValanMetrics = plain("ne", "sr", "osr", "spl", "path_length", "num_steps",
                                     "dtw_over_length", "ndtw", "sdtw", "cls");
constexpr auto kR4rMetrics = std::to_array<ScorerMetric>({
    {"dtw"},
    {"ndtw"},
    {"sdtw"},
    {"cls", nullptr, kNone},
});
constexpr auto kBackMetrics =
    without(kDuetMetrics, "oracle_error", "action_steps", "oracle_success");
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
constexpr auto kReverieHamtMetrics = without(kReverieDuetMetrics, "action_steps");
constexpr auto kCvdnOfficialMetrics =
    plain("length", "nav_error", "oracle success_rate", "success_rate", "spl",
          "oracle path_success_rate", "dist_to_end_reduction");
constexpr auto kCvdnHamtMetrics = std::to_array<ScorerMetric>({
    {"trajectory_steps", "steps"},
    {"trajectory_lengths", "lengths"},
    {"success", "sr", kPlain, 100},
    {"oracle_success", "oracle_sr", kPlain, 100},
    {"spl", nullptr, kPlain, 100},
    {"gp"},
});
constexpr auto kProgressMetrics = plain("gp");
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

consteval std::array<ScorerMetric, kMetricFields.size()> own_metrics() {
  std::array<ScorerMetric, kMetricFields.size()> metrics{};
  std::ranges::transform(kMetricFields, metrics.begin(),
                         [](const MetricField& field) { return ScorerMetric{field.name}; });
  return metrics;
}
constexpr auto kOwnMetrics = own_metrics();
constexpr auto kVlnCeMetrics =
    plain("path_length", "distance_to_goal", "success", "oracle_success", "spl", "ndtw", "sdtw",
          "ndtw_fastdtw", "steps_taken", "collisions");
constexpr auto kEtpNavMetrics = without(kVlnCeMetrics, "ndtw_fastdtw");

namespace columns {

constexpr double kPerCent = 100;

constexpr Measure spl(const char* name = "spl", double whole = 1) {
  return {name, "SPL", "Success weighted by path length", Unit::kShare, Better::kHigher, whole};
}
constexpr Measure success(const char* name, double whole = 1, const char* title = "Success rate") {
  return {name, "SR", title, Unit::kShare, Better::kHigher, whole};
}
constexpr Measure oracle(const char* name, double whole = 1,
                         const char* title = "Oracle success rate") {
  return {name, "OSR", title, Unit::kShare, Better::kHigher, whole};
}
constexpr Measure ndtw(const char* name, double whole = 1) {
  return {name, "nDTW", "Normalised dynamic time warping", Unit::kShare, Better::kHigher, whole};
}
constexpr Measure sdtw(const char* name, double whole = 1) {
  return {name, "sDTW", "Success weighted by nDTW", Unit::kShare, Better::kHigher, whole};
}
constexpr Measure cls(const char* name, double whole = 1) {
  return {name, "CLS", "Coverage weighted by length score", Unit::kShare, Better::kHigher, whole};
}
constexpr Measure error(const char* name) {
  return {name, "NE", "Navigation error", Unit::kMetres, Better::kLower};
}
constexpr Measure length(const char* name) {
  return {name, "TL", "Trajectory length", Unit::kMetres, Better::kNeither, 1, false};
}
constexpr Measure progress(const char* name) {
  return {name, "GP", "Goal progress", Unit::kMetres, Better::kHigher};
}
constexpr Measure rgs(double whole = 1) {
  return {"rgs",        "RGS",           "Remote grounding success: the object was named",
          Unit::kShare, Better::kHigher, whole};
}
constexpr Measure rgspl(double whole = 1) {
  return {"rgspl",      "RGSPL",         "Remote grounding success weighted by path length",
          Unit::kShare, Better::kHigher, whole};
}
constexpr Measure found(const char* name, double whole = 1) {
  return {name, "FSPL", "Detection weighted by path length", Unit::kShare, Better::kHigher, whole};
}
constexpr Measure detection(const char* name, double whole = 1) {
  return {name,         "Det",           "Detection: the point is in the object's box",
          Unit::kShare, Better::kHigher, whole};
}

// Of each scorer in the order of a table: what ranks first, then the rest as papers have it.
constexpr auto kOwn = std::to_array<Measure>(
    {spl(), success("success"), oracle("oracle_success"), error("nav_error"),
     ndtw("ndtw_collapsed"), sdtw("sdtw_collapsed"), cls("cls"), length("trajectory_length")});
// HAMT's and DUET's of one walk to the end of a path.
constexpr auto kSpl = std::to_array<Measure>({spl("spl", kPerCent), success("sr", kPerCent),
                                              oracle("oracle_sr", kPerCent), error("nav_error"),
                                              ndtw("nDTW", kPerCent), sdtw("SDTW", kPerCent),
                                              cls("CLS", kPerCent), length("lengths")});
constexpr auto kBack = std::to_array<Measure>(
    {spl("spl", kPerCent),
     success("sr", kPerCent, "Success rate, of the turning point and the end"), error("nav_error"),
     ndtw("nDTW", kPerCent), sdtw("SDTW", kPerCent), cls("CLS", kPerCent), length("lengths")});
constexpr auto kR4r = std::to_array<Measure>(
    {sdtw("SDTW", kPerCent), ndtw("nDTW", kPerCent), cls("CLS", kPerCent), success("sr", kPerCent),
     spl("spl", kPerCent), oracle("oracle_sr", kPerCent), error("nav_error"), length("lengths")});
constexpr auto kRxr = std::to_array<Measure>(
    {ndtw("nDTW", kPerCent), sdtw("SDTW", kPerCent), success("sr", kPerCent), spl("spl", kPerCent),
     oracle("oracle_sr", kPerCent), cls("CLS", kPerCent), error("nav_error"), length("lengths")});
constexpr auto kValan =
    std::to_array<Measure>({spl(), success("sr"), oracle("osr"), error("ne"), ndtw("ndtw"),
                            sdtw("sdtw"), cls("cls"), length("path_length")});
constexpr auto kValanR4r =
    std::to_array<Measure>({sdtw("sdtw"), ndtw("ndtw"), cls("cls"), success("sr"), spl(),
                            oracle("osr"), error("ne"), length("path_length")});
constexpr auto kValanRxr =
    std::to_array<Measure>({ndtw("ndtw"), sdtw("sdtw"), success("sr"), spl(), oracle("osr"),
                            cls("cls"), error("ne"), length("path_length")});
constexpr auto kR4rAuthors = std::to_array<Measure>({sdtw("sdtw"), ndtw("ndtw")});
constexpr auto kR4rAuthorsRxr = std::to_array<Measure>({ndtw("ndtw"), sdtw("sdtw")});

constexpr const char* kSeen = "Success rate: the object is seen from the last viewpoint";
constexpr const char* kSeenOnTheWay = "Oracle success rate: the object is seen from some viewpoint";
constexpr auto kReverieOfficial = std::to_array<Measure>(
    {rgspl(), rgs(), success("success_rate", 1, kSeen),
     oracle("oracle success_rate", 1, kSeenOnTheWay), spl(), length("length")});
constexpr auto kReverie = std::to_array<Measure>(
    {rgspl(kPerCent), rgs(kPerCent), success("sr", kPerCent, kSeen),
     oracle("oracle_sr", kPerCent, kSeenOnTheWay), spl("spl", kPerCent), length("lengths")});

constexpr auto kCvdnOfficial = std::to_array<Measure>(
    {progress("dist_to_end_reduction"),
     success("success_rate", 1, "Success rate: at the end of the path that the scorer chose"),
     oracle("oracle success_rate"),
     {"oracle path_success_rate", "OPSR", "Oracle success rate, at the end of the planner's path"},
     spl(),
     error("nav_error"),
     length("length")});
constexpr auto kCvdnHamt = std::to_array<Measure>(
    {progress("gp"), success("sr", kPerCent, "Success rate: ends in the region"),
     oracle("oracle_sr", kPerCent, "Oracle success rate: was in the region"), spl("spl", kPerCent),
     length("lengths")});
constexpr auto kCvdnValan = std::to_array<Measure>({progress("gp")});

// The released scorer's name for FSPL is success_rate.
constexpr auto kSoonDuet = std::to_array<Measure>(
    {found("det_spl", kPerCent), detection("det_sr", kPerCent), success("sr", kPerCent),
     oracle("oracle_sr", kPerCent), spl("spl", kPerCent), progress("goal_progress"),
     error("nav_error"), length("lengths")});
constexpr auto kSoonOfficial =
    std::to_array<Measure>({found("success_rate"), detection("det_success_rate"),
                            success("nav_success_rate"), oracle("oracle_rate"), spl(),
                            progress("goal_progress"), error("nav_error"), length("lengths")});

constexpr auto kRoomToRoomCe = std::to_array<Measure>(
    {spl(), success("success"), oracle("oracle_success"), error("distance_to_goal"), ndtw("ndtw"),
     sdtw("sdtw"), length("path_length")});
constexpr auto kRoomAcrossRoomCe = std::to_array<Measure>(
    {ndtw("ndtw"), sdtw("sdtw"), success("success"), spl(), oracle("oracle_success"),
     error("distance_to_goal"), length("path_length")});

}  // namespace columns
}  // namespace

constinit const std::array<Scorer, 5> kR2r{{
    {kOwnScorer, "", kOwnMetrics, columns::kOwn, own},  // of any goal
    {"duet", kOfDuet, kDuetMetrics, columns::kSpl, duet, nullptr, Task::kR2r},
    {"hamt", kOfHamt, kHamtMetrics, columns::kSpl, hamt, nullptr, Task::kR2r},
    {"valan", kOfValan, kValanMetrics, columns::kValan, valan, nullptr, Task::kR2r},
    {"r4r_public", kOfR4rAuthors, kR4rMetrics, columns::kR4rAuthors, r4r_public, nullptr,
     Task::kR2r},
}};
constinit const std::array<Scorer, 1> kR2rLast{{
    {"hamt", kOfHamt, kHamtMetrics, columns::kSpl, hamt, nullptr, Task::kR2rLast},
}};
constinit const std::array<Scorer, 1> kR2rBack{{
    {"hamt", kOfHamt, kBackMetrics, columns::kBack, hamt_back, nullptr, Task::kR2rBack},
}};
constinit const std::array<Scorer, 4> kR4r{{
    {"hamt", kOfHamt, kHamtMetrics, columns::kR4r, hamt, nullptr, Task::kR4r},
    {"duet", kOfDuet, kDuetMetrics, columns::kR4r, duet, nullptr, Task::kR4r},
    {"r4r_public", kOfR4rAuthors, kR4rMetrics, columns::kR4rAuthors, r4r_public, nullptr,
     Task::kR4r},
    {"valan", kOfValan, kValanMetrics, columns::kValanR4r, valan, nullptr, Task::kR4r},
}};
constinit const std::array<Scorer, 3> kRxr{{
    {"hamt", kOfHamt, kHamtMetrics, columns::kRxr, hamt, nullptr, Task::kRxr},
    {"r4r_public", kOfR4rAuthors, kR4rMetrics, columns::kR4rAuthorsRxr, r4r_public, nullptr,
     Task::kRxr},
    {"valan", kOfValan, kValanMetrics, columns::kValanRxr, valan, nullptr, Task::kRxr},
}};
constinit const std::array<Scorer, 3> kReverie{{
    {"official", kOfReverie, kReverieOfficialMetrics, columns::kReverieOfficial, reverie_official,
     nullptr, Task::kReverie},
    {"duet", kOfDuet, kReverieDuetMetrics, columns::kReverie, reverie_duet, nullptr,
     Task::kReverie},
    {"hamt", kOfHamt, kReverieHamtMetrics, columns::kReverie, reverie_hamt, nullptr,
     Task::kReverie},
}};
constinit const std::array<Scorer, 5> kCvdn{{
    {"official planner_path", kOfCvdn, kCvdnOfficialMetrics, columns::kCvdnOfficial, cvdn_planner,
     nullptr, Task::kCvdn},
    {"official player_path", kOfCvdn, kCvdnOfficialMetrics, columns::kCvdnOfficial, cvdn_player,
     nullptr, Task::kCvdn},
    {"official trusted_path", kOfCvdn, kCvdnOfficialMetrics, columns::kCvdnOfficial, cvdn_trusted,
     nullptr, Task::kCvdn},
    {"hamt", kOfHamt, kCvdnHamtMetrics, columns::kCvdnHamt, cvdn_hamt, nullptr, Task::kCvdn},
    {"valan", kOfValan, kProgressMetrics, columns::kCvdnValan, cvdn_valan, nullptr, Task::kCvdn},
}};
constinit const std::array<Scorer, 2> kSoon{{
    {"duet", kOfDuet, kSoonDuetMetrics, columns::kSoonDuet, soon_duet, nullptr, Task::kSoon},
    {"official", kOfSoon, kSoonOfficialMetrics, columns::kSoonOfficial, soon_official, nullptr,
     Task::kSoon},
}};
constinit const std::array<Scorer, 2> kR2rCe{{
    {"vlnce", kOfVlnCe, kVlnCeMetrics, columns::kRoomToRoomCe, nullptr, vlnce},
    {"etpnav", kOfEtpNav, kEtpNavMetrics, columns::kRoomToRoomCe, nullptr, etpnav},
}};
constinit const std::array<Scorer, 2> kRxrCe{{
    {"vlnce", kOfVlnCe, kVlnCeMetrics, columns::kRoomAcrossRoomCe, nullptr, vlnce},
    {"etpnav", kOfEtpNav, kEtpNavMetrics, columns::kRoomAcrossRoomCe, nullptr, etpnav},
}};

}  // namespace enfilade::tasks::scorers
