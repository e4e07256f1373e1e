#include "enfilade/mesh/house.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <limits>

#include "enfilade/mesh/detail/text.h"

namespace enfilade::mesh {
namespace {

/// The words of one record, read from left to right.
class Record {
 public:
  Record(std::vector<std::string_view> words, std::string where, FaultList& faults)
      : words_(std::move(words)), where_(std::move(where)), faults_(&faults) {}

  void error(const char* code, std::string message) {
    faults_->error(where_, code, std::move(message));
  }
  std::size_t size() const { return words_.size(); }
  std::string_view letter() const { return words_.front(); }

  std::string_view word() { return words_[next_++]; }
  void skip(std::size_t n) { next_ += n; }
  double number(const char* field) {
    const std::string_view text = word();
    const auto value = to_number(text);
    if (!value) bad(field, text, "a finite number");
    return value.value_or(0);
  }
  std::int32_t integer(const char* field) {
    const std::string_view text = word();
    const auto value = to_integer(text);
    if (value && *value >= kLeast && *value <= kMost) return static_cast<std::int32_t>(*value);
    bad(field, text, "a whole number of 32 bits");
    return -1;
  }
  std::uint32_t count(const char* field) {
    const std::string_view text = word();
    const auto value = to_integer(text);
    if (value && *value >= 0 && *value <= kMost) return static_cast<std::uint32_t>(*value);
    bad(field, text, "a whole number from 0 on");
    return 0;
  }
  /// An entry of a list, or -1.
  std::int32_t index(const char* field, std::size_t size) {
    const std::int32_t value = integer(field);
    if (value >= -1 && value < static_cast<std::int64_t>(size)) return value;
    error("bad-index", fmt::format("{} {}, not -1 or one of the {} there are", field, value, size));
    return -1;
  }
  /// The record's own place.
  void place(std::size_t expected) {
    const std::int32_t value = integer("index");
    if (value == static_cast<std::int64_t>(expected)) return;
    error("bad-index", fmt::format("index {}, not its place among its kind, {}", value, expected));
  }
  std::string name() {
    std::string text(word());
    if (text == "-") return {};
    std::ranges::replace(text, '#', ' ');
    return text;
  }
  char label(const char* field) {
    const std::string_view text = word();
    if (text.size() == 1) return text[0];
    bad(field, text, "one character");
    return '-';
  }
  Vec3d vec(const char* field) {
    const double x = number(field), y = number(field);
    return {x, y, number(field)};
  }
  HouseBox box() {
    const Vec3d low = vec("bounding box");
    return {low, vec("bounding box")};
  }

 private:
  static constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();

  void bad(const char* field, std::string_view text, const char* allowed) {
    error("bad-value", fmt::format("{} {}, not {}", field, in_quotes(text), allowed));
  }

  std::vector<std::string_view> words_;
  std::size_t next_ = 1;
  std::string where_;
  FaultList* faults_;
};

HouseLevel read_level(Record& r, const House& house) {
  r.place(house.levels.size());
  r.skip(1);  // how many regions: said by them, too
  std::string label = r.name();
  const Vec3d position = r.vec("position");
  return {std::move(label), position, r.box()};
}

HouseRegion read_region(Record& r, const House& house) {
  HouseRegion out;
  r.place(house.regions.size());
  out.level = r.index("level", house.levels.size());
  r.skip(2);
  out.label = r.label("label");
  out.position = r.vec("position");
  out.box = r.box();
  out.height = r.number("height");
  return out;
}

HousePortal read_portal(Record& r, const House& house) {
  HousePortal out;
  r.place(house.portals.size());
  out.region0 = r.index("first region", house.regions.size());
  out.region1 = r.index("second region", house.regions.size());
  out.label = r.name();
  out.p0 = r.vec("first point");
  out.p1 = r.vec("second point");
  return out;
}

HouseSurface read_surface(Record& r, const House& house) {
  HouseSurface out;
  r.place(house.surfaces.size());
  out.region = r.index("region", house.regions.size());
  r.skip(1);
  out.label = r.label("label");
  out.position = r.vec("position");
  out.normal = r.vec("normal");
  out.box = r.box();
  return out;
}

HouseVertex read_vertex(Record& r, const House& house) {
  HouseVertex out;
  r.place(house.vertices.size());
  out.surface = r.index("surface", house.surfaces.size());
  out.label = r.name();
  out.position = r.vec("position");
  out.normal = r.vec("normal");
  return out;
}

HousePanorama read_panorama(Record& r, const House& house) {
  HousePanorama out;
  out.name = r.name();
  r.place(house.panoramas.size());
  out.region = r.index("region", house.regions.size());
  r.skip(1);
  out.position = r.vec("position");
  return out;
}

HouseImage read_image(Record& r, const House& house) {
  HouseImage out;
  r.place(house.images.size());
  out.panorama = r.index("panorama", house.panoramas.size());
  out.name = r.name();
  out.camera = r.integer("camera");
  out.yaw = r.integer("yaw");
  for (double& value : out.camera_from_world) value = r.number("extrinsics");
  for (double& value : out.intrinsics) value = r.number("intrinsics");
  out.width = r.count("width");
  out.height = r.count("height");
  out.position = r.vec("position");
  return out;
}

HouseCategory read_category(Record& r, const House& house) {
  HouseCategory out;
  r.place(house.categories.size());
  out.mapping_index = r.integer("mapping index");
  out.mapping_name = r.name();
  out.mpcat40_index = r.integer("mpcat40 index");
  out.mpcat40_name = r.name();
  return out;
}

HouseObject read_object(Record& r, const House& house) {
  HouseObject out;
  r.place(house.objects.size());
  out.region = r.index("region", house.regions.size());
  out.category = r.index("category", house.categories.size());
  out.position = r.vec("position");
  out.axis0 = r.vec("first axis");
  out.axis1 = r.vec("second axis");
  out.radii = r.vec("radii");
  return out;
}

HouseSegment read_segment(Record& r, const House& house) {
  HouseSegment out;
  r.place(house.segments.size());
  out.object = r.index("object", house.objects.size());
  out.id = r.integer("id");
  out.area = r.number("area");
  out.position = r.vec("position");
  out.box = r.box();
  return out;
}

/// One kind of record, in the order that the file has them.
struct Kind {
  std::string_view letter;
  std::string_view name;
  std::size_t words;
  std::uint32_t count;
  void (*read)(Record&, House&);
};

template <auto list, auto read_one>
void read_into(Record& record, House& house) {
  (house.*list).push_back(read_one(record, house));
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& file) : lines_(text), faults_(file) {}

  House parse() {
    const bool short_header = read_version();
    read_header(short_header);
    faults_.throw_if_any();
    read_records();
    faults_.throw_if_any();
    return std::move(house_);
  }

 private:
  /// The next line that has words.
  std::optional<Record> next() {
    while (const auto line = lines_.next()) {
      auto found = words(*line);
      if (!found.empty()) return Record(std::move(found), lines_.where(), faults_);
    }
    return std::nullopt;
  }

  bool read_version() {
    const auto line = lines_.next();
    const auto found = words(line.value_or(""));
    if (found.size() == 2 && found[0] == "ASCII" && found[1].starts_with("1.")) {
      return found[1] == "1.0";
    }
    faults_.error(
        "line 1", "bad-header",
        fmt::format("{}, not \"ASCII 1.0\" or \"ASCII 1.1\"", in_quotes(line.value_or(""))));
    faults_.throw_if_any();
    return false;
  }

  void read_header(bool short_header) {
    auto record = next();
    const std::size_t wanted = short_header ? 23 : 29;
    if (!record || record->letter() != "H" || record->size() != wanted) {
      faults_.error(lines_.where(), "bad-header",
                    fmt::format("{}, not an H record of {} words",
                                record ? fmt::format("a record {} of {} words",
                                                     in_quotes(record->letter()), record->size())
                                       : "the end of the file",
                                wanted));
      return;
    }
    house_.name = record->name();
    house_.label = record->name();
    const std::uint32_t images = record->count("images"), panoramas = record->count("panoramas"),
                        vertices = record->count("vertices"), surfaces = record->count("surfaces");
    std::uint32_t segments = 0, objects = 0, categories = 0, portals = 0;
    if (!short_header) {
      segments = record->count("segments");
      objects = record->count("objects");
      categories = record->count("categories");
    }
    const std::uint32_t regions = record->count("regions");
    if (!short_header) portals = record->count("portals");
    const std::uint32_t levels = record->count("levels");
    if (!short_header) record->skip(5);
    house_.box = record->box();
    kinds_ = {
        {"L", "levels", 18, levels, read_into<&House::levels, read_level>},
        {"R", "regions", 20, regions, read_into<&House::regions, read_region>},
        {"P", "portals", 15, portals, read_into<&House::portals, read_portal>},
        {"S", "surfaces", 22, surfaces, read_into<&House::surfaces, read_surface>},
        {"V", "vertices", 13, vertices, read_into<&House::vertices, read_vertex>},
        {"P", "panoramas", 13, panoramas, read_into<&House::panoramas, read_panorama>},
        {"I", "images", 41, images, read_into<&House::images, read_image>},
        {"C", "categories", 11, categories, read_into<&House::categories, read_category>},
        {"O", "objects", 24, objects, read_into<&House::objects, read_object>},
        {"E", "segments", 19, segments, read_into<&House::segments, read_segment>},
    };
  }

  void read_records() {
    auto record = next();
    for (const Kind& kind : kinds_) {
      std::uint32_t found = 0;
      for (; record && record->letter() == kind.letter && found < kind.count; ++found) {
        if (record->size() == kind.words) {
          kind.read(*record, house_);
        } else {
          record->error("bad-length",
                        fmt::format("a record {} ({}) of {} words, not {}", kind.letter, kind.name,
                                    record->size(), kind.words));
          faults_.throw_if_any();  // the places of all that follow would be wrong
        }
        record = next();
      }
      if (found == kind.count) continue;
      const std::string what = record ? "a record " + in_quotes(record->letter()) : "the end";
      faults_.error(
          lines_.where(), "bad-count",
          fmt::format("{} after {} {}, but H says {}", what, found, kind.name, kind.count));
      return;
    }
    if (record) {
      record->error("bad-count", fmt::format("a record {} after all that H says there are",
                                             in_quotes(record->letter())));
    }
  }

  Lines lines_;
  FaultList faults_;
  House house_;
  std::vector<Kind> kinds_;
};

/// Builds the text; numbers in the shortest form that reads back equal.
class Writer {
 public:
  void line(std::string_view letter) { text_ += (text_.empty() ? "" : "\n") + std::string(letter); }
  template <class T>
  Writer& number(T value) {
    fmt::format_to(std::back_inserter(text_), " {}", value);
    return *this;
  }
  /// A word that splits where it should not, or none at all, would break the record.
  Writer& name(std::string_view value) {
    text_ += ' ';
    if (value.empty()) text_ += '-';
    for (const char c : value) {
      const bool blank = c == ' ' || (c >= '\t' && c <= '\r');
      text_ += blank ? '#' : c;
    }
    return *this;
  }
  Writer& vec(Vec3d v) { return number(v.x).number(v.y).number(v.z); }
  Writer& box(const HouseBox& b) { return vec(b.low).vec(b.high); }
  Writer& zeros(int n) {
    for (; n > 0; --n) text_ += " 0";
    return *this;
  }
  std::string take() { return std::move(text_) + "\n"; }

 private:
  std::string text_;
};

void write_header(Writer& w, const House& h) {
  w.line("ASCII 1.1");
  w.line("H");
  w.name(h.name).name(h.label);
  for (const std::size_t n :
       {h.images.size(), h.panoramas.size(), h.vertices.size(), h.surfaces.size(),
        h.segments.size(), h.objects.size(), h.categories.size(), h.regions.size(),
        h.portals.size(), h.levels.size()}) {
    w.number(n);
  }
  w.zeros(5).box(h.box).zeros(5);
}

void write_rooms(Writer& w, const House& h) {
  for (std::size_t i = 0; i < h.levels.size(); ++i) {
    const HouseLevel& x = h.levels[i];
    const auto regions = std::ranges::count(h.regions, static_cast<std::int32_t>(i),
                                            [](const HouseRegion& r) { return r.level; });
    w.line("L");
    w.number(i).number(regions).name(x.label).vec(x.position).box(x.box).zeros(5);
  }
  for (std::size_t i = 0; i < h.regions.size(); ++i) {
    const HouseRegion& x = h.regions[i];
    w.line("R");
    w.number(i).number(x.level).zeros(2).name({&x.label, 1}).vec(x.position).box(x.box);
    w.number(x.height).zeros(4);
  }
  for (std::size_t i = 0; i < h.portals.size(); ++i) {
    const HousePortal& x = h.portals[i];
    w.line("P");
    w.number(i).number(x.region0).number(x.region1).name(x.label).vec(x.p0).vec(x.p1).zeros(4);
  }
  for (std::size_t i = 0; i < h.surfaces.size(); ++i) {
    const HouseSurface& x = h.surfaces[i];
    w.line("S");
    w.number(i).number(x.region).zeros(1).name({&x.label, 1}).vec(x.position).vec(x.normal);
    w.box(x.box).zeros(5);
  }
  for (std::size_t i = 0; i < h.vertices.size(); ++i) {
    const HouseVertex& x = h.vertices[i];
    w.line("V");
    w.number(i).number(x.surface).name(x.label).vec(x.position).vec(x.normal).zeros(3);
  }
}

void write_pictures(Writer& w, const House& h) {
  for (std::size_t i = 0; i < h.panoramas.size(); ++i) {
    const HousePanorama& x = h.panoramas[i];
    w.line("P");
    w.name(x.name).number(i).number(x.region).zeros(1).vec(x.position).zeros(5);
  }
  for (std::size_t i = 0; i < h.images.size(); ++i) {
    const HouseImage& x = h.images[i];
    w.line("I");
    w.number(i).number(x.panorama).name(x.name).number(x.camera).number(x.yaw);
    for (const double value : x.camera_from_world) w.number(value);
    for (const double value : x.intrinsics) w.number(value);
    w.number(x.width).number(x.height).vec(x.position).zeros(5);
  }
}

void write_things(Writer& w, const House& h) {
  for (std::size_t i = 0; i < h.categories.size(); ++i) {
    const HouseCategory& x = h.categories[i];
    w.line("C");
    w.number(i).number(x.mapping_index).name(x.mapping_name);
    w.number(x.mpcat40_index).name(x.mpcat40_name).zeros(5);
  }
  for (std::size_t i = 0; i < h.objects.size(); ++i) {
    const HouseObject& x = h.objects[i];
    w.line("O");
    w.number(i).number(x.region).number(x.category).vec(x.position).vec(x.axis0).vec(x.axis1);
    w.vec(x.radii).zeros(8);
  }
  for (std::size_t i = 0; i < h.segments.size(); ++i) {
    const HouseSegment& x = h.segments[i];
    w.line("E");
    w.number(i).number(x.object).number(x.id).number(x.area).vec(x.position).box(x.box).zeros(5);
  }
}

}  // namespace

House parse_house(std::string_view text, const std::string& file) {
  return Parser(text, file).parse();
}

std::string to_text(const House& house) {
  Writer writer;
  write_header(writer, house);
  write_rooms(writer, house);
  write_pictures(writer, house);
  write_things(writer, house);
  return writer.take();
}

std::vector<RegionType> region_types() {
  return {{'a', "bathroom"}, {'b', "bedroom"},    {'c', "closet"},    {'d', "dining"},
          {'e', "entryway"}, {'f', "familyroom"}, {'g', "garage"},    {'h', "hallway"},
          {'i', "library"},  {'j', "laundry"},    {'k', "kitchen"},   {'l', "living"},
          {'m', "meeting"},  {'n', "lounge"},     {'o', "office"},    {'p', "porch"},
          {'r', "rec"},      {'s', "stairs"},     {'t', "toilet"},    {'u', "utility"},
          {'v', "tv"},       {'w', "workout"},    {'x', "outdoor"},   {'y', "balcony"},
          {'z', "other"},    {'B', "bar"},        {'C', "classroom"}, {'D', "dining booth"},
          {'S', "spa"},      {'Z', "junk"},       {'-', "none"}};
}

}  // namespace enfilade::mesh
