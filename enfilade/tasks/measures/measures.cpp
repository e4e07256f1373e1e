#include "enfilade/tasks/measures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/public_scorer.h"

namespace enfilade::tasks {
namespace {

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

// Per scorer, in the order of a table: the ranking measure first, then the rest as in papers.
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

struct Row {
  Task task;
  std::string_view scorer;
  std::span<const Measure> measures;
};

// By task, in the order of Task; the default scorer first.
constexpr auto kRows = std::to_array<Row>({
    {Task::kR2r, kOwnScorer, kOwn},
    {Task::kR2r, "duet", kSpl},
    {Task::kR2r, "hamt", kSpl},
    {Task::kR2r, "valan", kValan},
    {Task::kR2r, "r4r_public", kR4rAuthors},
    {Task::kR2rLast, "hamt", kSpl},
    {Task::kR2rBack, "hamt", kBack},
    {Task::kR4r, "hamt", kR4r},
    {Task::kR4r, "duet", kR4r},
    {Task::kR4r, "r4r_public", kR4rAuthors},
    {Task::kR4r, "valan", kValanR4r},
    {Task::kRxr, "hamt", kRxr},
    {Task::kRxr, "r4r_public", kR4rAuthorsRxr},
    {Task::kRxr, "valan", kValanRxr},
    {Task::kReverie, "official", kReverieOfficial},
    {Task::kReverie, "duet", kReverie},
    {Task::kReverie, "hamt", kReverie},
    {Task::kCvdn, "official planner_path", kCvdnOfficial},
    {Task::kCvdn, "official player_path", kCvdnOfficial},
    {Task::kCvdn, "official trusted_path", kCvdnOfficial},
    {Task::kCvdn, "hamt", kCvdnHamt},
    {Task::kCvdn, "valan", kCvdnValan},
    {Task::kSoon, "duet", kSoonDuet},
    {Task::kSoon, "official", kSoonOfficial},
});

std::span<const Row> rows(Task task) noexcept {
  const auto [begin, end] = std::ranges::equal_range(kRows, task, {}, &Row::task);
  return {begin, end};
}

}  // namespace

std::vector<std::string_view> scorer_names(Task task) {
  std::vector<std::string_view> names;
  for (const Row& row : rows(task)) names.push_back(row.scorer);
  return names;
}

std::span<const Measure> measures(Task task) noexcept { return rows(task).front().measures; }

std::span<const Measure> measures(Task task, std::string_view scorer) {
  const auto known = rows(task);
  const auto found = std::ranges::find(known, scorer, &Row::scorer);
  if (found != known.end()) return found->measures;
  throw LookupError(fmt::format("no scorer {:?} for {}; there are {}", scorer, title_of(task),
                                fmt::join(scorer_names(task), ", ")));
}

std::span<const Measure> measures(ContinuousForm form) noexcept {
  if (form == ContinuousForm::kRxr) return kRoomAcrossRoomCe;
  return kRoomToRoomCe;
}

const Measure* find_measure(std::span<const Measure> measures, std::string_view name) noexcept {
  const auto found = std::ranges::find(measures, name, &Measure::name);
  return found == measures.end() ? nullptr : &*found;
}

}  // namespace enfilade::tasks
