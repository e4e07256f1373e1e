/// \file  Names of the fields of VLN-CE's files, in the order in which they are written. Internal.
#pragma once
#include <array>
#include <cstddef>

#include "enfilade/core/detail/json.h"

namespace enfilade::tasks::formats::vln_ce {

enum OfFile : std::size_t { kEpisodes, kVocabulary, kFileFields };
inline constexpr std::array<json::Field, kFileFields> kOfFile{
    {{"episodes"}, {"instruction_vocab", false}}};

enum OfEpisode : std::size_t {
  kId,
  kTrajectory,
  kScene,
  kStart,
  kRotation,
  kInfo,
  kGoals,
  kInstruction,
  kReference,
  kEpisodeFields
};
inline constexpr std::array<json::Field, kEpisodeFields> kOfEpisode{{{"episode_id"},
                                                                     {"trajectory_id"},
                                                                     {"scene_id"},
                                                                     {"start_position"},
                                                                     {"start_rotation"},
                                                                     {"info", false},
                                                                     {"goals", false},
                                                                     {"instruction"},
                                                                     {"reference_path", false}}};

enum OfInfo : std::size_t { kGeodesic, kRole, kInfoFields };
inline constexpr std::array<json::Field, kInfoFields> kOfInfo{
    {{"geodesic_distance", false}, {"role", false}}};

enum OfGoal : std::size_t { kPosition, kRadius, kGoalFields };
inline constexpr std::array<json::Field, kGoalFields> kOfGoal{{{"position"}, {"radius", false}}};

enum OfInstruction : std::size_t {
  kText,
  kTokens,
  kInstructionId,
  kLanguage,
  kAnnotator,
  kEdits,
  kWords,
  kInstructionFields
};
inline constexpr std::array<json::Field, kInstructionFields> kOfInstruction{
    {{"instruction_text"},
     {"instruction_tokens", false},
     {"instruction_id", false},
     {"language", false},
     {"annotator_id", false},
     {"edit_distance", false},
     {"timed_instruction", false}}};

enum OfVocabulary : std::size_t { kWordList, kSize, kUnknown, kPadding, kVocabularyFields };
inline constexpr std::array<json::Field, kVocabularyFields> kOfVocabulary{
    {{"word_list"}, {"num_vocab", false}, {"UNK_INDEX", false}, {"PAD_INDEX", false}}};

enum OfWalk : std::size_t { kLocations, kSteps, kActions, kWalkFields };
inline constexpr std::array<json::Field, kWalkFields> kOfWalk{
    {{"locations"}, {"forward_steps"}, {"actions"}}};

}  // namespace enfilade::tasks::formats::vln_ce
