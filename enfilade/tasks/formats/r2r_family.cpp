#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/python_literal.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks {
namespace formats {
namespace {

// \param path  of the record
void read_midstop(const Fields& found, Task task, PathAnnotation& entry, const Path& path,
                  Faults& faults) {
  const bool turns = found.has("midstop");
  if (task != Task::kR2rBack) {
    if (!turns) return;
    faults.error(found.place("midstop"), "unexpected-field",
                 "a turning point, as R2R-Back has them; this file is read as another task's");
  } else if (turns) {
    entry.goal = NamedTurningPoint{found.id("midstop")};
  } else if (entry.path.size() > 1) {
    faults.error(path, "missing-field",
                 "has no field \"midstop\", which paths of R2R-Back have, except a start alone");
  } else {
    entry.goal = HiddenGoal{};
  }
}

// "4332_0": "4332"; of "00000-kfPV7w3FaU5_12_0", from other buildings, all before the last line.
std::optional<std::string_view> path_of(std::string_view id) {
  const std::size_t line = id.rfind('_');
  if (line == id.npos || line == 0) return std::nullopt;
  if (!parse_number<std::uint64_t>(id.substr(line + 1))) return std::nullopt;
  return id.substr(0, line);
}

// HAMT's form for pretraining: an instruction, with its path.
class LineReader {
 public:
  PathAnnotation read(Element element, std::size_t record, Task task, const Path& path,
                      Faults& faults) {
    PathAnnotation entry;
    const Fields found(element, {"instr_id", "scan", "path", "instr_encoding"},
                       {"heading", "midstop", "instruction"}, path, faults);
    if (!found) return entry;
    InstructionDetails& details = entry.details.emplace_back();
    entry.instructions.push_back(found.text("instruction"));
    read_id(*found["instr_id"], record, entry, found.place("instr_id"), faults);
    entry.scan = found.id("scan");
    entry.path = found.get("path", read_path);
    entry.heading = found.get("heading", read_angle);
    details.tokens = found.get("instr_encoding", read_tokens);
    read_midstop(found, task, entry, path, faults);
    return entry;
  }

 private:
  void read_id(Element element, std::size_t record, PathAnnotation& entry, const Path& path,
               Faults& faults) {
    const auto id = json::id(element, path, faults, kLongestInstructionId);
    if (!id) return;
    const auto name = path_of(*id);
    if (!name) {
      faults.error(
          path, "bad-instruction-id",
          fmt::format("{}, not <path_id>_<k>, such as \"4332_0\"", json::describe(element)));
      return;
    }
    if (const auto number = parse_number<std::int64_t>(*name)) {
      entry.path_id = *number;
    } else {
      entry.id = *name;
      // Instructions of one path are one group, so that they need one number.
      entry.path_id = texts_.emplace(entry.id, static_cast<std::int64_t>(record)).first->second;
    }
    entry.group = entry.path_id;
    entry.details[0].id = *id;
    ids_.check(entry.details[0].id, record, path, faults);
  }

  Once ids_;
  std::unordered_map<std::string, std::int64_t> texts_;  // path ids that are no numbers
};

bool has_instruction_id(Element element) {
  return element.is_object() && !element["instr_id"].error();
}

// Whether the form for pretraining says all of it.
bool is_line(const PathAnnotation& entry) {
  if (entry.instructions.size() != 1 || entry.distance || entry.details.size() != 1) return false;
  const InstructionDetails& details = entry.details[0];
  const auto name = path_of(details.id);
  return details.parts.empty() && name &&
         (entry.id.empty() ? parse_number<std::int64_t>(*name) == entry.path_id
                           : *name == entry.id);
}

bool has_parts(const PathAnnotation& entry) {
  return std::ranges::any_of(entry.details, [](const auto& one) { return !one.parts.empty(); });
}

bool has_tokens(const PathAnnotation& entry) {
  return std::ranges::any_of(entry.details, [](const auto& one) { return !one.tokens.empty(); });
}

void add_midstop(const PathAnnotation& entry, nlohmann::ordered_json& fields) {
  if (const auto* turn = std::get_if<NamedTurningPoint>(&entry.goal)) {
    fields["midstop"] = turn->viewpoint;
  }
}

nlohmann::ordered_json line_fields(const PathAnnotation& entry) {
  nlohmann::ordered_json fields{{"instr_id", entry.details[0].id}};
  fields.update(r2r_fields(entry));
  for (const char* absent : {"path_id", "instructions", "distance"}) fields.erase(absent);
  if (!entry.instructions[0].empty()) fields["instruction"] = entry.instructions[0];
  fields["instr_encoding"] = entry.details[0].tokens;
  add_midstop(entry, fields);
  return fields;
}

nlohmann::ordered_json family_fields(const PathAnnotation& entry) {
  nlohmann::ordered_json fields = r2r_fields(entry);
  if (!entry.details.empty()) add_encodings(entry, fields);
  add_midstop(entry, fields);
  return fields;
}

// `new_instructions`, and `chunk_view` unless places are hidden.
void add_parts(const PathAnnotation& entry, nlohmann::ordered_json& fields) {
  WordLists lists;
  auto chunks = nlohmann::ordered_json::array();
  std::size_t parts = 0, placed = 0, written = 0;
  for (const InstructionDetails& details : entry.details) {
    auto& pieces = lists.emplace_back();
    auto& places = chunks.emplace_back(nlohmann::ordered_json::array());
    for (const SubInstruction& part : details.parts) {
      pieces.push_back(part.words);
      ++parts;
      if (!part.places) continue;
      ++placed;
      places.push_back({part.places->first + 1, part.places->second + 1});
    }
    if (!pieces.empty()) written = lists.size();
  }
  if (placed != 0 && placed != parts) {
    throw ArgumentError(
        fmt::format("path {}: {} of {} parts of instructions have places; all or none is allowed",
                    entry.path_id, placed, parts));
  }
  lists.resize(written);  // instructions after the last one with parts have no list
  fields["new_instructions"] = write_word_lists(lists);
  if (placed == 0) return;
  chunks.get_ref<nlohmann::ordered_json::array_t&>().resize(written);
  fields["chunk_view"] = std::move(chunks);
}

nlohmann::ordered_json fine_fields(const PathAnnotation& entry) {
  nlohmann::ordered_json fields = r2r_fields(entry);
  if (has_tokens(entry)) add_encodings(entry, fields);
  add_midstop(entry, fields);
  add_parts(entry, fields);
  return fields;
}

}  // namespace

Annotations parse_r2r_family(std::string_view text, const std::string& file, std::string split,
                             Task task) {
  PathIds ids;
  LineReader lines;
  std::optional<bool> by_instruction;  // as the first record says
  const auto read_more = [&](Element element, bool complete, PathAnnotation& entry,
                             const Path& path, Faults& faults) {
    const Fields found(element, {}, {"instr_encodings", "midstop"}, path, faults);
    if (!found) return;
    if (const auto& encodings = found["instr_encodings"]) {
      read_encodings(*encodings, complete, entry, found.place("instr_encodings"), faults);
    }
    read_midstop(found, task, entry, path, faults);
  };
  return read_records(text, file, std::move(split), task,
                      [&](Element element, std::size_t record, const Path& path, Faults& faults) {
                        if (!by_instruction) by_instruction = has_instruction_id(element);
                        return *by_instruction
                                   ? lines.read(element, record, task, path, faults)
                                   : read_entry(element, record, read_more, ids, path, faults);
                      });
}

std::string to_r2r_family(const Annotations& annotations) {
  const auto& paths = annotations.paths;
  if (!paths.empty() && std::ranges::all_of(paths, is_line)) {
    return lines_of_entries(annotations, line_fields);
  }
  const bool fine = std::ranges::any_of(paths, has_parts);
  return list_of_entries(annotations, fine ? fine_fields : family_fields);
}

}  // namespace formats

Annotations load_annotations(const std::filesystem::path& file, std::string split) {
  return parse_annotations(read_text_file(file), file.string(), std::move(split));
}

Annotations parse_annotations(std::string_view json, const std::string& file, std::string split) {
  const json::Document document = json::Document::parse(json, file);
  Annotations result{std::move(split), file, {}};
  json::Faults faults(file);
  const json::Path root;
  if (const auto entries = json::array(document.root(), root, faults)) {
    formats::PathIds ids;  // which name results
    for (const json::Element element : *entries) {
      const std::size_t i = result.paths.size();
      const json::Path path(root, i);
      const std::size_t errors = faults.errors();
      result.paths.push_back(formats::read_r2r_entry(element, i, path, faults));
      if (faults.errors() == errors) ids.check(result.paths.back(), i, path, faults);
    }
  }
  faults.throw_if_errors();
  return result;
}

std::string to_json(const Annotations& annotations) {
  return formats::list_of_entries(annotations, formats::r2r_fields);
}

}  // namespace enfilade::tasks
