#include "enfilade/homes/sets/home_list.h"

#include <fmt/format.h>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/core/detail/json.h"

namespace enfilade::homes::sets {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

constexpr std::string_view kFormat = "enfilade-homes";
constexpr std::int64_t kVersion = 1;
constexpr std::array kKinds{HomeKind::kHouse, HomeKind::kFlat, HomeKind::kOffice,
                            HomeKind::kHotelFloor};

Json to_json(const HomeSetOptions& o) {
  return {{"homes", o.homes},
          {"seed", o.seed},
          {"kind", o.kind ? Json(to_string(*o.kind)) : Json()},
          {"least_area", o.least_area},
          {"most_area", o.most_area},
          {"stairs_every", o.stairs_every},
          {"face_size", o.face_size},
          {"samples", o.samples},
          {"jpeg_quality", o.jpeg_quality}};
}

Json to_json(const HomeEntry& home) {
  Json rooms = Json::array();
  for (const RoomEntry& room : home.rooms) {
    rooms.push_back({{"type", std::string(1, room.type)},
                     {"name", room.name},
                     {"storey", room.storey},
                     {"viewpoints", room.viewpoints}});
  }
  Json json{{"scan", home.scan},
            {"kind", home.kind},
            {"seed", home.plan.seed},
            {"storeys", home.plan.storeys ? Json(*home.plan.storeys) : Json()},
            {"area", home.plan.area},
            {"viewpoints", home.viewpoints},
            {"edges", home.edges},
            {"triangles", home.triangles},
            {"rooms", std::move(rooms)}};
  if (!home.corrections.empty()) json["corrections"] = home.corrections;
  return json;
}

// Reads fields of one object into values of many types, reporting what is wrong.
class Reader {
 public:
  Reader(Element element, const Path& path, Faults& faults) : path_(path), faults_(faults) {
    object_ = json::object(element, path, faults);
  }

  template <class T>
  void whole(std::string_view name, T& value) {
    const auto element = find(name);
    if (!element) return;
    if (const auto number = json::integer(*element, Path(path_, name), faults_)) {
      if (*number < 0) {
        faults_.error(Path(path_, name), "bad-number", fmt::format("{}, below 0", *number));
      } else {
        value = static_cast<T>(*number);
      }
    }
  }
  // Seeds use all 64 bits.
  void seed(std::string_view name, std::uint64_t& value) {
    const auto element = find(name);
    if (element && element->is<std::uint64_t>()) {
      value = element->get_uint64().value();
    } else if (element) {
      std::int64_t negative = 0;  // or no number at all
      whole(name, negative);
    }
  }
  void real(std::string_view name, double& value) {
    if (const auto element = find(name)) {
      value = json::number(*element, Path(path_, name), faults_).value_or(0);
    }
  }
  void text(std::string_view name, std::string& value) {
    if (const auto element = find(name)) {
      value = json::string(*element, Path(path_, name), faults_).value_or("");
    }
  }
  // Nothing for null.
  std::optional<Element> optional(std::string_view name) {
    const auto element = find(name);
    return element && !element->is_null() ? element : std::nullopt;
  }
  bool has(std::string_view name) const {
    return object_ && object_->at_key(name).error() == simdjson::SUCCESS;
  }
  // Calls body(element, path) for each item.
  template <class Body>
  void each(std::string_view name, const Body& body) {
    const auto element = find(name);
    if (!element) return;
    const Path here(path_, name);
    const auto items = json::array(*element, here, faults_);
    if (!items) return;
    std::size_t i = 0;
    for (const Element item : *items) body(item, Path(here, i++));
  }
  std::optional<HomeKind> kind(std::string_view name) {
    const auto element = optional(name);
    if (!element) return std::nullopt;
    const auto word = json::string(*element, Path(path_, name), faults_);
    for (const HomeKind kind : kKinds) {
      if (word && *word == to_string(kind)) return kind;
    }
    if (word) faults_.error(Path(path_, name), "bad-kind", fmt::format("{:?} is no kind", *word));
    return std::nullopt;
  }

 private:
  std::optional<Element> find(std::string_view name) {
    if (!object_) return std::nullopt;
    auto found = object_->at_key(name);
    if (found.error() == simdjson::SUCCESS) return found.value();
    faults_.error(path_, "missing-field", fmt::format("no field {:?}", name));
    return std::nullopt;
  }

  const Path& path_;
  Faults& faults_;
  std::optional<simdjson::dom::object> object_;
};

HomeSetOptions read_options(Element element, const Path& path, Faults& faults) {
  HomeSetOptions o;
  Reader reader(element, path, faults);
  reader.whole("homes", o.homes);
  reader.seed("seed", o.seed);
  o.kind = reader.kind("kind");
  reader.real("least_area", o.least_area);
  reader.real("most_area", o.most_area);
  if (reader.has("stairs_every")) reader.whole("stairs_every", o.stairs_every);
  reader.whole("face_size", o.face_size);
  reader.whole("samples", o.samples);
  reader.whole("jpeg_quality", o.jpeg_quality);
  return o;
}

RoomEntry read_room(Element element, const Path& path, Faults& faults) {
  RoomEntry room;
  Reader reader(element, path, faults);
  std::string type;
  reader.text("type", type);
  if (type.size() == 1) {
    room.type = type[0];
  } else {
    faults.error(path, "bad-type", fmt::format("type {:?}, not one letter", type));
  }
  reader.text("name", room.name);
  reader.whole("storey", room.storey);
  reader.each("viewpoints", [&](Element id, const Path& here) {
    if (const auto text = json::string(id, here, faults)) room.viewpoints.emplace_back(*text);
  });
  return room;
}

HomeEntry read_home(Element element, const Path& path, Faults& faults) {
  HomeEntry home;
  Reader reader(element, path, faults);
  reader.text("scan", home.scan);
  home.plan.kind = reader.kind("kind");
  if (home.plan.kind) home.kind = to_string(*home.plan.kind);
  reader.seed("seed", home.plan.seed);
  if (reader.optional("storeys")) reader.whole("storeys", home.plan.storeys.emplace());
  reader.real("area", home.plan.area);
  try {
    check_options(home.plan);
  } catch (const ArgumentError& error) {
    faults.error(path, "bad-plan", error.what());
  }
  reader.whole("viewpoints", home.viewpoints);
  reader.whole("edges", home.edges);
  reader.whole("triangles", home.triangles);
  reader.each("rooms", [&](Element room, const Path& here) {
    home.rooms.push_back(read_room(room, here, faults));
  });
  if (reader.has("corrections")) reader.text("corrections", home.corrections);
  return home;
}

}  // namespace

std::string to_json(const HomeList& list) {
  Json homes = Json::array();
  for (const HomeEntry& home : list.homes) homes.push_back(to_json(home));
  const Json all{{"format", kFormat},
                 {"version", kVersion},
                 {"synthetic", true},
                 {"options", to_json(list.options)},
                 {"homes", std::move(homes)}};
  return all.dump(1) + "\n";
}

HomeList parse_home_list(std::string_view text, const std::string& file) {
  const json::Document document = json::Document::parse(text, file);
  Faults faults(file);
  const Path root;
  Reader reader(document.root(), root, faults);
  std::string format;
  std::int64_t version = 0;
  reader.text("format", format);
  reader.whole("version", version);
  if (faults.errors() == 0 && (format != kFormat || version != kVersion)) {
    faults.error(root, "bad-format",
                 fmt::format("format {:?}, version {}; only {:?}, version {}, can be read", format,
                             version, kFormat, kVersion));
  }
  faults.throw_if_errors();
  HomeList list;
  if (const auto options = reader.optional("options")) {
    list.options = read_options(*options, Path(root, "options"), faults);
  }
  reader.each("homes", [&](Element home, const Path& here) {
    list.homes.push_back(read_home(home, here, faults));
  });
  faults.throw_if_errors();
  return list;
}

std::string difference(const HomeSetOptions& a, const HomeSetOptions& b) {
  const Json ours = to_json(a), theirs = to_json(b);
  for (const auto& [name, value] : ours.items()) {
    if (value != theirs[name]) {
      return fmt::format("{}: {} there, {} asked for", name, value.dump(), theirs[name].dump());
    }
  }
  return "";
}

}  // namespace enfilade::homes::sets
