// Reading of VLN-CE's episodes and experts' walks: enfilade/tasks/continuous_episodes.h.
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "enfilade/core/detail/json_entries.h"
#include "enfilade/core/text_file.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/formats/records.h"
#include "enfilade/tasks/formats/vln_ce.h"
#include "enfilade/tasks/formats/vln_ce_fields.h"

namespace enfilade::tasks {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using namespace formats::vln_ce;

// Limit of a vocabulary and of fields that the model does not have: ten times XLM-R's 250,000
// words, four times over.
constexpr std::size_t kMostMemberBytes = std::size_t{1} << 28U;
constexpr std::int64_t kMostCount = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLastAction = 5;  // look down
// Rounding of what was computed in single precision.
constexpr double kTilt = 1e-6, kOffLength = 1e-3;

template <std::size_t kCount>
using Found = std::array<std::optional<Element>, kCount>;

std::string text_at(Element element, const Path& path, Faults& faults) {
  return std::string(json::string(element, path, faults).value_or(""));
}

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
  Found<kInfoFields> found;
  if (!formats::read_fields(element, kOfInfo, found, info.others, path, faults)) return info;
  if (found[kGeodesic]) {
    info.geodesic_distance = formats::read_length(*found[kGeodesic], "distance in metres",
                                                  Path(path, "geodesic_distance"), faults);
  }
  if (!found[kRole]) return info;
  const Path place(path, "role");
  const auto role = json::string(*found[kRole], place, faults);
  if (role == "guide") info.role = AnnotationRole::kGuide;
  if (role == "follower") info.role = AnnotationRole::kFollower;
  if (role && !info.role) {
    faults.error(place, "unknown-role",
                 fmt::format("{:?}, neither \"guide\" nor \"follower\"", *role));
  }
  return info;
}

ContinuousGoal read_goal(Element element, const Path& path, Faults& faults) {
  ContinuousGoal goal;
  Found<kGoalFields> found;
  if (!formats::read_fields(element, kOfGoal, found, goal.others, path, faults)) return goal;
  goal.position = formats::read_point(*found[kPosition], Path(path, "position"), faults);
  if (found[kRadius]) {
    goal.radius =
        formats::read_length(*found[kRadius], "radius in metres", Path(path, "radius"), faults);
  }
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
  Found<kInstructionFields> found;
  if (!formats::read_fields(element, kOfInstruction, found, instruction.others, path, faults)) {
    return instruction;
  }
  const auto place = [&path](OfInstruction field) {
    return Path(path, kOfInstruction[field].name);
  };
  instruction.text = text_at(*found[kText], place(kText), faults);
  if (found[kTokens]) {
    instruction.tokens = formats::read_tokens(*found[kTokens], place(kTokens), faults);
  }
  if (found[kInstructionId]) {
    instruction.id = formats::read_id(*found[kInstructionId], place(kInstructionId), faults);
  }
  if (found[kLanguage]) instruction.language = text_at(*found[kLanguage], place(kLanguage), faults);
  if (found[kAnnotator]) {
    instruction.annotator = formats::read_id(*found[kAnnotator], place(kAnnotator), faults);
  }
  if (found[kEdits]) {
    instruction.edit_distance = json::number(*found[kEdits], place(kEdits), faults);
  }
  if (found[kWords]) {
    instruction.words = formats::read_timed_words(*found[kWords], place(kWords), faults);
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
  Found<kEpisodeFields> found;
  if (!formats::read_fields(element, kOfEpisode, found, episode.others, path, faults)) return read;
  const auto place = [&path](OfEpisode field) { return Path(path, kOfEpisode[field].name); };
  const auto id = formats::read_id(*found[kId], place(kId), faults);
  read.has_id = id.has_value();
  if (id) episode.id = *id;
  episode.trajectory_id =
      formats::read_id(*found[kTrajectory], place(kTrajectory), faults).value_or(FileId());
  if (const auto scene = json::string(*found[kScene], place(kScene), faults)) {
    episode.scene = *scene;
    if (episode.scan().empty()) {
      faults.error(place(kScene), "bad-scene",
                   fmt::format("{:?} names no scan; \"mp3d/SCAN/SCAN.glb\" does", *scene));
    }
  }
  episode.start = formats::read_point(*found[kStart], place(kStart), faults);
  episode.rotation = read_rotation(*found[kRotation], place(kRotation), faults);
  if (found[kInfo]) episode.info = read_info(*found[kInfo], place(kInfo), faults);
  if (found[kGoals]) episode.goals = read_goals(*found[kGoals], place(kGoals), faults);
  episode.instruction = read_instruction(*found[kInstruction], place(kInstruction), faults);
  if (found[kReference]) {
    episode.reference_path = formats::read_points(*found[kReference], place(kReference), faults);
  }
  return read;
}

// Reads the list one episode at a time.
class EpisodesReader {
 public:
  EpisodesReader(std::vector<ContinuousEpisode>& episodes, Faults& faults)
      : episodes_(episodes), faults_(faults) {}

  void read(std::string_view list, const Path& path) {
    json::Entries entries(list, faults_.file(), formats::kMostRecordBytes);
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
        formats::refuse_large(entries.bytes(), place, faults_);
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
                  fmt::format("{:?} stands at $.episodes[{}] already", id, first->second));
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
    if (!value) formats::refuse_large(members.value().size(), path, faults, kMostMemberBytes);
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
  Found<kVocabularyFields> found;
  if (!formats::read_fields(element, kOfVocabulary, found, vocabulary.others, path, faults)) {
    return vocabulary;
  }
  vocabulary.words = json::strings(*found[kWordList], Path(path, "word_list"), faults);
  const auto count = [&](OfVocabulary field, std::string_view what) -> std::optional<std::int64_t> {
    if (!found[field]) return std::nullopt;
    return formats::read_count(*found[field], what, kMostCount,
                               Path(path, kOfVocabulary[field].name), faults);
  };
  vocabulary.size = count(kSize, "number of words");
  vocabulary.unknown = count(kUnknown, "token");
  vocabulary.padding = count(kPadding, "token");
  return vocabulary;
}

ExpertWalk read_walk(Element element, const Path& path, Faults& faults) {
  ExpertWalk walk;
  Found<kWalkFields> found;
  if (!formats::read_fields(element, kOfWalk, found, walk.others, path, faults)) return walk;
  walk.locations = formats::read_points(*found[kLocations], Path(path, "locations"), faults);
  walk.forward_steps = formats::read_count(*found[kSteps], "number of steps", kMostCount,
                                           Path(path, "forward_steps"), faults);
  const Path actions(path, "actions");
  const auto list = json::array(*found[kActions], actions, faults);
  if (!list) return walk;
  walk.actions.reserve(list->size());
  for (const Element one : *list) {
    if (faults.full()) break;
    const Path place(actions, walk.actions.size());
    walk.actions.push_back(
        static_cast<std::uint8_t>(formats::read_count(one, "action", kLastAction, place, faults)));
  }
  return walk;
}

}  // namespace

ContinuousEpisodes parse_continuous_episodes(std::string_view json, const std::string& file,
                                             std::string split) {
  ContinuousEpisodes result{std::move(split), file, {}};
  Faults faults(file);
  const Path root;
  const Path list(root, kOfFile[kEpisodes].name), words(root, kOfFile[kVocabulary].name);
  std::unordered_set<std::string> seen;
  formats::for_each_member(json, faults, [&](json::Members& members, const Path& path) {
    if (!seen.insert(members.key()).second) {
      faults.error(path, "repeated-field", "given twice in one object");
    } else if (members.key() == kOfFile[kEpisodes].name) {
      read_episodes(members, list, faults, result.episodes);
    } else if (const auto value = members.element(kMostMemberBytes); !value) {
      formats::refuse_large(members.value().size(), path, faults, kMostMemberBytes);
    } else if (members.key() != kOfFile[kVocabulary].name) {
      result.others.emplace_back(members.key(), formats::read_other(*value, path, faults));
    } else if (!value->is_null()) {
      result.vocabulary = read_vocabulary(*value, words, faults);
    }
  });
  if (faults.errors() == 0 && !seen.contains(std::string(kOfFile[kEpisodes].name))) {
    faults.error(root, "missing-field", fmt::format("has no field {:?}", kOfFile[kEpisodes].name));
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
  formats::for_each_member(json, faults, [&](json::Members& members, const Path& path) {
    const auto value = members.element(formats::kMostRecordBytes);
    if (!value) {
      formats::refuse_large(members.value().size(), path, faults);
      return;
    }
    const bool fresh = walks.emplace(members.key(), read_walk(*value, path, faults)).second;
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
