#include "enfilade/tasks/formats/soon.h"

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

namespace enfilade::tasks::formats {
namespace {

using json::Element;
using json::Faults;
using json::Path;

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

enum Wanted : std::size_t { kPath, kInstructions, kBoxes, kScan, kSharedFields };
enum OfEntry : std::size_t { kEntryId = kSharedFields, kReleasedFields };
constexpr std::array<json::Field, kReleasedFields> kReleased{
    {{"path"}, {"instructions"}, {"bboxes", false}, {"scan", false}, {"instr_id", false}}};

enum OfLine : std::size_t { kPathId = kSharedFields, kEncodings, kLineFields };
constexpr std::array<json::Field, kLineFields> kOfLine{{{"path"},
                                                        {"instructions"},
                                                        {"bboxes", false},
                                                        {"scan"},
                                                        {"path_id"},
                                                        {"instr_encodings", false}}};

enum OfBox : std::size_t { kBoxScan, kBoxPlace, kBoxObject, kBoxTarget, kBoxFields };
constexpr std::array<json::Field, kBoxFields> kOfBox{
    {{"scan", false}, {"image_id"}, {"obj_name", false}, {"target"}}};
constexpr std::array<json::Field, 5> kOfTarget{
    {{kCorners[0]}, {kCorners[1]}, {kCorners[2]}, {kCorners[3]}, {"center"}}};
constexpr std::array<json::Field, 2> kOfDirection{{{"heading"}, {"elevation"}}};
constexpr std::array<json::Field, 5> kOfTexts{
    {{kParts[0], false}, {kParts[1], false}, {kParts[2], false}, {kParts[3], false}, {"full"}}};

std::string read_text(Element element, const Path& path, Faults& faults) {
  return std::string(json::string(element, path, faults).value_or(""));
}

Direction read_direction(Element element, const Path& path, Faults& faults) {
  std::array<std::optional<Element>, kOfDirection.size()> found;
  if (!json::fields(element, kOfDirection, found, path, faults)) return {};
  return {read_angle(*found[0], Path(path, "heading"), faults),
          read_angle(*found[1], Path(path, "elevation"), faults)};
}

// All boxes of an entry are in one scan; the first one's is taken where the entry names none.
void check_scan(Element element, const Path& path, Faults& faults, std::string& scan) {
  const auto name = json::string(element, path, faults);
  if (!name) return;
  if (scan.empty()) scan = *name;
  if (scan == *name) return;
  faults.error(path, "two-scans", fmt::format("{:?}, where the entry is in {:?}", *name, scan));
}

NamedBox read_box(Element element, const Path& path, Faults& faults, std::string& scan) {
  NamedBox box;
  std::array<std::optional<Element>, kBoxFields> found;
  if (!json::fields(element, kOfBox, found, path, faults)) return box;
  if (found[kBoxScan]) check_scan(*found[kBoxScan], Path(path, "scan"), faults, scan);
  box.viewpoint = read_text(*found[kBoxPlace], Path(path, "image_id"), faults);
  if (found[kBoxObject]) {
    box.object = read_text(*found[kBoxObject], Path(path, "obj_name"), faults);
  }
  const Path target(path, "target");
  std::array<std::optional<Element>, kOfTarget.size()> directions;
  if (!json::fields(*found[kBoxTarget], kOfTarget, directions, target, faults)) return box;
  for (std::size_t k = 0; k < kCorners.size(); ++k) {
    box.corners[k] = read_direction(*directions[k], Path(target, kCorners[k]), faults);
  }
  box.centre = read_direction(*directions[kCorners.size()], Path(target, "center"), faults);
  return box;
}

// The scan and the goal of an entry, without first alternatives.
void read_goal(const std::optional<Element>& scan, const std::optional<Element>& boxes,
               const Path& path, Faults& faults, PathAnnotation& entry) {
  const std::size_t errors = faults.errors();
  if (scan) entry.scan = read_text(*scan, Path(path, "scan"), faults);
  NamedBoxes goal;
  const Path place(path, "bboxes");
  if (const auto list = boxes ? json::array(*boxes, place, faults) : std::nullopt) {
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
void read_object(Element element, const Path& path, Faults& faults, PathAnnotation& entry) {
  std::array<std::optional<Element>, kOfTexts.size()> found;
  if (!json::fields(element, kOfTexts, found, path, faults)) return;
  InstructionDetails& details = entry.details.emplace_back();
  for (std::size_t k = 0; k < kParts.size(); ++k) {
    if (!found[k]) continue;
    details.fields.emplace_back(kParts[k], read_text(*found[k], Path(path, kParts[k]), faults));
  }
  entry.instructions.push_back(read_text(*found.back(), Path(path, "full"), faults));
}

template <class Read>
void read_instructions(Element element, const Path& path, Faults& faults, const Read& read,
                       PathAnnotation& entry) {
  const auto list = json::array(element, path, faults);
  if (!list) return;
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
    std::array<std::optional<Element>, kReleasedFields> found;
    if (!json::fields(element, kReleased, found, path, faults)) return;
    PathAnnotation entry;
    entry.heading = kStartHeading;
    entry.group = group;
    read_goal(found[kScan], found[kBoxes], path, faults, entry);
    read_instructions(*found[kInstructions], Path(path, "instructions"), faults, read_list, entry);
    if (found[kEntryId]) read_id(*found[kEntryId], Path(path, "instr_id"), faults, entry);
    const auto alternatives = read_alternatives(*found[kPath], Path(path, "path"), faults);
    if (faults.errors() > 0) return;
    copied_ += (alternatives.size() - 1) * bytes_of(entry, alternatives);
    if (copied_ > kMostCopiedBytes) {
      faults.error(Path(path, "path"), "too-large",
                   fmt::format("with these {} paths, alternatives would repeat {} bytes; {} are "
                               "allowed",
                               alternatives.size(), copied_, kMostCopiedBytes));
      return;
    }
    for (const auto& alternative : alternatives) add(entry, alternative, alternatives);
  }

 private:
  void read_id(Element element, const Path& path, Faults& faults, PathAnnotation& entry) {
    const std::size_t errors = faults.errors();
    const std::string id = read_text(element, path, faults);
    if (faults.errors() != errors) return;
    once_.check(id, static_cast<std::size_t>(*entry.group), path, faults);
    for (InstructionDetails& details : entry.details) details.entry = id;
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
  Once once_{"repeated-id"};
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

PathAnnotation read_line(Element element, const Path& path, Faults& faults) {
  PathAnnotation entry;
  std::array<std::optional<Element>, kLineFields> found;
  if (!json::fields(element, kOfLine, found, path, faults)) return entry;
  entry.heading = kStartHeading;
  const Path place(path, "path_id");
  if (const auto id = json::string(*found[kPathId], place, faults)) {
    entry.id = *id;
    const auto number = running_number(*id);
    entry.path_id = number.value_or(0);
    if (!number) {
      faults.error(place, "wrong-id",
                   fmt::format("{:?}, not \"<split number>-<running number>\"", *id));
    }
  }
  entry.path = read_path(*found[kPath], Path(path, "path"), faults);
  read_goal(found[kScan], found[kBoxes], path, faults, entry);
  const std::size_t errors = faults.errors();
  read_instructions(*found[kInstructions], Path(path, "instructions"), faults, read_object, entry);
  if (found[kEncodings] && faults.errors() == errors) {  // else their numbers need not agree
    read_encodings(*found[kEncodings], Path(path, "instr_encodings"), faults, entry);
  }
  return entry;
}

ArgumentError not_soon(const PathAnnotation& entry, std::string_view why) {
  return ArgumentError(fmt::format("path {:?}: {}", entry.id, why));
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

void check_form(const PathAnnotation& entry) {
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
        throw not_soon(entry, fmt::format("field {:?} is unknown, or not in SOON's order", name));
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

std::string line_of(const PathAnnotation& entry) {
  check_form(entry);
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
  try {
    return line.dump();
  } catch (const nlohmann::json::type_error&) {
    throw not_soon(entry, "holds text that is not UTF-8");
  }
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
  check_form(entry);
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
      throw not_soon(path, fmt::format("of the group of {:?}, but differs from it in more than the "
                                       "path",
                                       paths.front().id));
    }
    alternatives.push_back(path.path);
  }
  nlohmann::ordered_json entry{{"path", std::move(alternatives)}};
  entry.update(shared);
  entry["instr_id"] = id;
  try {
    return entry.dump();
  } catch (const nlohmann::json::type_error&) {
    throw not_soon(paths.front(), "holds text that is not UTF-8");
  }
}

}  // namespace

std::string to_soon(const Annotations& annotations) {
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
    const std::string id = entry_id(entry, number);
    if (!ids.insert(id).second) {
      throw not_soon(entry.front(), fmt::format("its entry has the instr_id {:?} of another", id));
    }
    text += (number == 0 ? "\n" : ",\n") + released_line(entry, id);
    begin = end;
  }
  return text + "\n]\n";
}

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
  Annotations result{std::move(split), file, {}, Task::kSoon};
  Faults faults(file);
  Once once("repeated-id");
  for_each_record(lines, faults, [&](Element element, const Path& path) {
    const std::size_t errors = faults.errors();
    const std::size_t record = result.paths.size();
    const PathAnnotation& entry = result.paths.emplace_back(read_line(element, path, faults));
    if (faults.errors() != errors) return;  // it may have no id
    once.check(entry.id, record, Path(path, "path_id"), faults);
  });
  faults.throw_if_errors();
  return result;
}

std::string to_soon_lines(const Annotations& annotations) {
  std::string lines;
  for (const PathAnnotation& entry : annotations.paths) {
    lines += line_of(entry);
    lines += '\n';
  }
  return lines;
}

}  // namespace enfilade::tasks::formats
