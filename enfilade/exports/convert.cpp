#include "enfilade/exports/convert.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "enfilade/core/detail/json_entries.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/files.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;
using tasks::Task;

std::string_view skip_blanks(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  return text;
}

/// Whether a text is one object whose first value is an object, or that is empty: boxes by
/// viewpoint. Records of other files begin with an id, a name or a list.
bool looks_like_boxes(std::string_view text) {
  text = skip_blanks(text);
  if (!text.starts_with('{')) return false;
  text = skip_blanks(text.substr(1));
  if (text.starts_with('}')) return true;
  if (!text.starts_with('"')) return false;
  text = skip_blanks(text.substr(std::min(text.find('"', 1), text.size() - 1) + 1));
  return text.starts_with(':') && skip_blanks(text.substr(1)).starts_with('{');
}

/// Names of the first record's fields. \throws InvalidInput if there is none
std::set<std::string, std::less<>> first_fields(std::string_view text, const std::string& file) {
  constexpr std::size_t kMostRecordBytes = std::size_t{1} << 26U;
  json::Records records(text, file, kMostRecordBytes);
  std::set<std::string, std::less<>> names;
  if (records.next() && records.element() && records.element()->is_object()) {
    const simdjson::dom::object fields = records.element()->get_object().value_unsafe();
    for (const auto& field : fields) names.emplace(field.key);
  }
  if (names.empty()) {
    refuse(
        file, "$", "unknown-kind",
        "neither a list nor lines of records; annotations, results, boxes or features are wanted");
  }
  return names;
}

bool is_feature_file(const fs::path& file) {
  constexpr std::array<std::string_view, 4> kSuffixes{".safetensors", ".tsv", ".h5", ".hdf5"};
  return std::ranges::find(kSuffixes, file.extension().string()) != kSuffixes.end();
}

// --- results ---

/// Gives a field another name, in its place.
void rename_field(OrderedJson& entry, std::string_view from, const char* to) {
  OrderedJson renamed = OrderedJson::object();
  for (auto& [name, value] : entry.items()) renamed[name == from ? to : name] = std::move(value);
  entry = std::move(renamed);
}

/// One entry at a time, with its faults.
class KeyChanger {
 public:
  KeyChanger(std::string file, ResultKeys keys, Task task)
      : file_(std::move(file)), official_(keys == ResultKeys::kOfficial), task_(task) {}

  void change(OrderedJson& entry, std::size_t index) {
    where_ = fmt::format("$[{}]", index);
    if (!entry.is_object()) return fault("", "wrong-type", "not an object");
    if (task_ == Task::kReverie) {
      change_name(entry, official_ ? "pred_objid" : "predObjId",
                  official_ ? "predObjId" : "pred_objid");
    }
    if (task_ == Task::kCvdn && official_) to_number(entry);
    if (task_ == Task::kCvdn && !official_) to_text(entry);
  }

  void finish() {
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
  }

 private:
  void fault(const std::string& field, const char* code, std::string message) {
    if (faults_.size() == kMostFaultsKept) return;
    faults_.push_back({Severity::kError, file_, where_ + field, code, std::move(message)});
  }

  /// False if there is nothing to change.
  bool change_name(OrderedJson& entry, const char* from, const char* to) {
    if (!entry.contains(from)) return false;
    if (entry.contains(to)) {
      fault("", "two-names", fmt::format("both {} and {}", from, to));
      return false;
    }
    rename_field(entry, from, to);
    return true;
  }

  void to_number(OrderedJson& entry) {
    if (!change_name(entry, "instr_id", "inst_idx")) return;
    OrderedJson& id = entry["inst_idx"];
    std::int64_t number = 0;
    const std::string text = id.is_string() ? id.get<std::string>() : std::string();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) {
      return fault(".instr_id", "bad-number",
                   fmt::format("{}, not a text that is a whole number", id.dump().substr(0, 80)));
    }
    id = number;
  }

  void to_text(OrderedJson& entry) {
    if (!change_name(entry, "inst_idx", "instr_id")) return;
    OrderedJson& id = entry["instr_id"];
    if (!id.is_number_integer()) {
      return fault(".inst_idx", "wrong-type",
                   fmt::format("{}, not a whole number", id.dump().substr(0, 80)));
    }
    id = id.dump();
  }

  std::string file_, where_;
  bool official_;
  Task task_;
  std::vector<Diagnostic> faults_;
};

/// Refuses what a reader of results would, and this library would not.
class StrictReading {
 public:
  explicit StrictReading(std::string file) : file_(std::move(file)) {}

  bool operator()(int depth, OrderedJson::parse_event_t event, const OrderedJson& parsed) {
    // Results have six levels. Writing goes down as deep as the text does, and so must not be asked
    // to go through a hostile one.
    constexpr int kDeepest = 64;
    if (depth > kDeepest) {
      refuse(file_, "$", "too-deep", "more than 64 levels of lists and objects");
    }
    if (event == OrderedJson::parse_event_t::object_start) open_.emplace_back();
    if (event == OrderedJson::parse_event_t::object_end) open_.pop_back();
    if (event == OrderedJson::parse_event_t::key) {
      const auto name = parsed.get<std::string>();
      if (!open_.back().insert(name).second) {
        refuse(file_, "$", "repeated-field",
               fmt::format("{:?}: given twice in one object", name.substr(0, 80)));
      }
    }
    return true;
  }

 private:
  std::string file_;
  std::vector<std::set<std::string>> open_;  ///< names in the objects that have begun
};

OrderedJson parse_list(std::string_view text, const std::string& file) {
  OrderedJson list;
  try {
    StrictReading strict(file);
    list = OrderedJson::parse(text, std::ref(strict));
  } catch (const OrderedJson::parse_error& error) {
    refuse(file, "$", "not-json", error.what());
  }
  if (!list.is_array()) refuse(file, "$", "wrong-type", "not a list");
  return list;
}

std::string list_text(const OrderedJson& list) {
  std::string text = "[";
  for (std::size_t i = 0; i < list.size(); ++i) text += (i > 0 ? ",\n" : "\n") + list[i].dump();
  return text + "\n]\n";
}

std::string lines_text(const OrderedJson& list) {
  std::string text;
  for (const OrderedJson& entry : list) text += entry.dump() + "\n";
  return text;
}

}  // namespace

std::string_view to_string(FileKind kind) {
  constexpr std::array<std::string_view, 5> kNames{"annotations", "followers", "results", "boxes",
                                                   "features"};
  return kNames.at(static_cast<std::size_t>(kind));
}

FileKind find_kind(const fs::path& file) {
  std::error_code unreadable;  // reading it says why
  if (fs::is_directory(file, unreadable)) return FileKind::kBoxes;
  if (is_feature_file(file)) return FileKind::kFeatures;
  const std::string text = read_text_file(file);
  if (looks_like_boxes(text)) return FileKind::kBoxes;
  const auto names = first_fields(text, file.string());
  if (names.contains("demonstration_id")) return FileKind::kFollowers;
  const bool id =
      names.contains("instr_id") || names.contains("inst_idx") || names.contains("instruction_id");
  if (id && names.contains("trajectory")) return FileKind::kResults;
  return FileKind::kAnnotations;
}

std::string with_keys(std::string_view results, const std::string& file, ResultKeys keys,
                      Task task) {
  OrderedJson list = parse_list(results, file);
  KeyChanger changer(file, keys, task);
  for (std::size_t i = 0; i < list.size(); ++i) changer.change(list[i], i);
  changer.finish();
  return list_text(list);
}

namespace {

/// Without the id of SOON's entries, which they get where they had none.
tasks::PathAnnotation without_id(tasks::PathAnnotation path) {
  for (tasks::InstructionDetails& details : path.details) details.entry.reset();
  return path;
}

/// Without what DUET's lines do not hold of SOON's entries: which alternatives belong together.
tasks::PathAnnotation without_entry(tasks::PathAnnotation path) {
  path = without_id(std::move(path));
  path.group.reset();
  if (auto* boxes = std::get_if<tasks::NamedBoxes>(&path.goal)) boxes->first_alternative.clear();
  return path;
}

}  // namespace

std::string annotations_text(const tasks::Annotations& annotations, const AnnotationForm& form) {
  std::string text =
      form.released ? tasks::to_released_soon(annotations) : tasks::to_text(annotations);
  if (form.lines && skip_blanks(text).starts_with('[')) {
    text = lines_text(OrderedJson::parse(text));
  }
  const tasks::Annotations again =
      tasks::parse_annotations(text, "<converted>", annotations.split, annotations.task);
  for (std::size_t i = 0; i < annotations.paths.size(); ++i) {
    const tasks::PathAnnotation& path = annotations.paths[i];
    const bool lines_of_soon = annotations.task == Task::kSoon && !form.released;
    if (i < again.paths.size() &&
        (again.paths[i] == path || (form.released && without_id(again.paths[i]) == path) ||
         (lines_of_soon && without_entry(again.paths[i]) == without_entry(path)))) {
      continue;
    }
    throw ArgumentError(fmt::format("{}: path {} has what the other form cannot hold",
                                    annotations.file,
                                    path.id.empty() ? std::to_string(path.path_id) : path.id));
  }
  return text;
}

}  // namespace enfilade::exports
