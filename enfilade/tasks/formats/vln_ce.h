/// \file  Shared functions of readers and writers of VLN-CE's files: points, ids, and fields that
/// the model does not have. Internal, as it includes simdjson.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::tasks::formats {

/// A value that the model has no place for, as JSON without blanks. Reports a field that an object
/// in it has twice.
std::string read_other(json::Element element, const json::Path& path, json::Faults& faults);
/// As json::fields(), but null counts as absent where the field is not required, and fields of
/// other names are given.
bool read_fields(json::Element element, std::span<const json::Field> wanted,
                 std::span<std::optional<json::Element>> found, OtherFields& others,
                 const json::Path& path, json::Faults& faults);

/// Habitat's [x, y, z] as a point of our world frame; reports another number of elements.
Vec3d read_point(json::Element element, const json::Path& path, json::Faults& faults);
/// A list of them; reports an empty one.
std::vector<Vec3d> read_points(json::Element element, const json::Path& path, json::Faults& faults);
/// A whole number, or a text that is not empty.
std::optional<FileId> read_id(json::Element element, const json::Path& path, json::Faults& faults);
/// A number from 0 on. \param what  "distance in metres"
std::optional<double> read_length(json::Element element, std::string_view what,
                                  const json::Path& path, json::Faults& faults);
/// A whole number from 0 to `most`, or 0 after it was reported. \param what  "token"
std::int64_t read_count(json::Element element, std::string_view what, std::int64_t most,
                        const json::Path& path, json::Faults& faults);

/// \name Each throws ArgumentError for an infinite number, beginning with `where`
/// @{
double finite(double number, std::string_view where);
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
/// The text of a value. \throws ArgumentError, beginning with `where`, for text that is not UTF-8
std::string dump(const nlohmann::ordered_json& value, std::string_view where);

}  // namespace enfilade::tasks::formats
