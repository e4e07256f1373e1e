// VLN-CE's results files: enfilade/tasks/continuous_results.h.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/geometry/habitat_frame.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/formats/records.h"
#include "enfilade/tasks/formats/vln_ce.h"

namespace enfilade::tasks {
namespace {

using formats::Element;
using formats::Faults;
using formats::Path;
using Json = nlohmann::ordered_json;

constexpr std::uint8_t kStop = ContinuousResult::kStop, kForward = 1, kLeft = 2, kRight = 3;
constexpr std::size_t kListedEpisodes = 20;  // of missing ones; further ones are only counted
constexpr double kStartTolerance = 0.01;     // metres: more than any rounding, less than any step

// Whether a text is lines with instruction ids.
bool is_rxr(std::string_view text) {
  try {
    json::Records records(text, "", formats::kMostRecordBytes);
    simdjson::dom::object object;
    return records.is_lines() && records.next() && records.element() &&
           records.element()->get_object().get(object) == simdjson::SUCCESS &&
           object.at_key("instruction_id").error() == simdjson::SUCCESS;
  } catch (const InvalidInput&) {
    return false;  // an object of several lines
  }
}

std::uint8_t action_between(const ContinuousResult& walk, std::size_t before) {
  const std::size_t after = before + 1;
  if (walk.positions[after] != walk.positions[before] || walk.headings.empty()) return kForward;
  const Radians turn = wrap_difference(walk.headings[after] - walk.headings[before]);
  if (turn.value == 0) return kForward;
  return turn.value < 0 ? kLeft : kRight;  // headings are clockwise
}

class ResultsReader {
 public:
  ResultsReader(const std::string& file, const ContinuousEpisodes& episodes, Coverage coverage)
      : episodes_(episodes), coverage_(coverage), faults_(file), walks_(episodes.episodes.size()) {}

  std::vector<ContinuousResult> read(std::string_view text) {
    if (is_rxr(text)) {
      read_lines(text);
    } else {
      read_object(text);
    }
    if (!faults_.stopped()) report_missing();
    faults_.throw_if_errors();
    std::vector<ContinuousResult> walks;
    for (auto& walk : walks_) {
      if (walk) walks.push_back(std::move(*walk));
    }
    return walks;
  }

 private:
  void read_object(std::string_view text) {
    id_field_ = "episode_id";
    for (std::size_t i = 0; i < episodes_.episodes.size(); ++i) {
      by_id_.emplace(text_of(episodes_.episodes[i].id), i);
    }
    formats::for_each_member(text, faults_, [this](json::Members& members, const Path& path) {
      const auto episode = claim(members.key(), path);
      const auto value = members.element(formats::kMostRecordBytes);
      if (!value) {
        formats::refuse_large(members.value().size(), path, faults_);
        return;
      }
      const std::size_t errors = faults_.errors();
      ContinuousResult walk = read_poses(*value, path);
      keep(episode, std::move(walk), errors, path);
    });
  }

  void read_lines(std::string_view text) {
    id_field_ = "instruction_id";
    for (std::size_t i = 0; i < episodes_.episodes.size(); ++i) {
      const auto& id = episodes_.episodes[i].instruction.id;
      if (id) by_id_.emplace(text_of(*id), i);
    }
    formats::for_each_record(text, faults_, [this](Element element, const Path& path) {
      const formats::Fields found(element, {"instruction_id", "path"}, {}, path, faults_);
      if (!found) return;
      const auto id = found.get("instruction_id", formats::read_id);
      const auto episode = id ? claim(text_of(*id), found.place("instruction_id")) : std::nullopt;
      const std::size_t errors = faults_.errors();
      ContinuousResult walk = read_path(*found["path"], found.place("path"));
      keep(episode, std::move(walk), errors, found.place("path"));
    });
  }

  // The episode of an id that is there for the first time.
  std::optional<std::size_t> claim(const std::string& id, const Path& path) {
    const auto found = by_id_.find(id);
    if (found == by_id_.end()) {
      if (std::string fault = fault_of_id(id); !fault.empty()) {
        faults_.error(path, "bad-id", std::move(fault));
      } else {
        faults_.error(path, "unknown-episode",
                      fmt::format("{} is not one of the {} values of {} in split {}", quote(id),
                                  by_id_.size(), id_field_, episodes_.split));
      }
      return std::nullopt;
    }
    if (claimed_.emplace(found->second, path.text()).second) return found->second;
    faults_.error(path, "repeated-episode",
                  fmt::format("{} {} stands at {} already", id_field_, quote(id),
                              claimed_.at(found->second)));
    return std::nullopt;
  }

  Vec3f read_position(Element element, const Path& path) {
    return to_float(formats::read_point(element, path, faults_));
  }

  ContinuousResult read_poses(Element element, const Path& path) {
    ContinuousResult walk;
    const auto list = json::array(element, path, faults_);
    if (!list) return walk;
    std::optional<std::size_t> stop;
    for (const Element one : *list) {
      if (faults_.full()) break;
      const std::size_t k = walk.positions.size();
      const Path place(path, k);
      walk.positions.emplace_back();
      walk.headings.emplace_back();
      const formats::Fields found(one, {"position", "heading", "stop"}, {}, place, faults_);
      if (!found) continue;
      walk.positions[k] = read_position(*found["position"], found.place("position"));
      // Habitat's is counter-clockwise.
      walk.headings[k] = wrap_heading(-found.get("heading", formats::read_angle));
      const auto stopped = found.get("stop", json::boolean);
      if (stop && *stop + 1 == k) {
        faults_.error(place, "after-stop", "a pose after stop was called");
      }
      if (!stop && stopped.value_or(false)) stop = k;
    }
    if (stop == 0U) {
      faults_.error(Path(path, 0), "no-start", "stop before the first action; a start is expected");
    }
    for (std::size_t k = 0; k + 1 < walk.positions.size(); ++k) {
      walk.actions.push_back(stop == k + 1 ? kStop : action_between(walk, k));
    }
    return walk;
  }

  ContinuousResult read_path(Element element, const Path& path) {
    ContinuousResult walk;
    const auto list = json::array(element, path, faults_);
    if (!list) return walk;
    for (const Element one : *list) {
      if (faults_.full()) break;
      walk.positions.push_back(read_position(one, Path(path, walk.positions.size())));
    }
    if (walk.positions.empty()) return walk;
    walk.actions.assign(walk.positions.size() - 1, kForward);
    walk.actions.push_back(kStop);
    walk.positions.push_back(walk.positions.back());
    return walk;
  }

  void keep(std::optional<std::size_t> episode, ContinuousResult walk, std::size_t errors,
            const Path& path) {
    if (faults_.errors() != errors) return;
    if (walk.positions.empty()) {
      faults_.error(path, "no-pose", "no pose; the start at least is expected");
      return;
    }
    if (!episode) return;
    const Vec3d start = episodes_.episodes[*episode].start;
    const double off = length(to_double(walk.positions[0]) - start);
    if (off > kStartTolerance) {
      const Vec3d found = to_habitat(to_double(walk.positions[0])), wanted = to_habitat(start);
      faults_.error(Path(path, 0), "wrong-start",
                    fmt::format("[{}, {}, {}] is {:.3f} m off the episode's start, [{}, {}, {}]",
                                found.x, found.y, found.z, off, wanted.x, wanted.y, wanted.z));
      return;
    }
    walk.episode = *episode;
    walks_[*episode] = std::move(walk);
  }

  void report_missing() {
    if (coverage_ == Coverage::kPart && !claimed_.empty()) return;
    std::vector<std::string> missing;
    std::size_t count = 0;
    for (std::size_t i = 0; i < walks_.size(); ++i) {
      if (claimed_.contains(i) || ++count > kListedEpisodes) continue;
      missing.push_back(quote(text_of(episodes_.episodes[i].id)));
    }
    if (count == 0) return;
    faults_.error(
        Path(), "missing-episode",
        fmt::format(
            "no walk for {} of the {} episodes of split {}: {}{}", count, walks_.size(),
            episodes_.split, fmt::join(missing, ", "),
            count > kListedEpisodes ? fmt::format(" and {} more", count - kListedEpisodes) : ""));
  }

  const ContinuousEpisodes& episodes_;
  Coverage coverage_;
  Faults faults_;
  std::string id_field_;
  std::unordered_map<std::string, std::size_t> by_id_;    // indices of episodes
  std::unordered_map<std::size_t, std::string> claimed_;  // where each was answered first
  std::vector<std::optional<ContinuousResult>> walks_;    // by episode
};

const ContinuousEpisode& episode_of(const ContinuousResult& walk,
                                    const ContinuousEpisodes& episodes) {
  if (walk.episode < episodes.episodes.size()) return episodes.episodes[walk.episode];
  throw ArgumentError(
      fmt::format("a walk of episode {}; there are {}", walk.episode, episodes.episodes.size()));
}

void check_walk(const ContinuousResult& walk, const std::string& where) {
  check_sizes(walk, where);
  const auto stop = std::ranges::find(walk.actions, kStop);
  if (stop == walk.actions.end() || stop + 1 == walk.actions.end()) return;
  throw ArgumentError(fmt::format("{}: action {} is stop, and {} come after it", where,
                                  stop - walk.actions.begin(), walk.actions.end() - stop - 1));
}

Json poses_json(const ContinuousResult& walk, const std::string& where) {
  if (walk.headings.empty()) {
    throw ArgumentError(fmt::format("{}: its headings are not known; R2R's form has them", where));
  }
  Json list = Json::array();
  for (std::size_t k = 0; k < walk.positions.size(); ++k) {
    const double angle = formats::finite(walk.headings[k].value, where);
    list.push_back({{"position", formats::point_json(to_double(walk.positions[k]), where)},
                    {"heading", wrap_difference(-Radians(angle)).value},
                    {"stop", k > 0 && walk.actions[k - 1] == kStop}});
  }
  return list;
}

std::string r2r_text(std::span<const ContinuousResult> walks, const ContinuousEpisodes& episodes) {
  std::string text = "{";
  const char* before = "\n";
  for (const ContinuousResult& walk : walks) {
    const std::string id = text_of(episode_of(walk, episodes).id);
    const std::string where = fmt::format("the walk of episode {}", id);
    check_walk(walk, where);
    text += before + formats::dump(Json(id), where) + ": ";
    text += formats::dump(poses_json(walk, where), where);
    before = ",\n";
  }
  return text + "\n}\n";
}

std::string rxr_text(std::span<const ContinuousResult> walks, const ContinuousEpisodes& episodes) {
  std::vector<std::pair<FileId, std::string>> lines;
  for (const ContinuousResult& walk : walks) {
    const ContinuousEpisode& episode = episode_of(walk, episodes);
    const std::string where = fmt::format("the walk of episode {}", text_of(episode.id));
    check_walk(walk, where);
    if (!episode.instruction.id) {
      throw ArgumentError(fmt::format("{}: it has no instruction id; RxR's form has one", where));
    }
    Json path = Json::array();
    for (std::size_t k = 0; k < walk.positions.size(); ++k) {
      if (k > 0 && walk.positions[k] == walk.positions[k - 1]) continue;
      path.push_back(formats::point_json(to_double(walk.positions[k]), where));
    }
    const Json line{{"instruction_id", formats::id_json(*episode.instruction.id)},
                    {"path", std::move(path)}};
    lines.emplace_back(*episode.instruction.id, formats::dump(line, where) + "\n");
  }
  std::ranges::stable_sort(lines, {}, &std::pair<FileId, std::string>::first);
  std::string text;
  for (const auto& [id, line] : lines) text += line;
  return text;
}

}  // namespace

void check_sizes(const ContinuousResult& walk, std::string_view where) {
  const std::size_t poses = walk.positions.size();
  const bool fit = poses > 0 && walk.actions.size() == poses - 1 &&
                   (walk.headings.empty() || walk.headings.size() == poses) &&
                   (walk.collided.empty() || walk.collided.size() == poses - 1);
  if (!fit) {
    throw ArgumentError(fmt::format(
        "{}: {} positions, {} headings, {} actions, {} collisions; n + 1, n + 1 or 0, n, n or 0 "
        "are expected",
        where, poses, walk.headings.size(), walk.actions.size(), walk.collided.size()));
  }
}

std::vector<ContinuousResult> parse_continuous_results(std::string_view text,
                                                       const std::string& file,
                                                       const ContinuousEpisodes& episodes,
                                                       Coverage coverage) {
  return ResultsReader(file, episodes, coverage).read(text);
}

std::vector<ContinuousResult> load_continuous_results(const std::filesystem::path& file,
                                                      const ContinuousEpisodes& episodes,
                                                      Coverage coverage) {
  const TextFile content(file);
  return parse_continuous_results(content.text(), file.string(), episodes, coverage);
}

std::string to_json(std::span<const ContinuousResult> walks, const ContinuousEpisodes& episodes,
                    ContinuousForm form) {
  return form == ContinuousForm::kR2r ? r2r_text(walks, episodes) : rxr_text(walks, episodes);
}

}  // namespace enfilade::tasks
