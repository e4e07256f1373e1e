#include "enfilade/tasks/files.h"
#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <unordered_set>
#include <utility>
#include <variant>

#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks {
namespace formats {
namespace {

constexpr Radians kStartHeading(1.52);
// Texts of an instruction, in the order of the released form's lists, where the whole follows.
constexpr std::array<std::string_view, 4> kParts{"obj_name", "attribute", "relation", "region"};
constexpr std::array<std::string_view, 4> kCorners{"left_top", "right_top", "right_bottom",
                                                   "left_bottom"};
// Their places are the numbers that path ids begin with.
constexpr std::array<std::string_view, 5> kSplits{"train", "val_seen_instrs", "val_unseen_instrs",
                                                  "val_unseen_house", "test"};
constexpr std::size_t kOtherSplit = 9;
// What alternatives repeat of their entries, in memory. SOON's 40,000 paths stay far below it; a
// few kB could ask for more.
constexpr std::size_t kMostCopiedBytes = std::size_t{1} << 31U;

Direction read_direction(Element element, const Path& path, Faults& faults) {
  const Fields found(element, {"heading", "elevation"}, {}, path, faults);
  if (!found) return {};
  return {found.get("heading", read_angle), found.get("elevation", read_angle)};
}

// All boxes of an entry are in one scan; the first one's is taken where the entry names none.
void check_scan(Element element, const Path& path, Faults& faults, std::string& scan) {
  const auto name = json::id(element, path, faults);
  if (!name) return;
  if (scan.empty()) scan = *name;
  if (scan == *name) return;
  faults.error(path, "two-scans",
               fmt::format("{}, where the entry is in {}", quote(*name), quote(scan)));
}

NamedBox read_box(Element element, const Path& path, Faults& faults, std::string& scan) {
  NamedBox box;
  const Fields found(element, {"image_id", "target"}, {"scan", "obj_name"}, path, faults);
  if (!found) return box;
  if (const auto& name = found["scan"]) check_scan(*name, found.place("scan"), faults, scan);
  box.viewpoint = found.id("image_id");
  box.object = found.text("obj_name");
  const Path target = found.place("target");
  const Fields directions(*found["target"],
                          {kCorners[0], kCorners[1], kCorners[2], kCorners[3], "center"}, {},
                          target, faults);
  if (!directions) return box;
  std::ranges::transform(kCorners, box.corners.begin(), [&directions](std::string_view corner) {
    return directions.get(corner, read_direction);
  });
  box.centre = directions.get("center", read_direction);
  return box;
}

// The scan and the goal of an entry, without first alternatives.
void read_goal(const Fields& found, const Path& path, Faults& faults, PathAnnotation& entry) {
  const std::size_t errors = faults.errors();
  if (found.has("scan")) entry.scan = found.id("scan");
  NamedBoxes goal;
  const Path place = found.place("bboxes");
  if (const auto list = found.get("bboxes", json::array)) {
    for (const Element one : *list) {
      goal.boxes.push_back(read_box(one, Path(place, goal.boxes.size()), faults, entry.scan));
    }
  }
  if (entry.scan.empty() && faults.errors() == errors) {
    faults.error(path, "missing-field", "names no scan, neither as \"scan\" nor in a box");
  }
  if (goal.boxes.empty()) {
    entry.goal = HiddenGoal{};
  } else {
    entry.goal = std::move(goal);
  }
}

// An instruction as a list of texts.
void read_list(Element element, const Path& path, Faults& faults, PathAnnotation& entry) {
  const std::size_t errors = faults.errors();
  std::vector<std::string> texts = json::strings(element, path, faults);
  if (faults.errors() != errors) return;
  if (texts.size() != kParts.size() + 1) {
    faults.error(path, "bad-instruction",
                 fmt::format("list of {} texts, not of 5: name, attribute, relation, region, and "
                             "the whole",
                             texts.size()));
    return;
  }
  InstructionDetails& details = entry.details.emplace_back();
  for (std::size_t k = 0; k < kParts.size(); ++k) {
    details.fields.emplace_back(kParts[k], std::move(texts[k]));
  }
  entry.instructions.push_back(std::move(texts.back()));
}

// An instruction as an object of texts.
void read_texts(Element element, const Path& path, Faults& faults, PathAnnotation& entry) {
  const Fields found(element, {"full"}, {kParts[0], kParts[1], kParts[2], kParts[3]}, path, faults);
  if (!found) return;
  InstructionDetails& details = entry.details.emplace_back();
  for (const std::string_view part : kParts) {
    if (found.has(part)) details.fields.emplace_back(part, found.text(part));
  }
  entry.instructions.push_back(found.text("full"));
}

template <class Read>
void read_instructions(const Fields& found, Faults& faults, const Read& read,
                       PathAnnotation& entry) {
  const auto list = found.get("instructions", json::array);
  if (!list) return;
  const Path path = found.place("instructions");
  std::size_t k = 0;
  for (const Element one : *list) read(one, Path(path, k++), faults, entry);
}

void read_encodings(Element element, const Path& path, Faults& faults, PathAnnotation& entry) {
  const auto list = json::array(element, path, faults);
  if (!list) return;
  if (list->size() != entry.details.size()) {
    faults.error(
        path, "encoding-count",
        fmt::format("encodings of {} instructions, not of {}", list->size(), entry.details.size()));
    return;
  }
  std::size_t k = 0;
  for (const Element one : *list) {
    const Path place(path, k);
    if (const auto full = json::field(one, {"full"}, place, faults)) {
      entry.details[k].tokens = read_tokens(*full, Path(place, "full"), faults);
    }
    ++k;
  }
}

std::vector<std::vector<std::string>> read_alternatives(Element element, const Path& path,
                                                        Faults& faults) {
  std::vector<std::vector<std::string>> alternatives;
  const auto list = json::array(element, path, faults);
  if (!list) return alternatives;
  for (const Element one : *list) {
    alternatives.push_back(read_path(one, Path(path, alternatives.size()), faults));
  }
  if (alternatives.empty()) {
    faults.error(path, "empty-path", "no path; a list of one or more is expected");
  }
  return alternatives;
}

// About how many bytes a path of the entry takes, at most.
std::size_t bytes_of(const PathAnnotation& entry,
                     const std::vector<std::vector<std::string>>& alternatives) {
  constexpr std::size_t kTexts = 64;  // of a string with an id or a name
  std::size_t longest = 0, bytes = sizeof(PathAnnotation);
  for (const auto& alternative : alternatives) longest = std::max(longest, alternative.size());
  if (const auto* const goal = std::get_if<NamedBoxes>(&entry.goal)) {
    bytes += goal->boxes.size() * (sizeof(NamedBox) + kTexts);
  }
  for (std::size_t k = 0; k < entry.instructions.size(); ++k) {
    bytes += sizeof(InstructionDetails) + entry.instructions[k].size();
    for (const auto& [name, text] : entry.details[k].fields) bytes += kTexts + text.size();
    if (entry.details[k].entry) bytes += kTexts + entry.details[k].entry->size();
  }
  return bytes + 2 * longest * kTexts;  // with the first alternative
}

// Reads entries with alternatives, which become paths of their own.
class Released {
 public:
  explicit Released(Annotations& result) : result_(result) {
    const auto* const split = std::ranges::find(kSplits, result.split);
    split_ =
        split == kSplits.end() ? kOtherSplit : static_cast<std::size_t>(split - kSplits.begin());
  }

  void read(Element element, const Path& path, Faults& faults) {
    const std::int64_t group = entries_++;
    const Fields found(element, {"path", "instructions"}, {"bboxes", "scan", "instr_id"}, path,
                       faults);
    if (!found) return;
    PathAnnotation entry;
    entry.heading = kStartHeading;
    entry.group = group;
    read_goal(found, path, faults, entry);
    read_instructions(found, faults, read_list, entry);
    if (const auto& id = found["instr_id"]) read_id(*id, found.place("instr_id"), faults, entry);
    const auto alternatives = found.get("path", read_alternatives);
    if (faults.errors() > 0) return;
    copied_ += (alternatives.size() - 1) * bytes_of(entry, alternatives);
    if (copied_ > kMostCopiedBytes) {
      faults.error(found.place("path"), "too-large",
                   fmt::format("with these {} paths, alternatives would repeat {} bytes; {} are "
                               "allowed",
                               alternatives.size(), copied_, kMostCopiedBytes));
      return;
    }
    for (const auto& alternative : alternatives) add(entry, alternative, alternatives);
  }

 private:
  void read_id(Element element, const Path& path, Faults& faults, PathAnnotation& entry) {
    const auto id = json::id(element, path, faults);
    if (!id) return;
    once_.check(std::string(*id), static_cast<std::size_t>(*entry.group), path, faults);
    for (InstructionDetails& details : entry.details) details.entry = *id;
  }

  void add(PathAnnotation entry, const std::vector<std::string>& path,
           const std::vector<std::vector<std::string>>& alternatives) {
    entry.path_id = static_cast<std::int64_t>(result_.paths.size());
    entry.id = fmt::format("{}-{}", split_, entry.path_id);
    entry.path = path;
    const auto first = std::ranges::find(alternatives, path.front(),
                                         [](const auto& other) { return other.front(); });
    if (auto* const goal = std::get_if<NamedBoxes>(&entry.goal); goal && *first != path) {
      goal->first_alternative = *first;
    }
    result_.paths.push_back(std::move(entry));
  }

  Annotations& result_;
  std::size_t split_;
  Once once_;
  std::int64_t entries_ = 0;
  std::size_t copied_ = 0;
};

// The running number of "<split number>-<running number>".
std::optional<std::int64_t> running_number(std::string_view id) {
  const std::size_t dash = id.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const auto split = parse_number<std::uint64_t>(id.substr(0, dash));
  const auto number = parse_number<std::int64_t>(id.substr(dash + 1));
  return split && number && *number >= 0 ? number : std::nullopt;
}

PathAnnotation read_soon_line(Element element, std::size_t /*record*/, const Path& path,
                              Faults& faults) {
  PathAnnotation entry;
  const Fields found(element, {"path", "instructions", "scan", "path_id"},
                     {"bboxes", "instr_encodings"}, path, faults);
  if (!found) return entry;
  entry.heading = kStartHeading;
  entry.id = found.id("path_id");
  const auto number = running_number(entry.id);
  entry.path_id = number.value_or(0);
  if (!number && !entry.id.empty()) {
    faults.error(found.place("path_id"), "wrong-id",
                 quote(entry.id) + ", not \"<split number>-<running number>\"");
  }
  entry.path = found.get("path", read_path);
  read_goal(found, path, faults, entry);
  const std::size_t errors = faults.errors();
  read_instructions(found, faults, read_texts, entry);
  const auto& encodings = found["instr_encodings"];
  if (encodings && faults.errors() == errors) {  // else their numbers need not agree
    read_encodings(*encodings, found.place("instr_encodings"), faults, entry);
  }
  return entry;
}

ArgumentError not_soon(const PathAnnotation& entry, std::string_view why) {
  return ArgumentError(fmt::format("path {}: {}", quote(entry.id), why));
}

nlohmann::ordered_json json_of(const PathAnnotation& entry, const Direction& direction) {
  if (!std::isfinite(direction.heading.value) || !std::isfinite(direction.elevation.value)) {
    throw not_soon(entry, fmt::format("heading {} and elevation {} of a box, not finite numbers",
                                      direction.heading.value, direction.elevation.value));
  }
  return {{"heading", direction.heading.value}, {"elevation", direction.elevation.value}};
}

nlohmann::ordered_json json_of(const PathAnnotation& entry, const NamedBox& box) {
  nlohmann::ordered_json target;
  target["center"] = json_of(entry, box.centre);
  for (std::size_t k = 0; k < kCorners.size(); ++k) {
    target[std::string(kCorners[k])] = json_of(entry, box.corners[k]);
  }
  return {{"scan", entry.scan},
          {"image_id", box.viewpoint},
          {"heading", box.centre.heading.value},
          {"elevation", box.centre.elevation.value},
          {"obj_name", box.object},
          {"target", std::move(target)}};
}

void check_soon(const PathAnnotation& entry) {
  if (!running_number(entry.id)) throw not_soon(entry, "its id is no SOON path's");
  if (entry.details.size() != entry.instructions.size()) {
    throw not_soon(entry, fmt::format("{} instructions with details of {}",
                                      entry.instructions.size(), entry.details.size()));
  }
  const auto* const boxes = std::get_if<NamedBoxes>(&entry.goal);
  const bool hidden = std::holds_alternative<HiddenGoal>(entry.goal);
  if (!hidden && (boxes == nullptr || boxes->boxes.empty())) {
    throw not_soon(entry, "its goal is neither hidden nor boxes");
  }
  for (const InstructionDetails& details : entry.details) {
    auto part = kParts.begin();  // they are read back in this order
    for (const auto& [name, text] : details.fields) {
      part = std::find(part, kParts.end(), name);
      if (part++ == kParts.end()) {
        throw not_soon(entry,
                       fmt::format("field {} is unknown, or not in SOON's order", quote(name)));
      }
    }
  }
}

nlohmann::ordered_json boxes_json(const PathAnnotation& entry) {
  auto boxes = nlohmann::ordered_json::array();
  if (const auto* const goal = std::get_if<NamedBoxes>(&entry.goal)) {
    for (const NamedBox& box : goal->boxes) boxes.push_back(json_of(entry, box));
  }
  return boxes;
}

nlohmann::ordered_json line_of(const PathAnnotation& entry) {
  check_soon(entry);
  nlohmann::ordered_json line{{"path_id", entry.id}, {"scan", entry.scan}, {"path", entry.path}};
  auto instructions = nlohmann::ordered_json::array();
  auto encodings = nlohmann::ordered_json::array();
  bool encoded = false;
  for (std::size_t k = 0; k < entry.instructions.size(); ++k) {
    nlohmann::ordered_json texts;
    for (const auto& [name, text] : entry.details[k].fields) texts[name] = text;
    texts["full"] = entry.instructions[k];
    instructions.push_back(std::move(texts));
    encodings.push_back({{"full", entry.details[k].tokens}});
    encoded = encoded || !entry.details[k].tokens.empty();
  }
  line["instructions"] = std::move(instructions);
  if (encoded) line["instr_encodings"] = std::move(encodings);
  nlohmann::ordered_json boxes = boxes_json(entry);
  if (!boxes.empty()) line["bboxes"] = std::move(boxes);
  return line;
}

// An instruction as a list of five texts.
nlohmann::ordered_json texts_json(const PathAnnotation& entry, std::size_t k) {
  const auto& parts = entry.details[k].fields;
  if (parts.size() != kParts.size()) {
    throw not_soon(entry, fmt::format("{} texts beside the whole of instruction {}, not {}",
                                      parts.size(), k, kParts.size()));
  }
  auto texts = nlohmann::ordered_json::array();
  for (const auto& [name, text] : parts) texts.push_back(text);
  texts.push_back(entry.instructions[k]);
  return texts;
}

// What all alternatives of an entry share.
nlohmann::ordered_json shared_json(const PathAnnotation& entry) {
  check_soon(entry);
  auto instructions = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < entry.instructions.size(); ++k) {
    instructions.push_back(texts_json(entry, k));
  }
  nlohmann::ordered_json shared{{"scan", entry.scan}, {"instructions", std::move(instructions)}};
  nlohmann::ordered_json boxes = boxes_json(entry);
  if (!boxes.empty()) shared["bboxes"] = std::move(boxes);
  return shared;
}

// The id that all instructions of all paths of an entry have, else its number in the file.
std::string entry_id(std::span<const PathAnnotation> paths, std::size_t number) {
  std::optional<std::string> id;
  for (const PathAnnotation& path : paths) {
    for (const InstructionDetails& details : path.details) {
      if (id && details.entry != id) throw not_soon(path, "two instr_ids in one entry");
      id = details.entry;
    }
  }
  return id.value_or(fmt::to_string(number));
}

// One entry. \pre paths is not empty
std::string released_line(std::span<const PathAnnotation> paths, const std::string& id) {
  const nlohmann::ordered_json shared = shared_json(paths.front());
  auto alternatives = nlohmann::ordered_json::array();
  for (const PathAnnotation& path : paths) {
    if (path.path.empty()) throw not_soon(path, "its path has no viewpoint");
    if (&path != &paths.front() && shared_json(path) != shared) {
      throw not_soon(path, fmt::format("of the group of {}, but differs from it in more than the "
                                       "path",
                                       quote(paths.front().id)));
    }
    alternatives.push_back(path.path);
  }
  nlohmann::ordered_json entry{{"path", std::move(alternatives)}};
  entry.update(shared);
  entry["instr_id"] = id;
  return dump(entry, "path " + quote(paths.front().id));
}

}  // namespace

Annotations parse_soon(std::string_view json, const std::string& file, std::string split) {
  Annotations result{std::move(split), file, {}, Task::kSoon};
  Faults faults(file);
  Released released(result);
  for_each_record(json, faults,
                  [&](Element element, const Path& path) { released.read(element, path, faults); });
  faults.throw_if_errors();
  return result;
}

Annotations parse_soon_lines(std::string_view lines, const std::string& file, std::string split) {
  return read_records(lines, file, std::move(split), Task::kSoon, "path_id", read_soon_line);
}

std::string to_soon_lines(const Annotations& annotations) {
  std::string lines;
  for (const PathAnnotation& entry : annotations.paths) {
    lines += dump(line_of(entry), "path " + quote(entry.id)) + '\n';
  }
  return lines;
}

}  // namespace formats

std::string to_released_soon(const Annotations& annotations) {
  const std::span<const PathAnnotation> paths(annotations.paths);
  std::unordered_set<std::string> ids;
  std::string text = "[";
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < paths.size(); ++number) {
    std::size_t end = begin + 1;
    while (end < paths.size() && paths[begin].group && paths[end].group == paths[begin].group) {
      ++end;
    }
    const auto entry = paths.subspan(begin, end - begin);
    const std::string id = formats::entry_id(entry, number);
    if (!ids.insert(id).second) {
      throw formats::not_soon(entry.front(),
                              fmt::format("its entry has the instr_id {} of another", quote(id)));
    }
    text += (number == 0 ? "\n" : ",\n") + formats::released_line(entry, id);
    begin = end;
  }
  return text + "\n]\n";
}

}  // namespace enfilade::tasks
