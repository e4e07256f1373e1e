#include "enfilade/tasks/files.h"

#include <fmt/format.h>
#include <algorithm>
#include <initializer_list>
#include <string>
#include <variant>

#include "enfilade/core/detail/json_entries.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/formats/readers.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks {
namespace {

// The first record of a text; calls `look` with it if it is an object. Faults are left to readers.
template <class Look>
bool look_at_first(std::string_view text, const Look& look) {
  try {
    json::Records records(text, "", formats::kMostRecordBytes);
    simdjson::dom::object object;
    return records.next() && records.element() &&
           records.element()->get_object().get(object) == simdjson::SUCCESS && look(object);
  } catch (const InvalidInput&) {
    return false;
  }
}

bool first_has(std::string_view text, std::initializer_list<std::string_view> fields) {
  return look_at_first(text, [&fields](const simdjson::dom::object& object) {
    return std::ranges::any_of(fields, [&object](std::string_view field) {
      return object.at_key(field).error() == simdjson::SUCCESS;
    });
  });
}

/// Whether the first record's instructions are made of several texts, as SOON's are.
bool first_has_compound_instructions(std::string_view text) {
  return look_at_first(text, [](const simdjson::dom::object& object) {
    const auto first = object.at_key("instructions").at(0);
    return first.is_object() || first.is_array();
  });
}

/// Whether a field of the first record is an object, or a list of them.
bool first_has_object(std::string_view text, std::string_view field) {
  return look_at_first(text, [field](const simdjson::dom::object& object) {
    const auto value = object.at_key(field);
    return value.is_object() || value.at(0).is_object();
  });
}

// Whether goals say who sees their objects, for which HM3DAutoVLN's lines have a field.
bool names_viewpoints(const Annotations& annotations) {
  return std::ranges::any_of(annotations.paths, [](const PathAnnotation& path) {
    const auto* goal = std::get_if<NamedObject>(&path.goal);
    return goal != nullptr && !goal->seen_from.empty();
  });
}

bool is_record(std::string_view text) {
  return first_has(text, {"scan", "path", "bboxes", "instr_id", "path_id", "id"});
}

}  // namespace

std::optional<Task> find_task(std::string_view text) {
  if (!is_record(text)) return std::nullopt;
  if (first_has(text, {"inst_idx", "start_pano"})) return Task::kCvdn;
  // Test splits of SOON have no boxes.
  if (first_has(text, {"bboxes"}) || first_has_compound_instructions(text)) return Task::kSoon;
  if (first_has(text, {"timed_instruction", "language"})) return Task::kRxr;
  if (first_has(text, {"midstop"})) return Task::kR2rBack;
  if (first_has(text, {"first_path_id"})) return Task::kR4r;
  if (first_has(text, {"objId", "id", "objid", "pos_vps"})) return Task::kReverie;
  return Task::kR2r;
}

std::optional<Task> find_task_of_results(std::string_view text) {
  if (first_has(text, {"predObjId", "pred_objid"})) return Task::kReverie;
  if (first_has(text, {"inst_idx"})) return Task::kCvdn;
  if (first_has(text, {"midstop"})) return Task::kR2rBack;
  if (first_has(text, {"instruction_id"})) return Task::kRxr;
  if (first_has_object(text, "trajectory")) return Task::kSoon;  // also in a list, as released
  return std::nullopt;
}

Annotations parse_annotations(std::string_view text, const std::string& file, std::string split,
                              Task task) {
  switch (task) {
    case Task::kRxr:
      return formats::parse_rxr_guide(text, file, std::move(split));
    case Task::kReverie:
      return first_has(text, {"pos_vps", "objid"})
                 ? formats::parse_object_lines(text, file, std::move(split))
                 : formats::parse_reverie(text, file, std::move(split));
    case Task::kCvdn:
      return first_has(text, {"inst_idx"})
                 ? formats::parse_cvdn(text, file, std::move(split))
                 : formats::parse_cvdn_encoded(text, file, std::move(split));
    case Task::kSoon:
      return first_has(text, {"path_id"}) ? formats::parse_soon_lines(text, file, std::move(split))
                                          : formats::parse_soon(text, file, std::move(split));
    case Task::kR2r:
      if (first_has(text, {"new_instructions"})) {
        return formats::parse_fine_grained(text, file, std::move(split));
      }
      break;
    case Task::kR2rLast:
    case Task::kR2rBack:
    case Task::kR4r:
      break;
  }
  return formats::parse_r2r_family(text, file, std::move(split), task);
}

Annotations load_annotations(const std::filesystem::path& file, std::string split, Task task) {
  const TextFile content(file);
  return parse_annotations(content.text(), file.string(), std::move(split), task);
}

std::string to_text(const Annotations& annotations) {
  switch (annotations.task) {
    case Task::kRxr:
      return formats::to_rxr_guide(annotations);
    case Task::kSoon:
      return formats::to_soon_lines(annotations);
    case Task::kReverie:
      return names_viewpoints(annotations) ? formats::to_object_lines(annotations)
                                           : formats::to_reverie(annotations);
    case Task::kCvdn:
      return formats::to_cvdn(annotations);
    case Task::kR2r:
    case Task::kR2rLast:
    case Task::kR2rBack:
    case Task::kR4r:
      break;
  }
  return formats::to_r2r_family(annotations);
}

bool needs_boxes(const Annotations& annotations) {
  return std::ranges::any_of(annotations.paths, [](const PathAnnotation& path) {
    const auto* object = std::get_if<NamedObject>(&path.goal);
    return object != nullptr && object->seen_from.empty();
  });
}

std::vector<std::filesystem::path> object_places() {
  return {"reverie/BBoxes.json",
          "reverie/BBoxes.json.gz",
          "reverie/BBox.json",
          "reverie/BBox.json.gz",
          "reverie/BBox",
          "REVERIE/annotations/BBoxes.json",
          "REVERIE/annotations/BBoxes.json.gz",
          "BBoxes.json",
          "BBoxes.json.gz",
          "BBox"};
}

std::vector<std::filesystem::path> fine_grained_places(std::string_view split) {
  const std::string name = fmt::format("FGR2R_{}.json", split);
  return {"fgr2r/" + name, "Fine-Grained-R2R/data/" + name, name};
}

}  // namespace enfilade::tasks
