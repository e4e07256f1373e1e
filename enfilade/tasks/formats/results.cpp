#include "enfilade/tasks/results.h"
#include "enfilade/tasks/benchmark.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <unordered_map>
#include <utility>

#include "enfilade/core/detail/json_entries.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/formats/records.h"
#include "enfilade/tasks/formats/soon_entries.h"

namespace enfilade::tasks {
namespace {

using formats::Element;
using formats::Faults;
using formats::Fields;
using formats::Path;

constexpr std::size_t kListedIds = 20;  // of missing ones; further ones are only counted
// Of an entry of the file. A step in the long form takes up to 100 bytes, so this is some 10,000
// steps; published agents make at most some hundreds. simdjson takes up to 14 times as much.
constexpr std::size_t kMostEntryBytes = std::size_t{1} << 20U;
constexpr const char* kEntryForms =
    "a viewpoint id, [viewpoint], [viewpoint, heading, elevation], or a list of those";

std::vector<json::Field> wanted_of(Task task) {
  // Other fields may replace both of these.
  const bool own_id = task == Task::kCvdn || task == Task::kRxr;
  return {{"instr_id", !own_id},
          {"trajectory", task != Task::kRxr},
          {"inst_idx", false},                  // CVDN
          {"instruction_id", false},            // RxR
          {"path", false},                      // RxR, beside it
          {"midstop", task == Task::kR2rBack},  // R2R-Back
          {"predObjId", false},                 // REVERIE, as its own scorer and HAMT name it
          {"pred_objid", false}};               // and DUET
}

bool is_nested(Element element) { return element.is_array() || element.is_object(); }

// [viewpoint] or [viewpoint, heading, elevation], or meant as one: a list with an element that
// cannot be part of a sub-path.
bool is_point(simdjson::dom::array list) {
  std::size_t count = 0;
  bool scalar = false;
  bool text_first = false;
  for (const Element element : list) {
    if (count == 0 && is_nested(element)) return false;
    if (count == 0) text_first = element.is_string();
    scalar = scalar || (!element.is_string() && !is_nested(element));
    ++count;
  }
  return scalar || (count == 1 && text_first);
}

// Reads one trajectory. If its episode is unknown, only the form is checked.
class TrajectoryReader {
 public:
  /// \param points  what was read; overwritten
  TrajectoryReader(const EpisodeSet& episodes, std::optional<std::size_t> episode, Faults& faults,
                   std::vector<TrajectoryPoint>& points)
      : faults_(faults), points_(points) {
    points_.clear();
    if (!episode) return;
    reference_ = &episodes.path_of(episodes.episodes[*episode]);
    graph_ = &episodes.graphs->graph(reference_->scan);
  }

  void read(Element element, const Path& path) {
    const std::size_t errors = faults_.errors();
    const auto entries = json::array(element, path, faults_);
    if (!entries) return;
    entries_ = entries->size();
    read_list(*entries, path, 0);
    if (!started_ && faults_.errors() == errors) {
      faults_.error(path, "empty-trajectory", "no viewpoint; the start at least is expected");
    }
  }

  // An entry is an action, whatever it passes. No value if it passes one viewpoint each.
  std::optional<std::size_t> actions() const {
    if (entries_ == 0 || entries_ == points_.size()) return std::nullopt;
    return entries_ - 1;
  }

  // A viewpoint that an agent names.
  std::optional<ViewpointIndex> named(Element element, const Path& path) {
    const auto id = json::string(element, path, faults_);
    return id ? find(*id, path) : std::nullopt;
  }

 private:
  void read_list(simdjson::dom::array list, const Path& path, int depth) {
    std::size_t i = 0;
    for (const Element element : list) {
      const Path place(path, i++);
      if (faults_.full()) {
        faults_.stop(place);
        return;
      }
      read_entry(element, place, depth);
    }
  }

  void read_entry(Element element, const Path& path, int depth) {
    simdjson::dom::array list;
    if (element.is_string()) {
      add(element, path, {}, {});
    } else if (element.get_array().get(list) != simdjson::SUCCESS) {
      refuse(element, path);
    } else if (is_point(list)) {
      read_point(element, list, path);
    } else if (depth == 0) {
      read_list(list, path, depth + 1);
    } else {
      faults_.error(path, "bad-entry",
                    fmt::format("{} inside a sub-path, not a viewpoint id, [viewpoint] or "
                                "[viewpoint, heading, elevation]",
                                json::describe(element)));
    }
  }

  void read_point(Element element, simdjson::dom::array list, const Path& path) {
    const std::size_t size = list.size();
    if (size != 1 && size != 3) {
      refuse(element, path);
      return;
    }
    std::array<Radians, 2> angles{};
    for (std::size_t k = 1; k < size; ++k) {
      angles[k - 1] = formats::read_angle(list.at(k).value_unsafe(), Path(path, k), faults_);
    }
    add(list.at(0).value_unsafe(), Path(path, std::size_t{0}), angles[0], angles[1]);
  }

  void refuse(Element element, const Path& path) {
    faults_.error(path, "bad-entry",
                  fmt::format("{}, not {}", json::describe(element), kEntryForms));
  }

  void add(Element element, const Path& path, Radians heading, Radians elevation) {
    const bool first = !std::exchange(started_, true);
    const auto id = json::string(element, path, faults_);
    const auto viewpoint = id ? find(*id, path) : std::nullopt;
    if (viewpoint) {
      if (first) check_start(*viewpoint, path);
      if (last_) check_step(*viewpoint, path);
      points_.push_back({*viewpoint, heading, elevation});
    }
    last_ = viewpoint;  // after a bad one, the next step is not checked
  }

  // What a graph has is an id, so that only others are checked.
  std::optional<ViewpointIndex> find(std::string_view id, const Path& path) {
    const auto found = graph_ != nullptr ? graph_->find(id) : std::nullopt;
    if (!found && !is_id(id)) {
      faults_.error(path, "bad-id", fault_of_id(id));
    } else if (graph_ == nullptr) {
      return std::nullopt;
    } else if (!found) {
      faults_.error(path, "unknown-viewpoint",
                    fmt::format("viewpoint {} is not one of the {} of scan {}", quote(id),
                                graph_->size(), graph_->scan()));
    } else if (!graph_->included(*found)) {
      faults_.error(path, "excluded-viewpoint",
                    fmt::format("viewpoint {} of scan {} exists but is excluded from its graph",
                                quote(id), graph_->scan()));
      return std::nullopt;
    }
    return found;
  }

  void check_start(ViewpointIndex viewpoint, const Path& path) {
    const ViewpointIndex start = reference_->viewpoints.front();
    if (viewpoint == start) return;
    faults_.error(
        path, "wrong-start",
        fmt::format("starts at {}, but path {} starts at {}", quote(graph_->id(viewpoint)),
                    reference_->path_id, quote(graph_->id(start))));
  }

  void check_step(ViewpointIndex viewpoint, const Path& path) {
    if (viewpoint == *last_ || graph_->edge(*last_, viewpoint) != nullptr) return;
    const float apart = length(graph_->position(viewpoint) - graph_->position(*last_));
    const double walk = graph_->distance(*last_, viewpoint);
    faults_.error(path, "not-adjacent",
                  fmt::format("no edge leads from {} to {}: {:.2f} m apart, {}",
                              quote(graph_->id(*last_)), quote(graph_->id(viewpoint)), apart,
                              std::isfinite(walk) ? fmt::format("{:.2f} m to walk", walk)
                                                  : std::string("out of reach")));
  }

  Faults& faults_;
  const ReferencePath* reference_ = nullptr;
  const graph::NavGraph* graph_ = nullptr;
  std::optional<ViewpointIndex> last_;
  bool started_ = false;
  std::size_t entries_ = 0;
  std::vector<TrajectoryPoint>& points_;
};

// Reads a whole file, an entry at a time. Each episode may have one entry.
class Reader {
 public:
  Reader(const EpisodeSet& episodes, const std::string& file, Coverage coverage)
      : episodes_(episodes),
        coverage_(coverage),
        wanted_(wanted_of(episodes.task)),
        faults_(file),
        soon_(episodes),
        places_(episodes.episodes.size()) {
    by_id_.reserve(places_.size());
    results_.trajectories.resize(places_.size());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const std::string_view id = episodes.episodes[i].instruction_id;
      by_id_.emplace(id, i);
      if (episodes.task == Task::kRxr) by_number_.emplace(id.substr(id.rfind('_') + 1), i);
      results_.trajectories[i].episode = i;
    }
  }

  Results read(std::string_view text) {
    json::Entries entries(text, faults_.file(), kMostEntryBytes);
    if (entries.is_list(faults_) && read_entries(entries)) report_missing();
    faults_.throw_if_errors();
    if (coverage_ == Coverage::kPart) leave_out_missing();
    results_.warnings = faults_.take();
    return std::move(results_);
  }

 private:
  // False if it stopped before the end: a file with that many faults is of another kind.
  bool read_entries(json::Entries& entries) {
    const Path root;
    while (entries.next()) {
      const Path path(root, entries.index());
      if (faults_.full()) {
        faults_.stop(path);
        return false;
      }
      if (entries.element()) {
        read_entry(*entries.element(), entries.index(), path);
      } else {
        faults_.error(
            path, "too-large",
            fmt::format("an entry of {} bytes; {} are allowed", entries.bytes(), kMostEntryBytes));
      }
    }
    return !faults_.stopped();
  }

  void read_entry(Element element, std::size_t place, const Path& path) {
    const Fields found(element, wanted_, path, faults_);  // what it lacks is reported; go on
    const auto& trajectory = found["trajectory"];
    if (episodes_.task == Task::kSoon && trajectory && trajectory->is_array()) {
      read_alternatives(found, place);
      return;
    }
    const std::string_view id_field = found.has("instr_id") ? "instr_id" : own_id_field();
    std::optional<std::size_t> episode;
    bool keep = false;
    if (found.has(id_field)) {
      const Path id_path = found.place(id_field);
      const auto id = read_id(*found[id_field], id_field, id_path);
      if (id && is_unscored(*id)) {
        faults_.add(Severity::kWarning, id_path, "unscored-instruction",
                    fmt::format("{} is not scored (the first {} instructions of a path are); left "
                                "out",
                                quote(*id), kScoredInstructions));
        return;
      }
      if (id) episode = identify(*id, id_path);
      keep = episode && claim(*episode, place, id_path);
    } else if (id_field != "instr_id" && element.is_object()) {
      faults_.error(path, "missing-field", fmt::format("neither instr_id nor {}", own_id_field()));
    }
    Trajectory read;
    read_trajectory(found, episode, path, read);
    if (keep) keep_as(*episode, std::move(read));
  }

  void keep_as(std::size_t episode, Trajectory read) {
    read.episode = episode;
    // A copy, because a vector that grew has room for twice as many.
    read.points.assign(points_.begin(), points_.end());
    results_.trajectories[episode] = std::move(read);
  }

  // SOON as released: one entry answers an instruction from the starts of all its alternatives.
  void read_alternatives(const Fields& found, std::size_t place) {
    std::optional<std::string> id;
    const Path id_path = found.place("instr_id");
    if (found.has("instr_id")) id = read_id(*found["instr_id"], "instr_id", id_path);
    if (id && !soon_.knows(*id)) {
      refuse_id(
          *id, id_path,
          fmt::format("of the {} entries that split {} names", soon_.size(), episodes_.split));
      id.reset();
    }
    const Path list = found.place("trajectory");
    std::size_t k = 0;
    const simdjson::dom::array answers = found["trajectory"]->get_array().value_unsafe();
    for (const Element one : answers) {
      const Path at(list, k++);
      if (faults_.full()) return faults_.stop(at);
      read_alternative(one, id, place, at);
    }
    if (k == 0) faults_.error(list, "empty-trajectory", "no alternative; one or more are expected");
  }

  void read_alternative(Element element, const std::optional<std::string>& id, std::size_t place,
                        const Path& path) {
    const auto start = id ? formats::soon_start(element) : std::nullopt;
    std::optional<std::size_t> episode;
    if (start) {
      const auto answered = [this](std::size_t e) { return places_[e].has_value(); };
      const formats::SoonEntries::Found found = soon_.find(*id, *start, answered);
      episode = found.episode;
      if (!episode && found.any) {
        faults_.error(path, "repeated-instr-id",
                      fmt::format("all paths of entry {} that begin at {} have an answer already",
                                  quote(*id), quote(*start)));
      } else if (!episode) {
        faults_.error(
            Path(path, "path"), "wrong-start",
            fmt::format("starts at {}, but no path of entry {} does", quote(*start), quote(*id)));
      }
    }
    Trajectory read;
    TrajectoryReader reader(episodes_, episode, faults_, points_);
    read_pointed(element, path, PointForm::kNumber, reader, read);
    read.actions = reader.actions();
    if (!episode) return;
    places_[*episode] = place;
    keep_as(*episode, std::move(read));
  }

  std::string_view own_id_field() const {
    if (episodes_.task == Task::kCvdn) return "inst_idx";
    return episodes_.task == Task::kRxr ? "instruction_id" : "instr_id";
  }

  // An instr_id is a text; CVDN's and RxR's own ids are numbers.
  std::optional<std::string> read_id(Element element, std::string_view field, const Path& path) {
    if (field == "instr_id") {
      const auto id = json::string(element, path, faults_);
      return id ? std::optional<std::string>(*id) : std::nullopt;
    }
    const auto id = json::integer(element, path, faults_);
    return id ? std::optional(std::to_string(*id)) : std::nullopt;
  }

  void read_trajectory(const Fields& found, std::optional<std::size_t> episode, const Path& path,
                       Trajectory& read) {
    TrajectoryReader reader(episodes_, episode, faults_, points_);
    const auto& trajectory = found["trajectory"];
    if (trajectory && episodes_.task == Task::kSoon) {
      read_pointed(*trajectory, found.place("trajectory"), PointForm::kList, reader, read);
    } else if (trajectory) {
      reader.read(*trajectory, found.place("trajectory"));
    } else if (found.has("path")) {
      reader.read(*found["path"], found.place("path"));
    } else if (episodes_.task == Task::kRxr) {
      faults_.error(path, "missing-field", "neither trajectory nor path");
    }
    read.actions = reader.actions();
    const auto& turn = found["midstop"];
    if (episodes_.task == Task::kR2rBack && turn && !turn->is_null()) {
      read.turning_point = reader.named(*turn, found.place("midstop"));
    }
    if (episodes_.task == Task::kReverie) read.object = read_object(found, path);
  }

  // REVERIE's scorers compare ids as texts: 66 and "66" are the same object. Null names none.
  std::string read_object(const Fields& found, const Path& path) {
    const std::string_view field = found.has("predObjId") ? "predObjId" : "pred_objid";
    if (!found.has(field)) {
      faults_.error(path, "missing-field",
                    "neither predObjId nor pred_objid; null says that no object was named");
      return {};
    }
    const Element element = *found[field];
    const Path place = found.place(field);
    if (element.is_null()) return {};
    if (element.is_string()) return read_object_id(element, place);
    const auto id = json::integer(element, place, faults_);
    return id ? std::to_string(*id) : std::string();
  }

  // Empty names none. Scorers compare texts: "-1" and "128 " are wrong answers, and no faults.
  std::string read_object_id(Element element, const Path& path) {
    const auto id = json::string(element, path, faults_).value_or("");
    if (id.empty() || (id.size() <= kLongestId && is_file_name(id))) return std::string(id);
    faults_.error(path, "bad-id",
                  fmt::format("{} is no id of an object: at most {} bytes without control "
                              "characters, / and \\ are allowed, the first not .",
                              quote(id), kLongestId));
    return {};
  }

  // How DUET and SOON's own code write a number of the point: [x] and x.
  enum class PointForm : std::uint8_t { kList, kNumber };

  // SOON: {"path": [...], "obj_heading": [h], "obj_elevation": [e]}.
  void read_pointed(Element element, const Path& path, PointForm form, TrajectoryReader& reader,
                    Trajectory& read) {
    const Fields found(element, {"path", "obj_heading", "obj_elevation"}, {}, path, faults_);
    if (found.has("path")) reader.read(*found["path"], found.place("path"));
    const auto &h = found["obj_heading"], &e = found["obj_elevation"];
    if (!h || !e) return;
    const auto heading = read_one(*h, found.place("obj_heading"), form);
    const auto elevation = read_one(*e, found.place("obj_elevation"), form);
    if (heading && elevation) read.point = SpherePoint{*heading, *elevation};
  }

  // Null: the agent points nowhere.
  std::optional<double> read_one(Element element, const Path& path, PointForm form) {
    if (element.is_null()) return std::nullopt;
    if (form == PointForm::kNumber) return json::number(element, path, faults_);
    const auto list = json::array(element, path, faults_);
    if (!list) return std::nullopt;
    if (list->size() != 1) {
      faults_.error(path, "bad-point",
                    fmt::format("{}; a list of one number is expected", json::describe(element)));
      return std::nullopt;
    }
    return json::number(list->at(0).value_unsafe(), Path(path, std::size_t{0}), faults_);
  }

  // "7_3" where "7_2" is scored: a fourth instruction, which data sets have for some paths and no
  // scorer uses.
  bool is_unscored(std::string_view id) const {
    if (benchmark(episodes_.task).scored_instructions == 0 || by_id_.contains(id)) return false;
    const std::string fourth = fmt::format("_{}", kScoredInstructions);
    if (!id.ends_with(fourth)) return false;
    id.remove_suffix(fourth.size());
    return by_id_.contains(fmt::format("{}_{}", id, kScoredInstructions - 1));
  }

  // An id that is none of those there are. \param those  "of the 7 of split val"
  void refuse_id(std::string_view id, const Path& path, const std::string& those) {
    if (is_id(id, kLongestInstructionId)) {
      faults_.error(path, "unknown-instr-id", fmt::format("{} is not one {}", quote(id), those));
    } else {
      faults_.error(path, "bad-id", fault_of_id(id, kLongestInstructionId));
    }
  }

  // RxR: "1501", or "150_1501" where the annotations have 1501 alone. Test lines have no path_id,
  // and the same lines with their goals have one.
  std::optional<std::size_t> find_numbered(std::string_view id) const {
    const auto numbered = by_number_.find(id.substr(id.rfind('_') + 1));
    if (numbered == by_number_.end()) return std::nullopt;
    const std::string& known = episodes_.episodes[numbered->second].instruction_id;
    const bool one_is_number = id.find('_') == id.npos || known.find('_') == known.npos;
    return one_is_number ? std::optional(numbered->second) : std::nullopt;
  }

  std::optional<std::size_t> identify(std::string_view id, const Path& path) {
    const auto episode = by_id_.find(id);
    if (episode != by_id_.end()) return episode->second;
    if (const auto numbered = find_numbered(id)) return numbered;
    refuse_id(id, path, fmt::format("of the {} of split {}", places_.size(), episodes_.split));
    return std::nullopt;
  }

  // Returns false and reports a fault if the file had an entry for this episode before.
  bool claim(std::size_t episode, std::size_t place, const Path& path) {
    if (!places_[episode]) {
      places_[episode] = place;
      return true;
    }
    faults_.error(
        path, "repeated-instr-id",
        fmt::format("{} stands at $[{}] already; one entry each is allowed",
                    quote(episodes_.episodes[episode].instruction_id), *places_[episode]));
    return false;
  }

  void report_missing() {
    std::vector<std::string> missing;
    std::size_t count = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (places_[i] || ++count > kListedIds) continue;
      missing.push_back(quote(episodes_.episodes[i].instruction_id));
    }
    if (coverage_ == Coverage::kPart && count < places_.size()) return;
    if (count > kListedIds) {
      faults_.error(
          Path(), "missing-instr-id",
          fmt::format("no entry for {} of the {} instr_ids of split {}{}: {} and {} more", count,
                      places_.size(), episodes_.split,
                      count == places_.size() ? " (is it the file of another split?)" : "",
                      fmt::join(missing, ", "), count - kListedIds));
      return;
    }
    for (const std::string& id : missing) {
      faults_.error(Path(), "missing-instr-id",
                    fmt::format("no entry for instr_id {} of split {}", id, episodes_.split));
    }
  }

  void leave_out_missing() {
    std::erase_if(results_.trajectories,
                  [this](const Trajectory& one) { return !places_[one.episode]; });
  }

  const EpisodeSet& episodes_;
  Coverage coverage_;
  std::vector<json::Field> wanted_;
  Faults faults_;
  formats::SoonEntries soon_;
  std::unordered_map<std::string_view, std::size_t> by_id_;  // indices of episodes
  // RxR's instruction_id, which ends its instr_id.
  std::unordered_map<std::string_view, std::size_t> by_number_;
  std::vector<std::optional<std::size_t>> places_;  // of the entries in the file, by episode
  std::vector<TrajectoryPoint> points_;             // of the entry that is being read
  Results results_;
};

}  // namespace

Results load_results(const std::filesystem::path& file, const EpisodeSet& episodes,
                     Coverage coverage) {
  return parse_results(read_text_file(file), file.string(), episodes, coverage);
}

Results parse_results(std::string_view json, const std::string& file, const EpisodeSet& episodes,
                      Coverage coverage) {
  return Reader(episodes, file, coverage).read(json);
}

EpisodeSet part_of(const EpisodeSet& episodes, std::vector<Trajectory>& trajectories) {
  EpisodeSet part{episodes.split, episodes.graphs, episodes.paths, {},
                  episodes.task,  episodes.objects};
  std::ranges::sort(trajectories, {}, &Trajectory::episode);
  for (Trajectory& trajectory : trajectories) {
    part.episodes.push_back(episodes.episodes.at(trajectory.episode));
    trajectory.episode = part.episodes.size() - 1;
  }
  return part;
}

SpherePoint sphere_point(const Direction& direction) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double heading = wrap_heading(direction.heading).value / kTurn;
  return {heading < 1 ? heading : 0,
          (wrap_difference(direction.elevation).value + std::numbers::pi) / kTurn};
}

void check_trajectory(const Trajectory& trajectory, const EpisodeSet& episodes) {
  if (trajectory.episode >= episodes.episodes.size()) {
    throw ArgumentError(fmt::format("a trajectory of episode {}; split {} has {}",
                                    trajectory.episode, episodes.split, episodes.episodes.size()));
  }
  const Episode& episode = episodes.episodes[trajectory.episode];
  if (trajectory.points.empty()) {
    throw ArgumentError(fmt::format("the trajectory of {} is empty", episode.instruction_id));
  }
  if (goal_hidden(episodes.path_of(episode))) {
    throw ArgumentError(fmt::format("the goal of {} in split {} is hidden; it cannot be scored",
                                    episode.instruction_id, episodes.split));
  }
  const std::size_t size = episodes.graph_of(episode).size();
  for (const TrajectoryPoint& point : trajectory.points) {
    if (point.viewpoint.at() < size) continue;
    throw ArgumentError(fmt::format("the trajectory of {} goes to viewpoint {} of {}",
                                    episode.instruction_id, point.viewpoint.value, size));
  }
}

std::vector<std::size_t> trajectory_by_episode(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes) {
  if (trajectories.size() != episodes.episodes.size()) {
    throw ArgumentError(fmt::format("{} trajectories for the {} episodes of split {}",
                                    trajectories.size(), episodes.episodes.size(), episodes.split));
  }
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> places(trajectories.size(), kNone);
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    std::size_t& place = places[trajectories[i].episode];
    if (place != kNone) {
      throw ArgumentError(fmt::format("two trajectories of {}",
                                      episodes.episodes[trajectories[i].episode].instruction_id));
    }
    place = i;
  }
  return places;
}

}  // namespace enfilade::tasks
