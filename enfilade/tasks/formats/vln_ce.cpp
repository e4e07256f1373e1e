#include "enfilade/tasks/formats/vln_ce.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <unordered_set>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/geometry/habitat_frame.h"

namespace enfilade::tasks::formats {

using Json = nlohmann::ordered_json;

namespace {

// Repeated names in objects: of two values readers keep one or the other.
void report_repeated(Element element, const Path& path, Faults& faults) {
  if (simdjson::dom::array list; element.get(list) == simdjson::SUCCESS) {
    std::size_t k = 0;
    for (const Element one : list) report_repeated(one, Path(path, k++), faults);
  }
  simdjson::dom::object object;
  if (element.get(object) != simdjson::SUCCESS) return;
  std::unordered_set<std::string_view> seen;
  for (const auto member : object) {
    const Path place(path, member.key);
    if (!seen.insert(member.key).second) {
      faults.error(place, "repeated-field", "given twice in one object");
    }
    report_repeated(member.value, place, faults);
  }
}

}  // namespace

std::string read_other(Element element, const Path& path, Faults& faults) {
  report_repeated(element, path, faults);
  return simdjson::minify(element);
}

FieldsAndOthers::FieldsAndOthers(Element element, std::span<const json::Field> wanted,
                                 OtherFields& others, const Path& path, Faults& faults)
    : Fields(element, wanted, path, faults) {
  if (!good_) return;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (!wanted[k].required && found_[k] && found_[k]->is_null()) found_[k].reset();
  }
  std::unordered_set<std::string_view> seen;
  const simdjson::dom::object members = element.get_object().value_unsafe();
  for (const auto member : members) {
    if (std::ranges::find(wanted, member.key, &json::Field::name) != wanted.end()) continue;
    const Path place(path, member.key);
    if (seen.insert(member.key).second) {
      others.emplace_back(std::string(member.key), read_other(member.value, place, faults));
      continue;
    }
    faults.error(place, "repeated-field", "given twice in one object");
    good_ = false;
  }
}

Vec3d read_point(Element element, const Path& path, Faults& faults) {
  const auto list = json::array(element, path, faults);
  if (!list) return {};
  if (list->size() != 3) {
    faults.error(path, "bad-point",
                 fmt::format("{} numbers, not 3: x, y (up) and z in metres", list->size()));
    return {};
  }
  Vec3d point;
  std::size_t k = 0;
  for (double* const coordinate : {&point.x, &point.y, &point.z}) {
    *coordinate = json::number(list->at(k).value_unsafe(), Path(path, k), faults).value_or(0);
    ++k;
    if (std::abs(*coordinate) <= kMostMetres) continue;
    faults.error(path, "bad-point", fmt::format("{} is no place in metres", *coordinate));
    return {};
  }
  return from_habitat(point);
}

std::vector<Vec3d> read_points(Element element, const Path& path, Faults& faults) {
  std::vector<Vec3d> points;
  const auto list = json::array(element, path, faults);
  if (!list) return points;
  points.reserve(list->size());
  for (const Element one : *list) {
    if (faults.full()) break;
    points.push_back(read_point(one, Path(path, points.size()), faults));
  }
  if (points.empty()) faults.error(path, "empty-path", "no point; one at least is expected");
  return points;
}

std::optional<FileId> read_id(Element element, const Path& path, Faults& faults) {
  std::string_view text;
  if (element.get(text) == simdjson::SUCCESS) {
    const auto id = json::id(element, path, faults);
    return id ? std::optional<FileId>(std::string(*id)) : std::nullopt;
  }
  std::int64_t number = 0;
  if (element.get(number) == simdjson::SUCCESS) return number;
  faults.error(path, "bad-id",
               fmt::format("{}, neither a whole number nor a text", json::describe(element)));
  return std::nullopt;
}

std::optional<double> read_length(Element element, const Path& path, Faults& faults,
                                  std::string_view what) {
  const auto number = json::number(element, path, faults);
  if (!number || *number >= 0) return number;
  faults.error(path, "bad-length", fmt::format("{} is no {}; 0 and more are", *number, what));
  return std::nullopt;
}

std::int64_t read_count(Element element, const Path& path, Faults& faults, std::string_view what,
                        std::int64_t most) {
  const auto number = json::integer(element, path, faults);
  if (!number || (*number >= 0 && *number <= most)) return number.value_or(0);
  faults.error(path, "out-of-range", fmt::format("{} is no {}; 0 to {} are", *number, what, most));
  return 0;
}

Json point_json(Vec3d point, std::string_view where) {
  const Vec3d theirs = to_habitat(point);
  return Json::array({finite(theirs.x, where), finite(theirs.y, where), finite(theirs.z, where)});
}

Json points_json(std::span<const Vec3d> points, std::string_view where) {
  Json list = Json::array();
  for (const Vec3d point : points) list.push_back(point_json(point, where));
  return list;
}

Json id_json(const FileId& id) {
  return std::visit([](const auto& value) { return Json(value); }, id);
}

void add_others(const OtherFields& others, std::span<const json::Field> known, Json& fields,
                std::string_view where) {
  for (const auto& [name, text] : others) {
    const bool is_known = std::ranges::find(known, name, &json::Field::name) != known.end();
    if (is_known || fields.contains(name)) {
      throw ArgumentError(
          fmt::format("{}: {} is no other field, or there twice", where, quote(name)));
    }
    Json value = Json::parse(text, nullptr, false);
    if (value.is_discarded()) {
      throw ArgumentError(fmt::format("{}: field {} is no JSON", where, quote(name)));
    }
    fields[name] = std::move(value);
  }
}

}  // namespace enfilade::tasks::formats
