#include "enfilade/homes/sets/home_list.h"

#include <fmt/format.h>
#include <concepts>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::homes::sets {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

constexpr std::string_view kPrefix = "home";  // of a scan's name
constexpr std::string_view kFormat = "enfilade-homes";
constexpr std::int64_t kVersion = 1;
// The largest coordinate (metres) or area (m2) that is read: far beyond any home, and small enough
// for the lines, whose ends are floats.
constexpr double kMostNumber = 1e6;

template <class T, class Object>
concept ConstOrNot = std::same_as<std::remove_const_t<T>, Object>;

// For each kind of object its fields, to be written and read: visit(name, field), or
// visit.optional(name, field) for those that lists of earlier versions lack.

void for_fields(ConstOrNot<HomeSetOptions> auto& o, auto& visit) {
  visit("homes", o.homes);
  visit("seed", o.seed);
  visit("kind", o.kind);
  visit("least_area", o.least_area);
  visit("most_area", o.most_area);
  visit.optional("stairs_every", o.stairs_every);
  visit("face_size", o.face_size);
  visit("samples", o.samples);
  visit("jpeg_quality", o.jpeg_quality);
  visit.optional("light", o.light);
  visit.optional("pretty", o.pretty);
}

void for_fields(ConstOrNot<RoomEntry> auto& room, auto& visit) {
  visit("type", room.type);
  visit("name", room.name);
  visit("storey", room.storey);
  visit.optional("floor", room.floor);
  visit.optional("elevation", room.elevation);
  visit("viewpoints", room.viewpoints);
}

void for_fields(ConstOrNot<draw::UnderlayStorey> auto& storey, auto& visit) {
  for (const draw::UnderlayKind& kind : draw::kUnderlayKinds) visit.lines(kind, storey.lines);
}

void for_fields(ConstOrNot<HomeEntry> auto& home, auto& visit) {
  visit("scan", home.scan);
  visit("kind", home.plan.kind);
  visit("seed", home.plan.seed);
  visit("storeys", home.plan.storeys);
  visit("area", home.plan.area);
  visit("viewpoints", home.viewpoints);
  visit("edges", home.edges);
  visit("triangles", home.triangles);
  visit("rooms", home.rooms);
  visit.optional("lines", home.lines.storeys);
  visit.optional("corrections", home.corrections);
}

class Writer {
 public:
  template <class T>
  static Json object(const T& value) {
    Writer writer;
    for_fields(value, writer);
    return std::move(writer.out_);
  }

  template <class T>
  void operator()(const char* name, const T& value) {
    out_[name] = json_of(value);
  }
  template <class T>
  void optional(const char* name, const T& value) {
    if constexpr (requires { value.empty(); }) {
      if (value.empty()) return;
    }
    out_[name] = json_of(value);
  }
  // As x, y of both ends of each line.
  void lines(const draw::UnderlayKind& which, const std::vector<draw::UnderlayLine>& lines) {
    out_[which.name] = draw::line_ends(lines, which.kind);
  }

 private:
  template <class T>
  static Json json_of(const T& value) {
    if constexpr (requires(Writer& writer) { for_fields(value, writer); }) {
      return object(value);
    } else {
      return value;
    }
  }
  template <class T>
  static Json json_of(const std::optional<T>& value) {
    return value ? json_of(*value) : Json();
  }
  template <class T>
  static Json json_of(const std::vector<T>& values) {
    Json list = Json::array();
    for (const T& value : values) list.push_back(json_of(value));
    return list;
  }
  static Json json_of(HomeKind kind) { return enum_name(kind); }
  static Json json_of(HomeLight light) { return enum_name(light); }
  static Json json_of(char letter) { return std::string(1, letter); }
  static Json json_of(const Rect& r) { return {r.x0, r.y0, r.x1, r.y1}; }

  Json out_;
};

class Reader {
 public:
  Reader(Element element, const Path& path, Faults& faults) : path_(path), faults_(faults) {
    if (json::object(element, path, faults)) object_ = element;
  }

  template <class T>
  void operator()(const char* name, T& value) {
    read_field({name}, value);
  }
  template <class T>
  void optional(const char* name, T& value) {
    read_field({name, false}, value);
  }
  void lines(const draw::UnderlayKind& which, std::vector<draw::UnderlayLine>& lines) {
    std::vector<double> numbers;
    optional(which.name, numbers);
    if (numbers.size() % 4 != 0) {
      faults_.error(Path(path_, which.name), "bad-lines",
                    fmt::format("{} numbers, not 4 for each line", numbers.size()));
      return;
    }
    for (std::size_t i = 0; i < numbers.size(); i += 4) {
      lines.push_back({which.kind, to_float({numbers[i], numbers[i + 1], 0}),
                       to_float({numbers[i + 2], numbers[i + 3], 0})});
    }
  }

 private:
  template <class T>
  void read_field(json::Field wanted, T& value) {
    if (!object_) return;
    if (const auto found = json::field(*object_, wanted, path_, faults_)) {
      read(*found, Path(path_, wanted.name), value);
    }
  }

  template <class T>
  void read(Element element, const Path& at, T& value) {
    Reader reader(element, at, faults_);
    for_fields(value, reader);
  }
  template <std::integral T>
  void read(Element element, const Path& at, T& value) {
    std::uint64_t number = 0;  // seeds use all 64 bits
    if (element.get(number) == simdjson::SUCCESS) {
      if (!std::in_range<T>(number)) {
        faults_.error(at, "bad-number", fmt::format("{}, too large", number));
      }
      value = static_cast<T>(number);
    } else if (const auto negative = json::integer(element, at, faults_)) {
      faults_.error(at, "bad-number", fmt::format("{}, below 0", *negative));
    }
  }
  void read(Element element, const Path& at, double& value) {
    value = json::number(element, at, faults_).value_or(0);
    if (std::abs(value) <= kMostNumber) return;
    faults_.error(at, "bad-number",
                  fmt::format("{}, not from {} to {}", value, -kMostNumber, kMostNumber));
    value = 0;
  }
  void read(Element element, const Path& at, std::string& value) {
    value = json::string(element, at, faults_).value_or("");
  }
  void read(Element element, const Path& at, char& value) {
    const auto text = json::string(element, at, faults_);
    if (text && text->size() == 1) {
      value = text->front();
    } else if (text) {
      faults_.error(path_, "bad-type", fmt::format("type {:?}, not one letter", *text));
    }
  }
  void read(Element element, const Path& at, HomeKind& value) {
    const auto word = json::string(element, at, faults_);
    if (!word) return;
    if (const auto kind = find_enum<HomeKind>(*word)) {
      value = *kind;
    } else {
      faults_.error(at, "bad-kind", fmt::format("{:?} is no kind", *word));
    }
  }
  void read(Element element, const Path& at, HomeLight& value) {
    const auto word = json::string(element, at, faults_);
    if (!word) return;
    try {
      value = parse_home_light(*word);
    } catch (const ArgumentError& error) {
      faults_.error(at, "bad-light", error.what());
    }
  }
  void read(Element element, const Path& at, Rect& value) {
    std::vector<double> ends;
    read(element, at, ends);
    if (ends.size() == 4) {
      value = {ends[0], ends[1], ends[2], ends[3]};
    } else {
      faults_.error(at, "bad-rectangle", fmt::format("{} numbers, not 4", ends.size()));
    }
  }
  template <class T>
  void read(Element element, const Path& at, std::optional<T>& value) {
    if (!element.is_null()) read(element, at, value.emplace());
  }
  template <class T>
  void read(Element element, const Path& at, std::vector<T>& values) {
    const auto items = json::array(element, at, faults_);
    if (!items) return;
    for (const Element item : *items) {
      const Path here(at, values.size());
      read(item, here, values.emplace_back());
    }
  }

  std::optional<Element> object_;  // no value if it is not an object, which was reported
  const Path& path_;
  Faults& faults_;
};

void check_plan(HomeEntry& home, const Path& path, Faults& faults) {
  if (home.plan.kind) home.kind = enum_name(*home.plan.kind);
  try {
    check_options(home.plan);
  } catch (const ArgumentError& error) {
    faults.error(path, "bad-plan", error.what());
  }
}

// A list that has a home's lines has the floors of its rooms too.
void check_floors(const HomeEntry& home, const Path& path, Faults& faults) {
  if (home.lines.storeys.empty()) return;
  const Path rooms(path, "rooms");
  for (std::size_t i = 0; i < home.rooms.size(); ++i) {
    const Rect& floor = home.rooms[i].floor;
    if (floor.width() > 0 && floor.depth() > 0) continue;
    faults.error(Path(rooms, i), "bad-rectangle", "its floor is missing or empty");
  }
}

}  // namespace

std::string to_json(const HomeList& list) {
  // A home a line: the lines of its plan are thousands of numbers.
  std::vector<std::string> homes;
  for (const HomeEntry& home : list.homes) homes.push_back("  " + Writer::object(home).dump());
  return fmt::format(
      "{{\n \"format\": \"{}\",\n \"version\": {},\n \"synthetic\": true,\n"
      " \"options\": {},\n \"homes\": [\n{}\n ]\n}}\n",
      kFormat, kVersion, Writer::object(list.options).dump(), fmt::join(homes, ",\n"));
}

HomeList parse_home_list(std::string_view text, const std::string& file) {
  const json::Document document = json::Document::parse(text, file);
  Faults faults(file);
  const Path root, homes(root, "homes");
  Reader reader(document.root(), root, faults);
  std::string format;
  std::uint32_t version = 0;
  reader("format", format);
  reader("version", version);
  if (faults.errors() == 0 && (format != kFormat || version != kVersion)) {
    faults.error(root, "bad-format",
                 fmt::format("format {:?}, version {}; only {:?}, version {}, can be read", format,
                             version, kFormat, kVersion));
  }
  faults.throw_if_errors();
  HomeList list;
  reader("options", list.options);
  reader("homes", list.homes);
  // A floor that could not be read is empty, and is reported already.
  const bool all_read = faults.errors() == 0;
  for (std::size_t i = 0; i < list.homes.size(); ++i) {
    const Path path(homes, i);
    check_plan(list.homes[i], path, faults);
    if (all_read) check_floors(list.homes[i], path, faults);
  }
  faults.throw_if_errors();
  return list;
}

std::string difference(const HomeSetOptions& a, const HomeSetOptions& b) {
  const Json ours = Writer::object(a), theirs = Writer::object(b);
  for (const auto& [name, value] : ours.items()) {
    if (value != theirs[name]) {
      return fmt::format("{}: {} there, {} asked for", name, value.dump(), theirs[name].dump());
    }
  }
  return "";
}

std::string scan_name(std::size_t home) { return fmt::format("{}{:04}", kPrefix, home + 1); }

std::optional<std::size_t> place_of_scan(const std::string& scan) {
  if (!scan.starts_with(kPrefix)) return std::nullopt;
  const auto number = parse_number<std::size_t>(std::string_view(scan).substr(kPrefix.size()));
  // Compared as a whole: "home1" has a number too.
  if (!number || *number == 0 || scan != scan_name(*number - 1)) return std::nullopt;
  return *number - 1;
}

std::string draws_of(const std::string& scan) {
  return scan.starts_with(kPrefix) ? "home_" + scan.substr(kPrefix.size()) : scan;
}

void write_alias_graph(const OutputFolder& connectivity) {
  scan::Connectivity graph{"ZMojNkEp431", "", {}};
  scan::ConnectivityEntry& entry = graph.entries.emplace_back();
  entry.id = "2f4d90acd4024c269fb0efe49a8ac540";
  // As of homes: right = +x, down = -z, look = +y, the eye at 1.5 m.
  entry.pose = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1.5, 0, 0, 0, 1};
  entry.height = 1.5;
  connectivity.write(scan::connectivity_file({}, graph.scan).string(), to_json(graph));
}

namespace {

namespace fs = std::filesystem;

constexpr const char* kList = "annotations.txt";

// The lines of a list; none where there is no list.
std::vector<std::string> read_list(const fs::path& list) {
  std::vector<std::string> files;
  if (!file_exists(list)) return files;
  const std::string text = read_plain_text(list);
  for (const auto& [number, line] : list_lines(text, HashLines::kEntries)) {
    if (!OutputFolder::is_name(line)) {
      throw InvalidInput({{Severity::kError, list.string(), fmt::format("line {}", number),
                           "bad-path", quote(line) + ", not a path of a file below the folder"}});
    }
    files.emplace_back(line);
  }
  return files;
}

// With folders above it that are empty then, up to `folder`.
void remove_file(const OutputFolder& out, const fs::path& file) {
  out.remove(file.string());
  for (fs::path above = file.parent_path(); !above.empty(); above = above.parent_path()) {
    if (!out.remove_empty(above.string())) return;
  }
}

}  // namespace

void WrittenFiles::write(const fs::path& file, std::string_view text) {
  out_.write(file.generic_string(), text);
  files_.insert(file.generic_string());
}

void WrittenFiles::finish() {
  for (const std::string& old : read_list(out_.path() / kList)) {
    if (!files_.contains(old)) remove_file(out_, old);
  }
  std::string list;
  for (const std::string& file : files_) list += file + "\n";
  out_.write(kList, list);
}

}  // namespace enfilade::homes::sets
