#include "enfilade/tasks/objects.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <exception>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/texts.h"
#include "enfilade/core/threads.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks {
namespace {

namespace fs = std::filesystem;
using formats::Element;
using formats::Faults;
using formats::Path;

using PixelBox = std::array<std::int32_t, 4>;

constexpr std::int64_t kViews = 36;
// Read before their faults are looked at: faults of all files would take too much memory.
constexpr std::size_t kFilesAtOnce = 1024;
constexpr std::size_t kFilesPerTask = 16;

struct Place {
  std::string_view scan, viewpoint;
  bool is_sure = true;  // nothing else could be meant
};

// Of "<scan>_<viewpoint>", cut at that place. Lengths differ: the ids of other data sets than
// Matterport3D's are "00000-kfPV7w3FaU5" and "000007".
std::optional<Place> cut_key(std::string_view key, std::size_t underscore) {
  if (underscore == std::string_view::npos) return std::nullopt;
  return Place{key.substr(0, underscore), key.substr(underscore + 1)};
}

std::string fault_of(const Place& place) {
  std::string fault = fault_of_id(place.scan);
  return fault.empty() ? fault_of_id(place.viewpoint) : fault;
}

bool describes_object(Element element);

// With the viewpoint that stands alone one level below, if there is that level; else cut by
// underscore_between_ids().
std::optional<Place> place_of(std::string_view key, Element below) {
  simdjson::dom::object members;
  if (std::ranges::count(key, '_') > 1 && below.get_object().get(members) == simdjson::SUCCESS &&
      members.size() == 1) {
    const auto member = *members.begin();
    if (key.ends_with(member.key) && member.key.size() < key.size() &&
        key[key.size() - member.key.size() - 1] == '_' && !describes_object(member.value)) {
      return cut_key(key, key.size() - member.key.size() - 1);
    }
  }
  auto place = cut_key(key, underscore_between_ids(key));
  if (place) place->is_sure = std::ranges::count(key, '_') == 1;
  return place;
}

// Without a sign and leading zeros: scorers compare the texts.
std::optional<std::int64_t> object_id(std::string_view key) {
  const auto id = parse_number<std::int64_t>(key);
  const bool plain = id && *id >= 0 && (key[0] != '0' || key.size() == 1);
  return plain && key[0] != '-' ? id : std::nullopt;
}

std::vector<std::uint8_t> read_views(Element element, const Path& path, Faults& faults) {
  std::vector<std::uint8_t> views;
  const auto list = json::array(element, path, faults);
  if (!list) return views;
  views.reserve(list->size());
  std::uint64_t seen = 0;
  std::size_t k = 0;
  for (const Element one : *list) {
    const Path place(path, k++);
    const auto view = json::integer(one, place, faults);
    if (!view) continue;
    if (*view < 0 || *view >= kViews) {
      faults.error(place, "bad-view", fmt::format("{} is no view; 0 to 35 are", *view));
      continue;
    }
    const std::uint64_t bit = std::uint64_t{1} << static_cast<unsigned>(*view);
    if ((seen & bit) != 0) {
      faults.error(place, "repeated-view", fmt::format("view {} stands there already", *view));
    }
    seen |= bit;
    views.push_back(static_cast<std::uint8_t>(*view));
  }
  return views;
}

PixelBox read_box(Element element, const Path& path, Faults& faults) {
  PixelBox box{};
  const auto numbers = json::array(element, path, faults);
  if (!numbers) return box;
  if (numbers->size() != box.size()) {
    faults.error(path, "bad-box",
                 fmt::format("{}, not [x, y, width, height]", json::describe(element)));
    return box;
  }
  std::size_t k = 0;
  for (const Element one : *numbers) {
    const Path place(path, k);
    const auto number = json::integer(one, place, faults);
    using Limits = std::numeric_limits<std::int32_t>;
    const std::int64_t least = k < 2 ? Limits::min() : 0;
    if (number && (*number < least || *number > Limits::max())) {
      faults.error(place, "bad-box",
                   fmt::format("{}, not a {} from {} to {}", *number, k < 2 ? "place" : "size",
                               least, Limits::max()));
    } else if (number) {
      box[k] = static_cast<std::int32_t>(*number);
    }
    ++k;
  }
  return box;
}

std::vector<PixelBox> read_boxes(Element element, const Path& path, Faults& faults) {
  std::vector<PixelBox> boxes;
  const auto list = json::array(element, path, faults);
  if (!list) return boxes;
  boxes.reserve(list->size());
  for (const Element one : *list) boxes.push_back(read_box(one, Path(path, boxes.size()), faults));
  return boxes;
}

constexpr std::array<json::Field, 3> kWanted{{{"name"}, {"visible_pos"}, {"bbox2d"}}};

void read_object(Element element, const Path& path, Faults& faults, ViewedObject& object) {
  const formats::Fields found(element, kWanted, path, faults);
  if (!found) return;
  object.name = found.text("name");
  const std::size_t errors = faults.errors();
  object.views = found.get("visible_pos", read_views);
  object.boxes = found.get("bbox2d", read_boxes);
  if (object.boxes.size() == object.views.size() || faults.errors() != errors) return;
  faults.error(
      found.place("bbox2d"), "box-count",
      fmt::format("{} boxes, not {}, one for each view", object.boxes.size(), object.views.size()));
}

std::vector<ViewedObject> read_objects(simdjson::dom::object members, std::string_view viewpoint,
                                       const Path& path, Faults& faults) {
  std::vector<ViewedObject> objects;
  objects.reserve(members.size());
  std::unordered_set<std::int64_t> ids;
  for (const auto member : members) {
    const Path place(path, member.key);
    if (faults.full()) {
      faults.stop(place);
      break;
    }
    const auto id = object_id(member.key);
    if (!id) {
      faults.error(place, "bad-object-id",
                   fmt::format("neither the viewpoint {} nor the number of an object, which has "
                               "digits alone, and no leading zeros",
                               quote(viewpoint)));
      continue;
    }
    if (!ids.insert(*id).second) {
      faults.error(place, "repeated-field", "given twice in one object");
    }
    ViewedObject& object = objects.emplace_back();
    object.id = *id;
    read_object(member.value, place, faults, object);
  }
  return objects;
}

// Whether it says something of an object, as it does in the form that has one level less.
bool describes_object(Element element) {
  simdjson::dom::object members;
  if (element.get_object().get(members) != simdjson::SUCCESS) return false;
  return std::ranges::any_of(kWanted, [&](const json::Field& field) {
    return members.at_key(field.name).error() == simdjson::SUCCESS;
  });
}

// What stands for a viewpoint, in either form. A viewpoint may have the same number as an object.
std::vector<ViewedObject> read_viewpoint(Element element, std::string_view viewpoint,
                                         const Path& path, Faults& faults) {
  const auto members = json::object(element, path, faults);
  if (!members) return {};
  bool nested = false;
  for (const auto member : *members) {
    nested = nested || (member.key == viewpoint && !describes_object(member.value));
  }
  if (!nested) return read_objects(*members, viewpoint, path, faults);
  std::optional<Element> inner;
  for (const auto member : *members) {
    if (member.key != viewpoint) {
      faults.error(Path(path, member.key), "unknown-viewpoint",
                   fmt::format("beside the viewpoint {}, which is to be alone", quote(viewpoint)));
      continue;
    }
    if (inner) faults.error(Path(path, viewpoint), "repeated-field", "given twice in one object");
    inner = member.value;
  }
  const Path place(path, viewpoint);
  const auto objects = json::object(*inner, place, faults);
  return objects ? read_objects(*objects, viewpoint, place, faults) : std::vector<ViewedObject>();
}

/// \name Folders
/// @{

std::optional<std::string> key_of(const fs::path& file) { return name_before(file, ".json"); }

std::vector<fs::path> viewpoint_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  for (fs::directory_iterator at(folder, code), end; !code && at != end; at.increment(code)) {
    if (key_of(at->path())) files.push_back(at->path());
  }
  if (code) throw FileError(folder.string() + ": cannot read: " + code.message());
  if (files.empty()) {
    throw FileError(folder.string() + ": has no file <scan>_<viewpoint>.json");
  }
  std::ranges::sort(files);
  return files;
}

// Content of a file. Threads keep their results, so that the first fault in order is reported, not
// in time.
struct Content {
  std::string scan, viewpoint;
  bool is_sure = true;  // as of Place
  std::vector<ViewedObject> objects;
  std::vector<Diagnostic> faults;
  std::exception_ptr failure;
};

Content read_viewpoint_file(const fs::path& file) {
  Content content;
  try {
    const std::string key = key_of(file).value();
    if (!cut_key(key, key.rfind('_'))) {
      refuse(file.string(), "$", "bad-name", "its name is not <scan>_<viewpoint>.json");
    }
    const json::Document document = json::Document::parse(read_text_file(file), file.string());
    const Place place = place_of(key, document.root()).value();
    if (std::string fault = fault_of(place); !fault.empty()) {
      refuse(file.string(), "$", "bad-id", std::move(fault));
    }
    content.scan = place.scan;
    content.viewpoint = place.viewpoint;
    content.is_sure = place.is_sure;
    Faults faults(document.name());
    content.objects = read_viewpoint(document.root(), content.viewpoint, Path(), faults);
    content.faults = faults.take();
  } catch (const InvalidInput& error) {
    content.faults = error.diagnostics();
  } catch (...) {
    content.failure = std::current_exception();
  }
  return content;
}

std::vector<Content> read_viewpoint_files(std::span<const fs::path> files) {
  std::vector<Content> contents(files.size());
  parallel_for(files.size(), kFilesPerTask, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) contents[i] = read_viewpoint_file(files[i]);
  });
  for (const Content& content : contents) {
    if (content.failure) std::rethrow_exception(content.failure);
  }
  return contents;
}
/// @}

std::string object_fault(const ViewedObject& object) {
  if (object.id < 0) return fmt::format("id {}, not 0 or more", object.id);
  if (object.boxes.size() != object.views.size()) {
    return fmt::format("{} boxes for {} views", object.boxes.size(), object.views.size());
  }
  std::set<std::uint8_t> views;
  for (const std::uint8_t view : object.views) {
    if (view >= kViews) return fmt::format("view {}, not one from 0 to 35", view);
    if (!views.insert(view).second) return fmt::format("view {} twice", view);
  }
  for (const PixelBox& box : object.boxes) {
    if (box[2] < 0 || box[3] < 0) return fmt::format("a box of {} x {} pixels", box[2], box[3]);
  }
  return {};
}

std::string json_text(std::string_view text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    throw ArgumentError(quote(text) + " is text that is not UTF-8");
  }
}

void write_object(const ViewedObject& object, std::string& text) {
  fmt::format_to(std::back_inserter(text), R"("{}":{{"name":{},"visible_pos":[)", object.id,
                 json_text(object.name));
  for (std::size_t k = 0; k < object.views.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{}{}", k == 0 ? "" : ",", object.views[k]);
  }
  text += R"(],"bbox2d":[)";
  for (std::size_t k = 0; k < object.boxes.size(); ++k) {
    const PixelBox& box = object.boxes[k];
    fmt::format_to(std::back_inserter(text), "{}[{},{},{},{}]", k == 0 ? "" : ",", box[0], box[1],
                   box[2], box[3]);
  }
  text += "]}";
}

/// The last words of names of a building's parts, as Matterport3D's category_mapping.tsv has them.
constexpr std::array<std::string_view, 38> kParts{
    "arch",    "archway",      "balustrade",     "banister",  "baseboard",  "beam",
    "ceiling", "ceiling duct", "ceiling pipe",   "door",      "door frame", "doorframe",
    "doorway", "facade",       "floor",          "handrail",  "landing",    "lintel",
    "molding", "moulding",     "paneling",       "panelling", "rafter",     "railing",
    "roof",    "skirting",     "skirting board", "skylight",  "stair",      "staircase",
    "stairs",  "stairwell",    "step",           "steps",     "wall",       "wall panel",
    "window",  "window frame"};
/// Words that fit any object.
constexpr std::array<std::string_view, 10> kAnything{"clutter", "frame",    "misc",   "object",
                                                     "objects", "other",    "remove", "unknown",
                                                     "void",    "unlabeled"};

}  // namespace

std::string spoken_name(std::string_view name) {
  name = name.substr(0, name.find_first_of("#/"));
  const auto last = name.find_last_not_of(' ');
  return std::string(name.substr(0, last == std::string_view::npos ? 0 : last + 1));
}

bool can_be_asked_for(std::string_view name) {
  std::string words = lower_case(spoken_name(name));
  std::ranges::replace(words, '_', ' ');
  const auto is_part = [&words](std::string_view part) {
    return words.ends_with(part) &&
           (words.size() == part.size() || words[words.size() - part.size() - 1] == ' ');
  };
  return !words.empty() && std::ranges::count(kAnything, words) == 0 &&
         std::ranges::none_of(kParts, is_part);
}

ObjectBoxes ObjectBoxes::parse(std::string_view json, const std::string& file) {
  const json::Document document = json::Document::parse(json, file);
  Faults faults(file);
  ObjectBoxes boxes;
  const Path root;
  if (const auto entries = json::object(document.root(), root, faults)) {
    for (const auto entry : *entries) {
      const Path path(root, entry.key);
      if (faults.full()) {
        faults.stop(path);
        break;
      }
      const auto place = place_of(entry.key, entry.value);
      if (!place) {
        faults.error(path, "bad-key", "not <scan>_<viewpoint>");
        continue;
      }
      if (std::string fault = fault_of(*place); !fault.empty()) {
        faults.error(path, "bad-id", std::move(fault));
        continue;
      }
      if (boxes.has(place->scan, place->viewpoint)) {
        faults.error(path, "repeated-field", "given twice in one object");
      }
      boxes.insert(place->scan, place->viewpoint, place->is_sure,
                   read_viewpoint(entry.value, place->viewpoint, path, faults));
    }
  }
  faults.throw_if_errors();
  return boxes;
}

ObjectBoxes ObjectBoxes::load(const fs::path& file_or_folder) {
  std::error_code code;
  if (!fs::is_directory(file_or_folder, code)) {
    return parse(read_text_file(file_or_folder), file_or_folder.string());
  }
  const std::vector<fs::path> files = viewpoint_files(file_or_folder);
  Faults faults(file_or_folder.string());
  ObjectBoxes boxes;
  for (std::size_t begin = 0; begin < files.size(); begin += kFilesAtOnce) {
    if (faults.full()) {
      faults.stop(Path());
      break;
    }
    const auto some = std::span(files).subspan(begin, std::min(kFilesAtOnce, files.size() - begin));
    std::vector<Content> contents = read_viewpoint_files(some);
    for (std::size_t i = 0; i < some.size(); ++i) {
      for (Diagnostic& fault : contents[i].faults) faults.add(std::move(fault));
      Content& one = contents[i];
      if (one.viewpoint.empty()) continue;  // a fault of its name or text is there
      const bool fresh = !boxes.has(one.scan, one.viewpoint);
      boxes.insert(one.scan, one.viewpoint, one.is_sure, std::move(one.objects));
      if (fresh) continue;
      faults.add({Severity::kError, some[i].string(), "$", "repeated-viewpoint",
                  "another file has the same scan and viewpoint"});
    }
  }
  faults.throw_if_errors();
  return boxes;
}

void ObjectBoxes::add(const std::string& scan, const std::string& viewpoint,
                      std::vector<ViewedObject> objects) {
  if (const std::string fault = fault_of({scan, viewpoint}); !fault.empty()) {
    throw ArgumentError(
        fmt::format("scan {}, viewpoint {}: {}", quote(scan), quote(viewpoint), fault));
  }
  if (has(scan, viewpoint)) {
    throw ArgumentError(
        fmt::format("viewpoint {} of scan {} is there already", quote(viewpoint), quote(scan)));
  }
  std::set<std::int64_t> ids;
  for (const ViewedObject& object : objects) {
    std::string fault = object_fault(object);
    if (fault.empty() && !ids.insert(object.id).second) fault = "there twice";
    if (fault.empty()) continue;
    throw ArgumentError(fmt::format("object {} around viewpoint {} of scan {}: {}", object.id,
                                    quote(viewpoint), quote(scan), fault));
  }
  insert(scan, viewpoint, true, std::move(objects));
}

void ObjectBoxes::insert(std::string_view scan, std::string_view viewpoint, bool is_sure,
                         std::vector<ViewedObject> objects) {
  if (!is_sure) unsure_.insert(fmt::format("{}_{}", scan, viewpoint));
  objects_[std::string(scan)].insert_or_assign(std::string(viewpoint), std::move(objects));
}

// By the whole key: first as it is cut here, then as it may have been cut.
const std::vector<ViewedObject>* ObjectBoxes::find(std::string_view scan,
                                                   std::string_view viewpoint) const {
  using Objects = std::vector<ViewedObject>;
  const auto look = [this](std::string_view s, std::string_view v) -> const Objects* {
    const auto viewpoints = objects_.find(s);
    if (viewpoints == objects_.end()) return nullptr;
    const auto objects = viewpoints->second.find(v);
    return objects == viewpoints->second.end() ? nullptr : &objects->second;
  };
  if (const auto* found = look(scan, viewpoint)) return found;
  constexpr char kBar = '_';
  if (scan.find(kBar) == std::string_view::npos && viewpoint.find(kBar) == std::string_view::npos) {
    return nullptr;
  }
  const std::string key = fmt::format("{}_{}", scan, viewpoint);
  const std::string_view whole = key;
  for (std::size_t at = key.find(kBar); at != std::string::npos; at = key.find(kBar, at + 1)) {
    if (const auto* found = look(whole.substr(0, at), whole.substr(at + 1))) return found;
  }
  return nullptr;
}

std::span<const ViewedObject> ObjectBoxes::at(std::string_view scan,
                                              std::string_view viewpoint) const {
  const auto* const found = find(scan, viewpoint);
  if (found == nullptr) return {};
  return *found;
}

bool ObjectBoxes::has(std::string_view scan, std::string_view viewpoint) const {
  return find(scan, viewpoint) != nullptr;
}

std::vector<std::string> ObjectBoxes::seen_from(std::string_view scan, std::int64_t object) const {
  std::set<std::string, std::less<>> seen;
  const auto add = [&](std::string_view viewpoint, const std::vector<ViewedObject>& objects) {
    const bool sees = std::ranges::any_of(
        objects, [&](const ViewedObject& one) { return one.id == object && one.visible(); });
    if (sees) seen.emplace(viewpoint);
  };
  if (const auto viewpoints = objects_.find(scan); viewpoints != objects_.end()) {
    for (const auto& [viewpoint, objects] : viewpoints->second) add(viewpoint, objects);
  }
  const std::string begin = fmt::format("{}_", scan);
  for (auto key = unsure_.lower_bound(begin); key != unsure_.end() && key->starts_with(begin);
       ++key) {
    const std::string_view viewpoint = std::string_view(*key).substr(begin.size());
    if (const auto* const objects = find(scan, viewpoint)) add(viewpoint, *objects);
  }
  return {seen.begin(), seen.end()};
}

ObjectBoxes::Counts ObjectBoxes::count() const {
  Counts counts;
  for (const auto& [scan, viewpoints] : objects_) {
    counts.viewpoints += viewpoints.size();
    for (const auto& [viewpoint, objects] : viewpoints) {
      if (objects.empty()) ++counts.without_objects;
      counts.objects += objects.size();
      for (const ViewedObject& object : objects) {
        if (!object.visible()) ++counts.without_views;
        counts.boxes += object.boxes.size();
      }
    }
  }
  return counts;
}

std::string ObjectBoxes::to_json(bool nested) const {
  std::string text = "{";
  for (const auto& [scan, viewpoints] : objects_) {
    for (const auto& [viewpoint, objects] : viewpoints) {
      text += text.size() == 1 ? "\n" : ",\n";
      text += json_text(scan + "_" + viewpoint) + ":{";
      if (nested) text += json_text(viewpoint) + ":{";
      for (std::size_t i = 0; i < objects.size(); ++i) {
        if (i > 0) text += ',';
        write_object(objects[i], text);
      }
      text += nested ? "}}" : "}";
    }
  }
  return text + "\n}\n";
}

}  // namespace enfilade::tasks
