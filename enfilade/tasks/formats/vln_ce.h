/// \file  Shared functions of readers and writers of VLN-CE's files: points, ids, and fields that
/// the model does not have. Internal, as it includes simdjson.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {

/// A value that the model has no place for, as JSON without blanks. Reports a field that an object
/// in it has twice.
std::string read_other(Element element, const Path& path, Faults& faults);
/// As Fields, but null counts as absent where the field is not required, and fields of other names
/// are given.
class FieldsAndOthers : public Fields {
 public:
  FieldsAndOthers(Element element, std::span<const json::Field> wanted, OtherFields& others,
                  const Path& path, Faults& faults);
};

/// Habitat's [x, y, z] as a point of our world frame; reports another number of elements.
Vec3d read_point(Element element, const Path& path, Faults& faults);
/// A list of them; reports an empty one.
std::vector<Vec3d> read_points(Element element, const Path& path, Faults& faults);
/// A whole number, or a text that is not empty.
std::optional<FileId> read_id(Element element, const Path& path, Faults& faults);
/// A number from 0 on. \param what  "distance in metres"
std::optional<double> read_length(Element element, const Path& path, Faults& faults,
                                  std::string_view what);
/// A whole number from 0 to `most`, or 0 after it was reported. \param what  "token"
std::int64_t read_count(Element element, const Path& path, Faults& faults, std::string_view what,
                        std::int64_t most);

/// \name Each throws ArgumentError for an infinite number, beginning with `where`
/// @{
nlohmann::ordered_json point_json(Vec3d point, std::string_view where);
nlohmann::ordered_json points_json(std::span<const Vec3d> points, std::string_view where);
/// @}
nlohmann::ordered_json id_json(const FileId& id);
/// Adds them behind the others.
/// \param known  names that are no other fields
/// \throws ArgumentError, beginning with `where`, for a value that is no JSON, and for a name that
/// is known or there twice
void add_others(const OtherFields& others, std::span<const json::Field> known,
                nlohmann::ordered_json& fields, std::string_view where);

// Names of the fields, in the order in which they are written.

inline constexpr auto kOfFile =
    std::to_array<json::Field>({{"episodes"}, {"instruction_vocab", false}});
inline constexpr auto kOfEpisode = std::to_array<json::Field>({{"episode_id"},
                                                               {"trajectory_id"},
                                                               {"scene_id"},
                                                               {"start_position"},
                                                               {"start_rotation"},
                                                               {"info", false},
                                                               {"goals", false},
                                                               {"instruction"},
                                                               {"reference_path", false}});
inline constexpr auto kOfInfo =
    std::to_array<json::Field>({{"geodesic_distance", false}, {"role", false}});
inline constexpr auto kOfGoal = std::to_array<json::Field>({{"position"}, {"radius", false}});
inline constexpr auto kOfInstruction = std::to_array<json::Field>({{"instruction_text"},
                                                                   {"instruction_tokens", false},
                                                                   {"instruction_id", false},
                                                                   {"language", false},
                                                                   {"annotator_id", false},
                                                                   {"edit_distance", false},
                                                                   {"timed_instruction", false}});
inline constexpr auto kOfVocabulary = std::to_array<json::Field>(
    {{"word_list"}, {"num_vocab", false}, {"UNK_INDEX", false}, {"PAD_INDEX", false}});
inline constexpr auto kOfWalk =
    std::to_array<json::Field>({{"locations"}, {"forward_steps"}, {"actions"}});

}  // namespace enfilade::tasks::formats
