#include "enfilade/tasks/formats/records.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::tasks::formats {
namespace {

TimedWord read_word(Element element, const Path& path, Faults& faults) {
  const Fields found(element, {"word"}, {"start_time", "end_time"}, path, faults);
  if (!found) return {};
  return {found.text("word"), found.get("start_time", json::number),
          found.get("end_time", json::number)};
}

}  // namespace

Fields::Fields(Element element, Names required, Names optional, const Path& path, Faults& faults)
    : path_(path), faults_(faults) {
  for (const std::string_view name : required) wanted_.at(count_++) = {name};
  for (const std::string_view name : optional) wanted_.at(count_++) = {name, false};
  find(element);
}

Fields::Fields(Element element, std::span<const json::Field> wanted, const Path& path,
               Faults& faults)
    : path_(path), faults_(faults) {
  for (const json::Field& field : wanted) wanted_.at(count_++) = field;
  find(element);
}

void Fields::find(Element element) {
  good_ = json::fields(element, std::span(wanted_).first(count_), std::span(found_).first(count_),
                       path_, faults_);
}

const std::optional<Element>& Fields::operator[](std::string_view name) const {
  std::size_t k = 0;
  while (k < count_ && wanted_[k].name != name) ++k;
  EN_CHECK(k < count_);
  return found_[k];
}

std::string Fields::text(std::string_view name) const { return get(name, read_text); }

std::string Fields::id(std::string_view name, std::size_t most) const {
  return get(name, [most](Element element, const Path& path, Faults& faults) {
    return std::string(json::id(element, path, faults, most).value_or(""));
  });
}

std::string read_text(Element element, const Path& path, Faults& faults) {
  return std::string(json::string(element, path, faults).value_or(""));
}

std::optional<std::int64_t> read_number(Element element, const Path& path, Faults& faults) {
  const auto number = json::integer(element, path, faults);
  if (!number || *number >= 0) return number;
  faults.error(path, "negative-id", fmt::format("{} is no id; 0 and more are", *number));
  return std::nullopt;
}

std::vector<std::string> read_path(Element element, const Path& path, Faults& faults) {
  const std::size_t errors = faults.errors();
  std::vector<std::string> viewpoints = json::ids(element, path, faults);
  if (viewpoints.empty() && faults.errors() == errors) {
    faults.error(path, "empty-path", "no viewpoint; the start at least is expected");
  }
  return viewpoints;
}

Radians read_angle(Element element, const Path& path, Faults& faults) {
  return Radians(json::angle(element, path, faults).value_or(0));
}

std::vector<std::int32_t> read_tokens(Element element, const Path& path, Faults& faults) {
  std::vector<std::int32_t> tokens;
  const auto list = json::array(element, path, faults);
  if (!list) return tokens;
  tokens.reserve(list->size());
  std::size_t k = 0;
  for (const Element one : *list) {
    const Path place(path, k++);
    const auto token = json::integer(one, place, faults);
    if (!token) continue;
    if (*token < 0 || *token > std::numeric_limits<std::int32_t>::max()) {
      faults.error(place, "bad-token",
                   fmt::format("{} is no token id; 0 to 2147483647 are", *token));
      continue;
    }
    tokens.push_back(static_cast<std::int32_t>(*token));
  }
  return tokens;
}

void refuse_large(std::size_t bytes, const Path& path, Faults& faults, std::size_t most) {
  faults.error(path, "too-large", fmt::format("{} bytes; {} are allowed", bytes, most));
}

std::vector<TimedWord> read_timed_words(Element element, const Path& path, Faults& faults) {
  std::vector<TimedWord> words;
  const auto list = json::array(element, path, faults);
  if (!list) return words;
  words.reserve(list->size());
  for (const Element one : *list) words.push_back(read_word(one, Path(path, words.size()), faults));
  return words;
}

nlohmann::ordered_json timed_words_json(std::span<const TimedWord> words, std::string_view where) {
  auto list = nlohmann::ordered_json::array();
  const auto add = [&](nlohmann::ordered_json& one, const char* field,
                       const std::optional<double>& time) {
    if (!time) return;
    if (!std::isfinite(*time)) {
      throw ArgumentError(fmt::format("{}: {} {}, not a finite number", where, field, *time));
    }
    one[field] = *time;
  };
  for (const TimedWord& word : words) {
    nlohmann::ordered_json one;
    add(one, "start_time", word.start);
    one["word"] = word.word;
    add(one, "end_time", word.end);
    list.push_back(std::move(one));
  }
  return list;
}

void Once::check(const std::string& id, std::size_t record, const Path& path, Faults& faults) {
  const auto [first, fresh] = places_.emplace(id, record);
  if (fresh) return;
  faults.error(path, "repeated-id",
               fmt::format("{} stands at $[{}] already", quote(id), first->second));
}

namespace {

void read_path_id(Element element, std::size_t record, const Path& path, Faults& faults,
                  PathAnnotation& entry) {
  if (!element.is_string()) {
    entry.path_id = read_number(element, path, faults).value_or(0);
    return;
  }
  entry.id = json::id(element, path, faults).value_or("");
  entry.path_id = static_cast<std::int64_t>(record);
}

std::string line_of(const PathAnnotation& entry, const FieldsOf& fields_of) {
  return dump(fields_of(entry), fmt::format("path {}", entry.path_id));
}

}  // namespace

PathAnnotation read_r2r_entry(Element element, std::size_t record, const Path& path,
                              Faults& faults) {
  PathAnnotation entry;
  const Fields found(element, {"path_id", "scan", "heading", "path", "instructions"}, {"distance"},
                     path, faults);
  if (!found) return entry;
  read_path_id(*found["path_id"], record, found.place("path_id"), faults, entry);
  entry.scan = found.id("scan");
  entry.heading = found.get("heading", read_angle);
  entry.path = found.get("path", read_path);
  entry.instructions = found.get("instructions", json::strings);
  entry.distance = found.get("distance", json::number);
  if (entry.distance && *entry.distance < 0) {
    faults.error(found.place("distance"), "bad-distance",
                 fmt::format("{} is no length in metres", *entry.distance));
  }
  return entry;
}

void PathIds::check(const PathAnnotation& entry, std::size_t record, const Path& path,
                    Faults& faults) {
  const bool number = entry.id.empty();
  const std::size_t first = number ? numbers_.emplace(entry.path_id, record).first->second
                                   : texts_.emplace(entry.id, record).first->second;
  if (first == record) return;
  faults.error(Path(path, "path_id"), "repeated-path-id",
               fmt::format("{} stands at $[{}] already",
                           number ? fmt::to_string(entry.path_id) : quote(entry.id), first));
}

PathAnnotation read_entry(Element element, std::size_t record, const ReadMore& read_more,
                          PathIds& ids, const Path& path, Faults& faults) {
  const std::size_t errors = faults.errors();
  PathAnnotation entry = read_r2r_entry(element, record, path, faults);
  const bool complete = faults.errors() == errors;
  if (element.is_object()) read_more(element, complete, entry, path, faults);
  if (complete) ids.check(entry, record, path, faults);
  return entry;
}

void read_encodings(Element element, bool complete, PathAnnotation& entry, const Path& path,
                    Faults& faults) {
  const auto lists = json::array(element, path, faults);
  if (!lists) return;
  const std::size_t instructions = entry.instructions.size();
  if (complete && lists->size() != instructions) {
    faults.error(path, "wrong-count",
                 fmt::format("{} lists of tokens; {} are expected, one for each instruction",
                             lists->size(), instructions));
    return;  // before memory is taken for them: a file can have many more than it has words
  }
  std::size_t k = 0;
  if (complete) entry.details.resize(instructions);
  for (const Element list : *lists) {
    if (faults.full()) return;
    std::vector<std::int32_t> tokens = read_tokens(list, Path(path, k), faults);
    if (complete) entry.details[k].tokens = std::move(tokens);
    ++k;
  }
}

Annotations read_records(std::string_view text, const std::string& file, std::string split,
                         Task task, const ReadRecord& read_record) {
  Annotations result{std::move(split), file, {}, task};
  Faults faults(file);
  for_each_record(text, faults, [&](Element element, const Path& path) {
    result.paths.push_back(read_record(element, result.paths.size(), path, faults));
  });
  faults.throw_if_errors();
  return result;
}

Annotations read_records(std::string_view text, const std::string& file, std::string split,
                         Task task, std::string_view id_field, const ReadRecord& read_record) {
  Once once;
  return read_records(text, file, std::move(split), task,
                      [&](Element element, std::size_t record, const Path& path, Faults& faults) {
                        const std::size_t errors = faults.errors();
                        PathAnnotation entry = read_record(element, record, path, faults);
                        // Else it may have no id.
                        if (faults.errors() == errors) {
                          once.check(entry.id, record, Path(path, id_field), faults);
                        }
                        return entry;
                      });
}

double finite(double number, std::string_view where) {
  if (std::isfinite(number)) return number;
  throw ArgumentError(fmt::format("{}: {}, not a finite number", where, number));
}

std::string dump(const nlohmann::ordered_json& value, std::string_view where) {
  try {
    return value.dump();
  } catch (const nlohmann::json::type_error&) {
    throw ArgumentError(fmt::format("{}: holds text that is not UTF-8", where));
  }
}

nlohmann::ordered_json r2r_fields(const PathAnnotation& entry) {
  if (!std::isfinite(entry.heading.value) || !std::isfinite(entry.distance.value_or(0))) {
    throw ArgumentError(fmt::format("path {}: heading {} and distance {}, not finite numbers",
                                    entry.path_id, entry.heading.value,
                                    entry.distance.value_or(0)));
  }
  nlohmann::ordered_json fields;
  if (entry.id.empty()) {
    fields["path_id"] = entry.path_id;
  } else {
    fields["path_id"] = entry.id;
  }
  fields.update({{"scan", entry.scan}, {"heading", entry.heading.value}, {"path", entry.path}});
  if (entry.distance) fields["distance"] = *entry.distance;
  fields["instructions"] = entry.instructions;
  return fields;
}

void add_encodings(const PathAnnotation& entry, nlohmann::ordered_json& fields) {
  auto& lists = fields["instr_encodings"] = nlohmann::ordered_json::array();
  for (const InstructionDetails& details : entry.details) lists.push_back(details.tokens);
}

std::string list_of_entries(const Annotations& annotations, const FieldsOf& fields_of) {
  std::string text = "[";
  for (const PathAnnotation& entry : annotations.paths) {
    text += text.size() == 1 ? "\n" : ",\n";
    text += line_of(entry, fields_of);
  }
  return text + "\n]\n";
}

std::string lines_of_entries(const Annotations& annotations, const FieldsOf& fields_of) {
  std::string text;
  for (const PathAnnotation& entry : annotations.paths) text += line_of(entry, fields_of) + '\n';
  return text;
}

}  // namespace enfilade::tasks::formats
