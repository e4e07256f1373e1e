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

namespace enfilade::tasks {
namespace {

using Json = nlohmann::ordered_json;
using namespace formats;

Json json_of(const EpisodeInfo& info, std::string_view where) {
  Json fields = Json::object();
  if (info.geodesic_distance) {
    fields["geodesic_distance"] = finite(*info.geodesic_distance, where);
  }
  if (info.role) {
    fields["role"] = *info.role == AnnotationRole::kGuide ? "guide" : "follower";
  }
  add_others(info.others, kOfInfo, fields, where);
  return fields;
}

Json json_of(const ContinuousGoal& goal, std::string_view where) {
  Json fields{{"position", point_json(goal.position, where)}};
  if (goal.radius) fields["radius"] = finite(*goal.radius, where);
  add_others(goal.others, kOfGoal, fields, where);
  return fields;
}

Json json_of(const ContinuousInstruction& instruction, std::string_view where) {
  Json fields{{"instruction_text", instruction.text}};
  if (instruction.tokens) fields["instruction_tokens"] = *instruction.tokens;
  if (instruction.id) {
    fields["instruction_id"] = id_json(*instruction.id);
  }
  if (instruction.language) fields["language"] = *instruction.language;
  if (instruction.annotator) {
    fields["annotator_id"] = id_json(*instruction.annotator);
  }
  if (instruction.edit_distance) {
    fields["edit_distance"] = finite(*instruction.edit_distance, where);
  }
  if (instruction.words) {
    fields["timed_instruction"] = timed_words_json(*instruction.words, where);
  }
  add_others(instruction.others, kOfInstruction, fields, where);
  return fields;
}

Json json_of(const ContinuousEpisode& episode, std::string_view where) {
  const StartRotation& turned = episode.rotation;
  Json rotation = Json::array();
  for (const double part : {turned.x, turned.y, turned.z, turned.w}) {
    rotation.push_back(finite(part, where));
  }
  Json fields{{"episode_id", id_json(episode.id)},
              {"trajectory_id", id_json(episode.trajectory_id)},
              {"scene_id", episode.scene},
              {"start_position", point_json(episode.start, where)},
              {"start_rotation", std::move(rotation)}};
  if (episode.info) fields["info"] = json_of(*episode.info, where);
  if (episode.goals) {
    Json goals = Json::array();
    for (const ContinuousGoal& goal : *episode.goals) goals.push_back(json_of(goal, where));
    fields["goals"] = std::move(goals);
  }
  fields["instruction"] = json_of(episode.instruction, where);
  if (episode.reference_path) {
    fields["reference_path"] = points_json(*episode.reference_path, where);
  }
  add_others(episode.others, kOfEpisode, fields, where);
  return fields;
}

Json json_of(const InstructionVocabulary& vocabulary, std::string_view where) {
  Json fields{{"word_list", vocabulary.words}};
  add_others(vocabulary.others, kOfVocabulary, fields, where);
  if (vocabulary.size) fields["num_vocab"] = *vocabulary.size;
  if (vocabulary.unknown) fields["UNK_INDEX"] = *vocabulary.unknown;
  if (vocabulary.padding) fields["PAD_INDEX"] = *vocabulary.padding;
  return fields;
}

Json json_of(const ExpertWalk& walk, std::string_view where) {
  Json fields{{"locations", points_json(walk.locations, where)},
              {"forward_steps", walk.forward_steps},
              {"actions", Json::array()}};
  Json& actions = fields["actions"];
  for (const std::uint8_t action : walk.actions) actions.push_back(static_cast<int>(action));
  add_others(walk.others, kOfWalk, fields, where);
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

std::string_view scan_of_scene(std::string_view scene) noexcept {
  static constexpr std::string_view kSeparators = "/\\";
  const auto last_of = [](std::string_view path) {
    return path.substr(path.find_last_of(kSeparators) + 1);  // npos + 1 is 0: no folder
  };
  const std::string_view file = last_of(scene);
  const std::string_view name = file.substr(0, file.find('.'));
  const std::string_view above = scene.substr(0, scene.size() - file.size());
  if (above.empty() || name.empty()) return name;
  const std::string_view folder = last_of(above.substr(0, above.size() - 1));
  // "SCAN.2/SCAN.2.glb": an id with a dot in it.
  if (!folder.empty() && file.starts_with(folder) && file.substr(folder.size()).starts_with('.')) {
    return folder;
  }
  return scan::name_in_hm3d(folder) == name ? folder : name;
}

std::string scene_of_scan(std::string_view scan, std::string_view folder) {
  const std::string_view name = scan::name_in_hm3d(scan);
  if (name.empty()) return fmt::format("{0}/{1}/{1}.glb", folder, scan);
  const std::string_view split = !scan.starts_with("00") ? ""
                                 : scan[2] == '9'        ? "test/"
                                 : scan[2] == '8'        ? "val/"
                                                         : "train/";
  return fmt::format("hm3d/{}{}/{}.basis.glb", split, scan, name);
}

bool goals_hidden(const ContinuousEpisodes& episodes) noexcept {
  return std::ranges::any_of(episodes.episodes, &ContinuousEpisode::goal_hidden);
}

std::string to_json(const ContinuousEpisodes& episodes) {
  std::string text = R"({"episodes": [)";
  const char* before = "\n";
  for (const ContinuousEpisode& episode : episodes.episodes) {
    const std::string where = fmt::format("episode {}", text_of(episode.id));
    text += before;
    text += dump(json_of(episode, where), where);
    before = ",\n";
  }
  text += "]";
  const auto add = [&text](std::string_view key, const Json& value, std::string_view where) {
    text += ",\n" + dump(Json(key), where) + ": " + dump(value, where);
  };
  if (episodes.vocabulary) {
    const std::string key = "instruction_vocab";
    add(key, json_of(*episodes.vocabulary, key), key);
  }
  Json others = Json::object();
  add_others(episodes.others, kOfFile, others, "the file");
  for (const auto& [key, value] : others.items()) add(key, value, "the file");
  return text + "}\n";
}

std::string to_json(const ExpertWalks& walks) {
  std::string text = "{";
  const char* before = "\n";
  for (const auto& [id, walk] : walks) {
    const std::string where = fmt::format("the walk of episode {}", id);
    text += before + dump(Json(id), where) + ": ";
    text += dump(json_of(walk, where), where);
    before = ",\n";
  }
  return text + "\n}\n";
}

}  // namespace enfilade::tasks
