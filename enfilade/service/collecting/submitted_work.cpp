#include "enfilade/service/collecting/collection_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "enfilade/core/check.h"
#include "enfilade/service/collecting/kinds/targets.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/objects.h"

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
constexpr std::size_t kFewestWords = 3;
constexpr std::array<std::string_view, 3> kFlags{"short", "pasted", "goal-not-seen"};
constexpr std::size_t kMostSteps = 5000;
constexpr double kMostSeconds = 86'400;
constexpr double kMostPixels = 16'384;

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream in{std::string(text)};
  return {std::istream_iterator<std::string>(in), {}};
}

/// What is wrong with an instruction; empty if nothing is.
std::string instruction_fault(std::string_view text) {
  if (!detail::is_prose(text, kLongestInstruction)) {
    return fmt::format("not up to {} printable characters", kLongestInstruction);
  }
  if (words_of(text).size() < kFewestWords || text.size() < kShortestInstruction) {
    return fmt::format("{:?} is too short to lead anybody; {} words are the least", text,
                       kFewestWords);
  }
  return "";
}

/// The field "flags"; none if it is absent.
std::vector<std::string> flags_of(const Fields& fields, Faults& faults) {
  std::vector<std::string> flags;
  if (!fields.has("flags")) return flags;
  fields.list("flags", detail::kAnyNumber, "", [&](Element one, const Path& here) {
    const auto text = json::string(one, here, faults);
    if (text && std::ranges::find(kFlags, *text) == kFlags.end()) {
      faults.error(here, "unknown-flag",
                   fmt::format("{:?} is no flag", text->substr(0, detail::kQuoted)));
    } else if (text && std::ranges::find(flags, *text) == flags.end()) {
      flags.emplace_back(*text);
    }
  });
  return flags;
}

/// The steps of one walk.
class WalkReader {
 public:
  WalkReader(const graph::NavGraph& graph, const WorkItem& item, Faults& faults)
      : graph_(graph), item_(item), faults_(faults) {}

  /// The field "steps"; fields of a step that are not read here are dropped.
  ordered_json read(const Fields& fields) {
    ordered_json steps = ordered_json::array();
    fields.list("steps", kMostSteps, " steps",
                [&](Element one, const Path& here) { steps.push_back(read_step(one, here)); });
    const bool empty = fields["steps"].is_array() && steps.empty();
    if (empty) faults_.error(fields.path("steps"), "no-steps", "the start at least is expected");
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
  const WorkItem& item_;
  Faults& faults_;
  bool begun_ = false;
  std::optional<ViewpointIndex> last_;
  double seconds_ = 0;
};

/// The field "camera", as JSON; empty if it is absent.
std::string camera_of(const Fields& all, Faults& faults) {
  if (!all.has("camera")) return "";
  const Path path = all.path("camera");
  const Fields fields(all["camera"], path, faults, {"width", "height", "vfov"});
  if (!fields.complete()) return "";
  const auto pixels = [&fields](std::string_view name) {
    return static_cast<std::int64_t>(fields.number(name, 1, kMostPixels));
  };
  const double vfov = fields.number("vfov", 0.01, 3.14);
  return ordered_json{{"width", pixels("width")}, {"height", pixels("height")}, {"vfov", vfov}}
      .dump();
}

/// The field "instruction".
std::string instruction_of(const Fields& fields, Faults& faults) {
  std::string text = fields.string("instruction");
  const std::string fault = fields["instruction"].is_string() ? instruction_fault(text) : "";
  if (!fault.empty()) faults.error(fields.path("instruction"), "bad-instruction", fault);
  return text;
}

/// The words of a guide with their times, checked against the text.
ordered_json read_words(Element element, const Path& path, std::string_view text, Faults& faults) {
  ordered_json words = ordered_json::array();
  const auto list = json::array(element, path, faults);
  if (!list) return words;
  const std::vector<std::string> expected = words_of(text);
  if (list->size() != expected.size()) {
    faults.error(
        path, "word-count",
        fmt::format("{} words, and the instruction has {}", list->size(), expected.size()));
    return words;
  }
  double before = 0;
  for (const Element one : *list) {
    const Path here(path, words.size());
    const Fields fields(one, here, faults, {"word", "start", "end"});
    if (faults.full()) break;
    const std::string& word = expected[words.size()];
    words.push_back(nullptr);
    if (!fields.complete()) continue;
    const auto found = json::string(fields["word"], fields.path("word"), faults);
    if (found && *found != word) {
      faults.error(fields.path("word"), "other-word",
                   fmt::format("{:?}, and the instruction has {:?} there",
                               found->substr(0, detail::kQuoted), word.substr(0, detail::kQuoted)));
    }
    const double start = fields.number("start", 0, kMostSeconds);
    const double end = fields.number("end", 0, kMostSeconds);
    if (start < before || end < start) {
      faults.error(here, "time-runs-back", fmt::format("{} to {} after {}", start, end, before));
    }
    before = start;
    words.back() = {{"word", word}, {"start", start}, {"end", end}};
  }
  return words;
}

/// Whether the steps keep to the path and come to its end.
void check_on_path(const ordered_json& steps, const WorkItem& item, const Path& path,
                   Faults& faults) {
  bool arrived = false;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (!steps[k].is_object()) continue;  // a fault is reported
    const auto& id = steps[k].at("viewpoint").get_ref<const std::string&>();
    arrived = arrived || id == item.path.back();
    if (std::ranges::find(item.path, id) != item.path.end()) continue;
    const Path step(path, k);
    faults.error(Path(step, "viewpoint"), "off-the-path",
                 fmt::format("{:?} is not on the path", id.substr(0, detail::kQuoted)));
  }
  if (!arrived) faults.error(path, "end-not-reached", "the path was not walked to its end");
}

tasks::Direction read_direction(Element element, const Path& path, Faults& faults) {
  const Fields fields(element, path, faults, {"heading", "elevation"});
  if (!fields.complete()) return {};
  constexpr double kUpright = std::numbers::pi / 2;
  const double heading = fields.number("heading", 0, 2 * std::numbers::pi);
  return {Radians(heading), Radians(fields.number("elevation", -kUpright, kUpright))};
}

/// Metres from a viewpoint to the nearest from which the item's object is seen.
double distance_to_region(const graph::NavGraph& graph, ViewpointIndex from, const WorkItem& item) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::string& id : item.region) {
    const auto to = graph.find(id);
    if (to) least = std::min(least, graph.distance(from, *to));
  }
  return least;
}

/// Whether it is the item's object that was pointed at. None: nothing that has a box was.
std::optional<std::int64_t> pointed_at(const WorkItem& item, const std::string& viewpoint,
                                       const tasks::Direction& point,
                                       const tasks::ObjectBoxes* objects) {
  if (objects != nullptr && objects->has(item.scan, viewpoint)) {
    const auto found = kinds::object_at(*objects, item.scan, viewpoint, point);
    if (found) return found;
  }
  const kinds::Outlines outlines = kinds::parse_outlines(item.outlines);
  const auto here = outlines.find(viewpoint);
  const bool hit = here != outlines.end() &&
                   std::ranges::any_of(
                       here->second, [&](const auto& one) { return kinds::contains(one, point); });
  return hit ? item.object : std::nullopt;
}

SubmittedWork read_instruction(std::string_view body) {
  SubmittedWork work;
  const auto read = [&work](const Fields& fields, Faults& faults) {
    work.content = instruction_of(fields, faults);
    if (fields.has("seconds")) work.seconds = fields.number("seconds", 0, kMostSeconds);
    work.flags = flags_of(fields, faults);
  };
  detail::read_body(body, kFileName, detail::kWorkLimits, {"instruction"}, {"seconds", "flags"},
                    read);
  return work;
}

/// Of kWalk and kFind.
SubmittedWork read_followed(std::string_view body, const Assignment& task, const Site& site) {
  const WorkItem& item = task.item;
  const bool find = task.kind == WorkKind::kFind;
  const graph::NavGraph& graph = site.graphs().graph(item.scan);
  SubmittedWork work;
  std::optional<ViewpointIndex> end;
  ordered_json steps;
  tasks::Direction point;
  const auto read = [&](const Fields& fields, Faults& faults) {
    WalkReader walk(graph, item, faults);
    steps = walk.read(fields);
    if (find) point = read_direction(fields["point"], fields.path("point"), faults);
    work.camera = camera_of(fields, faults);
    work.seconds = walk.seconds();
    end = walk.end();
  };
  detail::read_body(body, kFileName, detail::kWorkLimits,
                    find ? Fields::Names{"steps", "point"} : Fields::Names{"steps"}, {"camera"},
                    read);
  EN_CHECK(end);
  if (!find) {
    const auto goal = graph.find(item.path.back());
    EN_CHECK(goal);  // checked when the collection was made
    work.error = graph.distance(*end, *goal);
    work.content = steps.dump();
    return work;
  }
  const auto found = pointed_at(item, graph.id(*end), point, site.objects());
  const double distance = distance_to_region(graph, *end, item);
  work.error = found && found == item.object
                   ? 0
                   : std::max(distance, tasks::MetricOptions{}.success_distance);
  work.content =
      ordered_json{
          {"steps", std::move(steps)},
          {"point", {{"heading", point.heading.value}, {"elevation", point.elevation.value}}},
          {"object", found ? ordered_json(*found) : ordered_json()}}
          .dump();
  return work;
}

SubmittedWork read_guide(std::string_view body, const WorkItem& item,
                         const graph::GraphSet& graphs) {
  SubmittedWork work;
  ordered_json content;
  const auto read = [&](const Fields& fields, Faults& faults) {
    WalkReader walk(graphs.graph(item.scan), item, faults);
    const std::string said = instruction_of(fields, faults);
    content["instruction"] = said;
    content["words"] = read_words(fields["words"], fields.path("words"), said, faults);
    content["steps"] = walk.read(fields);
    check_on_path(content["steps"], item, fields.path("steps"), faults);
    content["spoken"] = fields.boolean("spoken");
    work.flags = flags_of(fields, faults);
    work.seconds = walk.seconds();
    if (fields.has("seconds")) work.seconds = fields.number("seconds", 0, kMostSeconds);
  };
  detail::read_body(body, kFileName, detail::kWorkLimits, {"instruction", "words", "steps"},
                    {"spoken", "seconds", "flags"}, read);
  work.content = content.dump();
  return work;
}

}  // namespace

void check_instruction(std::string_view instruction, const char* where) {
  const std::string fault = instruction_fault(instruction);
  if (!fault.empty()) {
    throw InvalidInput({{Severity::kError, kFileName, where, "bad-instruction", fault}});
  }
}

SubmittedWork read_work(std::string_view body, const Assignment& task, const Site& site) {
  if (is_written(task.kind)) return read_instruction(body);
  if (is_followed(task.kind)) return read_followed(body, task, site);
  if (task.kind == WorkKind::kGuide) return read_guide(body, task.item, site.graphs());
  throw detail::Refusal(detail::Reason::kConflict,
                        "a dialogue is submitted when its navigator stops");
}

}  // namespace enfilade::service::collecting
