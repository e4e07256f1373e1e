#include "enfilade/service/collecting/submitted_work.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "enfilade/core/check.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/json_limits.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using detail::Fields;
using json::Element;
using json::Faults;
using json::Path;
using nlohmann::ordered_json;

constexpr const char* kFileName = "submission";
constexpr std::size_t kShortestInstruction = 10;
constexpr std::size_t kLongestInstruction = 2000;
constexpr std::ptrdiff_t kFewestWords = 3;
constexpr std::array<std::string_view, 3> kFlags{"short", "pasted", "goal-not-seen"};
constexpr std::size_t kMostSteps = 5000;
constexpr double kMostSeconds = 86'400;
constexpr double kMostPixels = 16'384;

/// What is wrong with an instruction; empty if nothing is.
std::string instruction_fault(std::string_view text) {
  if (!detail::is_prose(text, kLongestInstruction)) {
    return fmt::format("not up to {} printable characters", kLongestInstruction);
  }
  std::istringstream in{std::string(text)};
  const auto words = std::distance(std::istream_iterator<std::string>(in), {});
  if (words < kFewestWords || text.size() < kShortestInstruction) {
    return fmt::format("{:?} is too short to lead anybody; {} words are the least", text,
                       kFewestWords);
  }
  return "";
}

std::vector<std::string> read_flags(Element element, const Path& path, Faults& faults) {
  std::vector<std::string> flags;
  const auto list = json::array(element, path, faults);
  if (!list) return flags;
  std::size_t k = 0;
  for (const Element one : *list) {
    if (faults.full()) break;
    const Path here(path, k++);
    const auto text = json::string(one, here, faults);
    if (text && std::ranges::find(kFlags, *text) == kFlags.end()) {
      faults.error(here, "unknown-flag",
                   fmt::format("{:?} is no flag", text->substr(0, detail::kQuoted)));
    } else if (text && std::ranges::find(flags, *text) == flags.end()) {
      flags.emplace_back(*text);
    }
  }
  return flags;
}

/// The steps of one walk.
class WalkReader {
 public:
  WalkReader(const graph::NavGraph& graph, const Item& item, Faults& faults)
      : graph_(graph), item_(item), faults_(faults) {}

  /// All steps; fields that are not read here are dropped.
  ordered_json read(Element element, const Path& path) {
    ordered_json steps = ordered_json::array();
    const auto list = json::array(element, path, faults_);
    if (!list) return steps;
    for (const Element one : *list) {
      if (steps.size() == kMostSteps) {
        faults_.error(path, "too-many", fmt::format("more than {} steps", kMostSteps));
        return steps;
      }
      if (faults_.full()) return steps;
      steps.push_back(read_step(one, Path(path, steps.size())));
    }
    if (steps.empty()) faults_.error(path, "no-steps", "the start at least is expected");
    return steps;
  }

  std::optional<ViewpointIndex> end() const { return last_; }
  double seconds() const { return seconds_; }

 private:
  ordered_json read_step(Element element, const Path& path) {
    const Fields fields(element, path, faults_, {"viewpoint", "heading", "elevation", "seconds"});
    if (!fields.complete()) return nullptr;
    const auto id = json::string(fields["viewpoint"], fields.path("viewpoint"), faults_);
    if (id) move_to(*id, fields.path("viewpoint"));
    constexpr double kUpright = std::numbers::pi / 2;
    const double heading = fields.number("heading", 0, 2 * std::numbers::pi);
    const double elevation = fields.number("elevation", -kUpright, kUpright);
    const double seconds = fields.number("seconds", 0, kMostSeconds);
    if (seconds < seconds_) {
      faults_.error(fields.path("seconds"), "time-runs-back",
                    fmt::format("{} after {}", seconds, seconds_));
    }
    seconds_ = seconds;
    return {{"viewpoint", id.value_or("")},
            {"heading", heading},
            {"elevation", elevation},
            {"seconds", seconds}};
  }

  void move_to(std::string_view id, const Path& path) {
    const auto to = graph_.find(id);
    const bool first = !std::exchange(begun_, true);
    if (!to || !graph_.included(*to)) {
      faults_.error(path, "unknown-viewpoint",
                    fmt::format("{:?} is no viewpoint of scan {}'s graph",
                                id.substr(0, detail::kQuoted), item_.scan));
    } else if (first && id != item_.path.front()) {
      faults_.error(path, "wrong-start",
                    fmt::format("{:?}, and the walk starts at {:?}", id, item_.path.front()));
    } else if (last_ && *last_ != *to && graph_.edge(*last_, *to) == nullptr) {
      faults_.error(path, "not-adjacent",
                    fmt::format("no edge leads from {:?} to {:?}", graph_.id(*last_), id));
    }
    last_ = to;
  }

  const graph::NavGraph& graph_;
  const Item& item_;
  Faults& faults_;
  bool begun_ = false;
  std::optional<ViewpointIndex> last_;
  double seconds_ = 0;
};

std::string read_camera(Element element, const Path& path, Faults& faults) {
  const Fields fields(element, path, faults, {"width", "height", "vfov"});
  if (!fields.complete()) return "";
  const auto pixels = [&fields](std::string_view name) {
    return static_cast<std::int64_t>(fields.number(name, 1, kMostPixels));
  };
  const double vfov = fields.number("vfov", 0.01, 3.14);
  return ordered_json{{"width", pixels("width")}, {"height", pixels("height")}, {"vfov", vfov}}
      .dump();
}

}  // namespace

void check_instruction(std::string_view instruction, const char* where) {
  const std::string fault = instruction_fault(instruction);
  if (!fault.empty()) {
    throw InvalidInput({{Severity::kError, kFileName, where, "bad-instruction", fault}});
  }
}

SubmittedWork read_instruction(std::string_view body) {
  detail::check_limits(body, kFileName, detail::kWorkLimits);
  const json::Document document = json::Document::parse(body, kFileName);
  Faults faults(kFileName);
  const Path root;
  const Fields fields(document.root(), root, faults, {"instruction"}, {"seconds", "flags"});
  SubmittedWork work;
  if (fields.complete()) {
    const Element text = fields["instruction"];
    work.content = json::string(text, fields.path("instruction"), faults).value_or("");
    const std::string fault = text.is_string() ? instruction_fault(work.content) : "";
    if (!fault.empty()) faults.error(fields.path("instruction"), "bad-instruction", fault);
    if (fields.has("seconds")) work.seconds = fields.number("seconds", 0, kMostSeconds);
    if (fields.has("flags")) work.flags = read_flags(fields["flags"], fields.path("flags"), faults);
  }
  faults.throw_if_errors();
  return work;
}

SubmittedWork read_walk(std::string_view body, const Item& item, const graph::GraphSet& graphs) {
  detail::check_limits(body, kFileName, detail::kWorkLimits);
  const json::Document document = json::Document::parse(body, kFileName);
  const graph::NavGraph& graph = graphs.graph(item.scan);
  Faults faults(kFileName);
  const Path root;
  const Fields fields(document.root(), root, faults, {"steps"}, {"camera"});
  SubmittedWork work;
  WalkReader walk(graph, item, faults);
  if (fields.complete()) {
    work.content = walk.read(fields["steps"], fields.path("steps")).dump();
    if (fields.has("camera")) {
      work.camera = read_camera(fields["camera"], fields.path("camera"), faults);
    }
  }
  faults.throw_if_errors();
  const auto goal = graph.find(item.path.back());
  EN_CHECK(goal && walk.end());  // checked when the collection was made, and above
  work.seconds = walk.seconds();
  work.error = graph.distance(*walk.end(), *goal);
  return work;
}

}  // namespace enfilade::service::collecting
