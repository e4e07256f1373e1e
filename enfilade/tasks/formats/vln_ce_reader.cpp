// Reading of VLN-CE's episodes and experts' walks: enfilade/tasks/continuous_episodes.h.
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "enfilade/core/detail/json_entries.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/names.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/formats/records.h"
#include "enfilade/tasks/formats/vln_ce.h"

namespace enfilade::tasks {
namespace {

using namespace formats;

// Limit of a vocabulary and of fields that the model does not have: ten times XLM-R's 250,000
// words, four times over.
constexpr std::size_t kMostMemberBytes = std::size_t{1} << 28U;
constexpr std::int64_t kMostCount = std::numeric_limits<std::int64_t>::max();
constexpr std::string_view kEpisodes = kOfFile[0].name, kVocabulary = kOfFile[1].name;
constexpr std::int64_t kLastAction = 5;  // look down
// Rounding of what was computed in single precision.
constexpr double kTilt = 1e-6, kOffLength = 1e-3;

StartRotation read_rotation(Element element, const Path& path, Faults& faults) {
  StartRotation rotation;
  const auto list = json::array(element, path, faults);
  if (!list) return rotation;
  if (list->size() != 4) {
    faults.error(path, "bad-rotation",
                 fmt::format("{} numbers, not 4: a quaternion x, y, z, w", list->size()));
    return rotation;
  }
  const std::size_t errors = faults.errors();
  std::size_t k = 0;
  for (double* const part : {&rotation.x, &rotation.y, &rotation.z, &rotation.w}) {
    *part = json::number(list->at(k).value_unsafe(), Path(path, k), faults).value_or(0);
    ++k;
  }
  if (faults.errors() != errors) return {};
  const double length = std::hypot(rotation.y, rotation.w);
  if (std::abs(rotation.x) > kTilt || std::abs(rotation.z) > kTilt ||
      std::abs(length - 1) > kOffLength) {
    faults.error(path, "bad-rotation",
                 fmt::format("[{}, {}, {}, {}] is no rotation about the vertical axis; [0, y, 0, "
                             "w] of length 1 is",
                             rotation.x, rotation.y, rotation.z, rotation.w));
    return {};
  }
  return rotation;
}

EpisodeInfo read_info(Element element, const Path& path, Faults& faults) {
  EpisodeInfo info;
  const FieldsAndOthers found(element, kOfInfo, info.others, path, faults);
  if (!found) return info;
  info.geodesic_distance = found.get("geodesic_distance", read_length, "distance in metres");
  const auto role = found.get("role", json::string);
  if (role == "guide") info.role = AnnotationRole::kGuide;
  if (role == "follower") info.role = AnnotationRole::kFollower;
  if (role && !info.role) {
    faults.error(found.place("role"), "unknown-role",
                 quote(*role) + ", neither \"guide\" nor \"follower\"");
  }
  return info;
}

ContinuousGoal read_goal(Element element, const Path& path, Faults& faults) {
  ContinuousGoal goal;
  const FieldsAndOthers found(element, kOfGoal, goal.others, path, faults);
  if (!found) return goal;
  goal.position = found.get("position", read_point);
  goal.radius = found.get("radius", read_length, "radius in metres");
  return goal;
}

std::vector<ContinuousGoal> read_goals(Element element, const Path& path, Faults& faults) {
  std::vector<ContinuousGoal> goals;
  const auto list = json::array(element, path, faults);
  if (!list) return goals;
  for (const Element one : *list) {
    if (faults.full()) break;
    goals.push_back(read_goal(one, Path(path, goals.size()), faults));
  }
  if (goals.empty()) {
    faults.error(path, "no-goal", "no goal; one at least is expected, or no field of this name");
  }
  return goals;
}

ContinuousInstruction read_instruction(Element element, const Path& path, Faults& faults) {
  ContinuousInstruction instruction;
  const FieldsAndOthers found(element, kOfInstruction, instruction.others, path, faults);
  if (!found) return instruction;
  instruction.text = found.text("instruction_text");
  if (found.has("instruction_tokens")) {
    instruction.tokens = found.get("instruction_tokens", read_tokens);
  }
  instruction.id = found.get("instruction_id", read_id);
  if (found.has("language")) instruction.language = found.text("language");
  instruction.annotator = found.get("annotator_id", read_id);
  instruction.edit_distance = found.get("edit_distance", json::number);
  if (found.has("timed_instruction")) {
    instruction.words = found.get("timed_instruction", read_timed_words);
  }
  return instruction;
}

// What comes of an episode; no id if it could not be read.
struct Read {
  ContinuousEpisode episode;
  bool has_id = false;
};

Read read_episode(Element element, const Path& path, Faults& faults) {
  Read read;
  ContinuousEpisode& episode = read.episode;
  const FieldsAndOthers found(element, kOfEpisode, episode.others, path, faults);
  if (!found) return read;
  const auto id = found.get("episode_id", read_id);
  read.has_id = id.has_value();
  if (id) episode.id = *id;
  episode.trajectory_id = found.get("trajectory_id", read_id).value_or(FileId());
  if (const auto scene = found.get("scene_id", json::string)) {
    episode.scene = *scene;
    if (episode.scan().empty()) {
      faults.error(found.place("scene_id"), "bad-scene",
                   quote(*scene) + " names no scan; \"mp3d/SCAN/SCAN.glb\" does");
    } else if (std::string fault = fault_of_id(episode.scan()); !fault.empty()) {
      faults.error(found.place("scene_id"), "bad-id", std::move(fault));
    }
  }
  episode.start = found.get("start_position", read_point);
  episode.rotation = found.get("start_rotation", read_rotation);
  if (found.has("info")) episode.info = found.get("info", read_info);
  if (found.has("goals")) episode.goals = found.get("goals", read_goals);
  episode.instruction = found.get("instruction", read_instruction);
  if (found.has("reference_path")) {
    episode.reference_path = found.get("reference_path", read_points);
  }
  return read;
}

// Reads the list one episode at a time.
class EpisodesReader {
 public:
  EpisodesReader(std::vector<ContinuousEpisode>& episodes, Faults& faults)
      : episodes_(episodes), faults_(faults) {}

  void read(std::string_view list, const Path& path) {
    json::Entries entries(list, faults_.file(), kMostRecordBytes);
    if (!entries.is_list(faults_)) return;
    while (entries.next()) {
      const Path place(path, entries.index());
      if (faults_.full()) {
        faults_.stop(place);
        return;
      }
      if (entries.element()) {
        add(read_episode(*entries.element(), place, faults_), place);
      } else {
        refuse_large(entries.bytes(), place, faults_);
        episodes_.emplace_back();
      }
    }
  }

 private:
  void add(Read read, const Path& place) {
    const std::size_t index = episodes_.size();
    episodes_.push_back(std::move(read.episode));
    if (!read.has_id) return;
    const std::string id = text_of(episodes_.back().id);
    const auto [first, fresh] = places_.emplace(id, index);
    if (fresh) return;
    faults_.error(Path(place, "episode_id"), "repeated-id",
                  fmt::format("{} stands at $.episodes[{}] already", quote(id), first->second));
  }

  std::vector<ContinuousEpisode>& episodes_;
  Faults& faults_;
  std::unordered_map<std::string, std::size_t> places_;
};

void read_episodes(json::Members& members, const Path& path, Faults& faults,
                   std::vector<ContinuousEpisode>& episodes) {
  if (!members.value().starts_with('[')) {
    const auto value = members.element(kMostMemberBytes);
    if (value) json::array(*value, path, faults);
    if (!value) refuse_large(members.value().size(), path, faults, kMostMemberBytes);
    return;
  }
  try {
    EpisodesReader(episodes, faults).read(members.value(), path);
  } catch (const InvalidInput&) {
    members.check_whole();  // says where in the file it is
    throw;
  }
}

InstructionVocabulary read_vocabulary(Element element, const Path& path, Faults& faults) {
  InstructionVocabulary vocabulary;
  const FieldsAndOthers found(element, kOfVocabulary, vocabulary.others, path, faults);
  if (!found) return vocabulary;
  vocabulary.words = found.get("word_list", json::strings);
  const auto count = [&found](std::string_view name, std::string_view what) {
    return found.has(name) ? std::optional(found.get(name, read_count, what, kMostCount))
                           : std::nullopt;
  };
  vocabulary.size = count("num_vocab", "number of words");
  vocabulary.unknown = count("UNK_INDEX", "token");
  vocabulary.padding = count("PAD_INDEX", "token");
  return vocabulary;
}

ExpertWalk read_expert_walk(Element element, const Path& path, Faults& faults) {
  ExpertWalk walk;
  const FieldsAndOthers found(element, kOfWalk, walk.others, path, faults);
  if (!found) return walk;
  walk.locations = found.get("locations", read_points);
  walk.forward_steps = found.get("forward_steps", read_count, "number of steps", kMostCount);
  const Path actions = found.place("actions");
  const auto list = found.get("actions", json::array);
  if (!list) return walk;
  walk.actions.reserve(list->size());
  for (const Element one : *list) {
    if (faults.full()) break;
    const Path place(actions, walk.actions.size());
    walk.actions.push_back(
        static_cast<std::uint8_t>(read_count(one, place, faults, "action", kLastAction)));
  }
  return walk;
}

}  // namespace

ContinuousEpisodes parse_continuous_episodes(std::string_view json, const std::string& file,
                                             std::string split) {
  ContinuousEpisodes result{std::move(split), file, {}};
  Faults faults(file);
  const Path root;
  const Path list(root, kEpisodes), words(root, kVocabulary);
  std::unordered_set<std::string> seen;
  for_each_member(json, faults, [&](json::Members& members, const Path& path) {
    if (!seen.insert(members.key()).second) {
      faults.error(path, "repeated-field", "given twice in one object");
    } else if (members.key() == kEpisodes) {
      read_episodes(members, list, faults, result.episodes);
    } else if (const auto value = members.element(kMostMemberBytes); !value) {
      refuse_large(members.value().size(), path, faults, kMostMemberBytes);
    } else if (members.key() != kVocabulary) {
      result.others.emplace_back(members.key(), read_other(*value, path, faults));
    } else if (!value->is_null()) {
      result.vocabulary = read_vocabulary(*value, words, faults);
    }
  });
  if (faults.errors() == 0 && !seen.contains(std::string(kEpisodes))) {
    faults.error(root, "missing-field", fmt::format("has no field {}", quote(kEpisodes)));
  }
  faults.throw_if_errors();
  return result;
}

ContinuousEpisodes load_continuous_episodes(const std::filesystem::path& file, std::string split) {
  const TextFile content(file);
  return parse_continuous_episodes(content.text(), file.string(), std::move(split));
}

ExpertWalks parse_expert_walks(std::string_view json, const std::string& file) {
  ExpertWalks walks;
  Faults faults(file);
  for_each_member(json, faults, [&](json::Members& members, const Path& path) {
    const auto value = members.element(kMostRecordBytes);
    if (!value) {
      refuse_large(members.value().size(), path, faults);
      return;
    }
    if (std::string fault = fault_of_id(members.key()); !fault.empty()) {
      faults.error(path, "bad-id", std::move(fault));
      return;
    }
    const bool fresh = walks.emplace(members.key(), read_expert_walk(*value, path, faults)).second;
    if (!fresh) faults.error(path, "repeated-id", "a walk of this episode is there already");
  });
  faults.throw_if_errors();
  return walks;
}

ExpertWalks load_expert_walks(const std::filesystem::path& file) {
  const TextFile content(file);
  return parse_expert_walks(content.text(), file.string());
}

}  // namespace enfilade::tasks
