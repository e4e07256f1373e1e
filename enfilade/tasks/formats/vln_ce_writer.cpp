// The model of VLN-CE's episodes, and their writing: enfilade/tasks/continuous_episodes.h.
#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/habitat_frame.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/formats/records.h"
#include "enfilade/tasks/formats/vln_ce.h"
#include "enfilade/tasks/formats/vln_ce_fields.h"

namespace enfilade::tasks {
namespace {

using Json = nlohmann::ordered_json;
using namespace formats::vln_ce;

template <class Names>
std::string name(const Names& names, std::size_t field) {
  return std::string(names[field].name);
}

Json json_of(const EpisodeInfo& info, std::string_view where) {
  Json fields = Json::object();
  if (info.geodesic_distance) {
    fields[name(kOfInfo, kGeodesic)] = formats::finite(*info.geodesic_distance, where);
  }
  if (info.role) {
    fields[name(kOfInfo, kRole)] = *info.role == AnnotationRole::kGuide ? "guide" : "follower";
  }
  formats::add_others(info.others, kOfInfo, fields, where);
  return fields;
}

Json json_of(const ContinuousGoal& goal, std::string_view where) {
  Json fields{{name(kOfGoal, kPosition), formats::point_json(goal.position, where)}};
  if (goal.radius) fields[name(kOfGoal, kRadius)] = formats::finite(*goal.radius, where);
  formats::add_others(goal.others, kOfGoal, fields, where);
  return fields;
}

Json json_of(const ContinuousInstruction& instruction, std::string_view where) {
  Json fields{{name(kOfInstruction, kText), instruction.text}};
  if (instruction.tokens) fields[name(kOfInstruction, kTokens)] = *instruction.tokens;
  if (instruction.id) {
    fields[name(kOfInstruction, kInstructionId)] = formats::id_json(*instruction.id);
  }
  if (instruction.language) fields[name(kOfInstruction, kLanguage)] = *instruction.language;
  if (instruction.annotator) {
    fields[name(kOfInstruction, kAnnotator)] = formats::id_json(*instruction.annotator);
  }
  if (instruction.edit_distance) {
    fields[name(kOfInstruction, kEdits)] = formats::finite(*instruction.edit_distance, where);
  }
  if (instruction.words) {
    fields[name(kOfInstruction, kWords)] = formats::timed_words_json(*instruction.words, where);
  }
  formats::add_others(instruction.others, kOfInstruction, fields, where);
  return fields;
}

Json json_of(const ContinuousEpisode& episode, std::string_view where) {
  const StartRotation& turned = episode.rotation;
  Json rotation = Json::array();
  for (const double part : {turned.x, turned.y, turned.z, turned.w}) {
    rotation.push_back(formats::finite(part, where));
  }
  Json fields{{name(kOfEpisode, kId), formats::id_json(episode.id)},
              {name(kOfEpisode, kTrajectory), formats::id_json(episode.trajectory_id)},
              {name(kOfEpisode, kScene), episode.scene},
              {name(kOfEpisode, kStart), formats::point_json(episode.start, where)},
              {name(kOfEpisode, kRotation), std::move(rotation)}};
  if (episode.info) fields[name(kOfEpisode, kInfo)] = json_of(*episode.info, where);
  if (episode.goals) {
    Json goals = Json::array();
    for (const ContinuousGoal& goal : *episode.goals) goals.push_back(json_of(goal, where));
    fields[name(kOfEpisode, kGoals)] = std::move(goals);
  }
  fields[name(kOfEpisode, kInstruction)] = json_of(episode.instruction, where);
  if (episode.reference_path) {
    fields[name(kOfEpisode, kReference)] = formats::points_json(*episode.reference_path, where);
  }
  formats::add_others(episode.others, kOfEpisode, fields, where);
  return fields;
}

Json json_of(const InstructionVocabulary& vocabulary, std::string_view where) {
  Json fields{{name(kOfVocabulary, kWordList), vocabulary.words}};
  formats::add_others(vocabulary.others, kOfVocabulary, fields, where);
  if (vocabulary.size) fields[name(kOfVocabulary, kSize)] = *vocabulary.size;
  if (vocabulary.unknown) fields[name(kOfVocabulary, kUnknown)] = *vocabulary.unknown;
  if (vocabulary.padding) fields[name(kOfVocabulary, kPadding)] = *vocabulary.padding;
  return fields;
}

Json json_of(const ExpertWalk& walk, std::string_view where) {
  Json fields{{name(kOfWalk, kLocations), formats::points_json(walk.locations, where)},
              {name(kOfWalk, kSteps), walk.forward_steps},
              {name(kOfWalk, kActions), Json::array()}};
  Json& actions = fields[name(kOfWalk, kActions)];
  for (const std::uint8_t action : walk.actions) actions.push_back(static_cast<int>(action));
  formats::add_others(walk.others, kOfWalk, fields, where);
  return fields;
}

}  // namespace

std::string text_of(const FileId& id) {
  const auto* text = std::get_if<std::string>(&id);
  return text != nullptr ? *text : fmt::to_string(std::get<std::int64_t>(id));
}

Radians StartRotation::heading() const { return from_habitat(HabitatYaw{y, w}); }

StartRotation StartRotation::of(Radians heading) {
  const HabitatYaw yaw = to_habitat(heading);
  return {0, yaw.y, 0, yaw.w};
}

std::string_view ContinuousEpisode::scan() const noexcept {
  std::string_view name = scene;
  name.remove_prefix(name.rfind('/') + 1);  // npos + 1 is 0: no folder
  return name.substr(0, name.find('.'));
}

bool goals_hidden(const ContinuousEpisodes& episodes) noexcept {
  return std::ranges::any_of(episodes.episodes, &ContinuousEpisode::goal_hidden);
}

ContinuousForm form_of(const ContinuousEpisodes& episodes) noexcept {
  constexpr std::int64_t kBertWords = 30522, kBertUnknown = 100;
  constexpr std::size_t kBertTokens = 80;
  const auto any = [&episodes](const auto& holds) {
    return std::ranges::any_of(episodes.episodes, holds);
  };
  if (any([](const ContinuousEpisode& one) {
        return one.instruction.language || (one.info && one.info->role);
      })) {
    return ContinuousForm::kRxr;
  }
  if (episodes.vocabulary && (episodes.vocabulary->size == kBertWords ||
                              episodes.vocabulary->words.size() == std::size_t{kBertWords} ||
                              episodes.vocabulary->unknown == kBertUnknown)) {
    return ContinuousForm::kR2rBert;
  }
  const bool short_tokens = any([](const ContinuousEpisode& one) {
    return one.instruction.tokens && one.instruction.tokens->size() == kBertTokens;
  });
  return short_tokens ? ContinuousForm::kR2rBert : ContinuousForm::kR2r;
}

std::string to_json(const ContinuousEpisodes& episodes) {
  std::string text = R"({"episodes": [)";
  const char* before = "\n";
  for (const ContinuousEpisode& episode : episodes.episodes) {
    const std::string where = fmt::format("episode {}", text_of(episode.id));
    text += before;
    text += formats::dump(json_of(episode, where), where);
    before = ",\n";
  }
  text += "]";
  const auto add = [&text](std::string_view key, const Json& value, std::string_view where) {
    text += ",\n" + formats::dump(Json(key), where) + ": " + formats::dump(value, where);
  };
  if (episodes.vocabulary) {
    const std::string key = name(kOfFile, kVocabulary);
    add(key, json_of(*episodes.vocabulary, key), key);
  }
  Json others = Json::object();
  formats::add_others(episodes.others, kOfFile, others, "the file");
  for (const auto& [key, value] : others.items()) add(key, value, "the file");
  return text + "}\n";
}

std::string to_json(const ExpertWalks& walks) {
  std::string text = "{";
  const char* before = "\n";
  for (const auto& [id, walk] : walks) {
    const std::string where = fmt::format("the walk of episode {}", id);
    text += before + formats::dump(Json(id), where) + ": ";
    text += formats::dump(json_of(walk, where), where);
    before = ",\n";
  }
  return text + "\n}\n";
}

}  // namespace enfilade::tasks
