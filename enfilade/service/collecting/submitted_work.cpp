#include "enfilade/service/collecting/submitted_work.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "enfilade/core/check.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using detail::Found;
using detail::number_within;
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
  std::ptrdiff_t words = 0;
  bool inside = false;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n' || c == '\t';
    if (!blank && !inside) ++words;
    inside = !blank;
  }
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

  /// Reads them all, and gives them back without what else was in them.
  ordered_json read(Element element, const Path& path) {
    ordered_json steps = ordered_json::array();
    const auto list = json::array(element, path, faults_);
    if (!list) return steps;
    for (const Element one : *list) {
      if (steps.size() == kMostSteps) {
        faults_.error(path, "too-many", fmt::format("more than {} steps", kMostSteps));
        return steps;
      }
      steps.push_back(read_step(one, Path(path, steps.size())));
    }
    if (steps.empty()) faults_.error(path, "no-steps", "the start at least is expected");
    return steps;
  }

  std::optional<ViewpointIndex> end() const { return last_; }
  double seconds() const { return seconds_; }

 private:
  ordered_json read_step(Element element, const Path& path) {
    static constexpr std::array<json::Field, 4> kFields{
        {{"viewpoint"}, {"heading"}, {"elevation"}, {"seconds"}}};
    Found<kFields.size()> found;
    if (!json::fields(element, kFields, found, path, faults_)) return nullptr;
    const auto id = json::string(*found[0], Path(path, "viewpoint"), faults_);
    if (id) move_to(*id, Path(path, "viewpoint"));
    constexpr double kTurn = 2 * std::numbers::pi;
    constexpr double kUpright = std::numbers::pi / 2;
    const double heading = number_within(*found[1], Path(path, "heading"), 0, kTurn, faults_);
    const double elevation =
        number_within(*found[2], Path(path, "elevation"), -kUpright, kUpright, faults_);
    const Path when(path, "seconds");
    const double seconds = number_within(*found[3], when, 0, kMostSeconds, faults_);
    if (seconds < seconds_) {
      faults_.error(when, "time-runs-back", fmt::format("{} after {}", seconds, seconds_));
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
  static constexpr std::array<json::Field, 3> kFields{{{"width"}, {"height"}, {"vfov"}}};
  Found<kFields.size()> found;
  if (!json::fields(element, kFields, found, path, faults)) return "";
  const auto pixels = [&](std::size_t k) {
    return static_cast<std::int64_t>(
        number_within(*found[k], Path(path, kFields[k].name), 1, kMostPixels, faults));
  };
  const double vfov = number_within(*found[2], Path(path, "vfov"), 0.01, 3.14, faults);
  return ordered_json{{"width", pixels(0)}, {"height", pixels(1)}, {"vfov", vfov}}.dump();
}

}  // namespace

void check_instruction(std::string_view instruction, const char* where) {
  const std::string fault = instruction_fault(instruction);
  if (!fault.empty()) {
    throw InvalidInput({{Severity::kError, kFileName, where, "bad-instruction", fault}});
  }
}

SubmittedWork read_instruction(std::string_view body) {
  static constexpr std::array<json::Field, 3> kFields{
      {{"instruction"}, {"seconds", false}, {"flags", false}}};
  const json::Document document = json::Document::parse(body, kFileName);
  Faults faults(kFileName);
  const Path root;
  Found<kFields.size()> found;
  SubmittedWork work;
  if (json::fields(document.root(), kFields, found, root, faults)) {
    const Path here(root, "instruction");
    work.content = json::string(*found[0], here, faults).value_or("");
    const std::string fault = found[0]->is_string() ? instruction_fault(work.content) : "";
    if (!fault.empty()) faults.error(here, "bad-instruction", fault);
    if (found[1]) {
      work.seconds = number_within(*found[1], Path(root, "seconds"), 0, kMostSeconds, faults);
    }
    if (found[2]) work.flags = read_flags(*found[2], Path(root, "flags"), faults);
  }
  faults.throw_if_errors();
  return work;
}

SubmittedWork read_walk(std::string_view body, const Item& item, const graph::GraphSet& graphs) {
  static constexpr std::array<json::Field, 2> kFields{{{"steps"}, {"camera", false}}};
  const json::Document document = json::Document::parse(body, kFileName);
  const graph::NavGraph& graph = graphs.graph(item.scan);
  Faults faults(kFileName);
  const Path root;
  Found<kFields.size()> found;
  SubmittedWork work;
  WalkReader walk(graph, item, faults);
  if (json::fields(document.root(), kFields, found, root, faults)) {
    work.content = walk.read(*found[0], Path(root, "steps")).dump();
    if (found[1]) work.camera = read_camera(*found[1], Path(root, "camera"), faults);
  }
  faults.throw_if_errors();
  const auto goal = graph.find(item.path.back());
  EN_CHECK(goal && walk.end());  // checked when the collection was made, and just now
  work.seconds = walk.seconds();
  work.error = graph.distance(*walk.end(), *goal);
  return work;
}

}  // namespace enfilade::service::collecting
