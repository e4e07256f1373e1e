#include "enfilade/mesh/house.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "enfilade/core/names.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh {

using namespace readers;

namespace {

/// Reads the words of one record from left to right.
class RecordReader {
 public:
  RecordReader(std::vector<std::string_view> words, std::string where, FaultList& faults)
      : words_(std::move(words)), where_(std::move(where)), faults_(&faults) {}

  void error(const char* code, std::string message) {
    faults_->error(where_, code, std::move(message));
  }
  std::size_t size() const { return words_.size(); }
  std::string_view letter() const { return words_.front(); }

  void number(const char* field, double& out) {
    const std::string_view text = word();
    const auto value = to_number(text);
    if (!value) bad(field, text, "a finite number");
    out = value.value_or(0);
  }
  void integer(const char* field, std::int32_t& out) {
    out = static_cast<std::int32_t>(whole(field, kLeast, -1, "a whole number of 32 bits"));
  }
  void count(const char* field, std::uint32_t& out) {
    out = static_cast<std::uint32_t>(whole(field, 0, 0, "a whole number from 0 on"));
  }
  /// An entry of a list of `size`, or -1.
  void index(const char* field, std::int32_t& out, std::size_t size) {
    integer(field, out);
    if (out >= -1 && out < static_cast<std::int64_t>(size)) return;
    error("bad-index", fmt::format("{} {}, not -1 or one of the {} there are", field, out, size));
    out = -1;
  }
  /// The record's own place among its kind.
  void place(std::size_t expected) {
    std::int32_t value = 0;
    integer("index", value);
    if (value == static_cast<std::int64_t>(expected)) return;
    error("bad-index", fmt::format("index {}, not its place among its kind, {}", value, expected));
  }
  void name(std::string& out) {
    out = word();
    if (out == "-") out.clear();
    std::ranges::replace(out, '#', ' ');
  }
  /// A name of files.
  void id(std::string& out) {
    const std::string_view text = word();
    out = text == "-" ? "" : text;
    if (std::string fault = fault_of_id(text); text != "-" && !fault.empty()) {
      error("bad-id", std::move(fault));
    }
  }
  void label(const char* field, char& out) {
    const std::string_view text = word();
    out = text.size() == 1 ? text[0] : '-';
    if (text.size() != 1) bad(field, text, "one character");
  }
  void vec(const char* field, Vec3d& out) {
    number(field, out.x);
    number(field, out.y);
    number(field, out.z);
  }
  void box(HouseBox& out) {
    vec("bounding box", out.low);
    vec("bounding box", out.high);
  }
  /// Unused words.
  void zeros(std::size_t n) { next_ += n; }
  /// A number that follows from other records.
  template <class Count>
  void derived(const Count& /*count*/) {
    ++next_;
  }

 private:
  static constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();

  std::string_view word() { return words_[next_++]; }
  std::int64_t whole(const char* field, std::int64_t least, std::int64_t otherwise,
                     const char* allowed) {
    const std::string_view text = word();
    const auto value = to_integer(text);
    if (value && *value >= least && *value <= kMost) return *value;
    bad(field, text, allowed);
    return otherwise;
  }
  void bad(const char* field, std::string_view text, const char* allowed) {
    error("bad-value", fmt::format("{} {}, not {}", field, quote(text), allowed));
  }

  std::vector<std::string_view> words_;
  std::size_t next_ = 1;
  std::string where_;
  FaultList* faults_;
};

/// Writes records by the same calls; numbers in the shortest form that reads back equal.
class RecordWriter {
 public:
  void line(std::string_view letter) { text_ += (text_.empty() ? "" : "\n") + std::string(letter); }
  std::string take() { return std::move(text_) + "\n"; }

  void number(const char*, double value) { word(value); }
  void integer(const char*, std::int32_t value) { word(value); }
  void count(const char*, std::uint32_t value) { word(value); }
  void index(const char*, std::int32_t value, std::size_t) { word(value); }
  void place(std::size_t value) { word(value); }
  /// Blanks in a name, or an empty name, would break the record.
  void name(std::string_view value) {
    text_ += ' ';
    if (value.empty()) text_ += '-';
    for (const char c : value) {
      const bool blank = c == ' ' || (c >= '\t' && c <= '\r');
      text_ += blank ? '#' : c;
    }
  }
  void id(std::string_view value) { name(value); }
  void label(const char*, char value) { name({&value, 1}); }
  void vec(const char*, Vec3d v) {
    word(v.x);
    word(v.y);
    word(v.z);
  }
  void box(const HouseBox& b) {
    vec("", b.low);
    vec("", b.high);
  }
  void zeros(std::size_t n) {
    for (; n > 0; --n) text_ += " 0";
  }
  template <class Count>
  void derived(const Count& count) {
    word(count());
  }

 private:
  template <class T>
  void word(T value) {
    fmt::format_to(std::back_inserter(text_), " {}", value);
  }
  std::string text_;
};

// The words of each kind of record, for `io`, a RecordReader or a RecordWriter. `i`: its place.

constexpr auto kLevel = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.derived([&] {
    return std::ranges::count(h.regions, static_cast<std::int32_t>(i), &HouseRegion::level);
  });
  io.name(x.label);
  io.vec("position", x.position);
  io.box(x.box);
  io.zeros(5);
};

constexpr auto kRegion = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("level", x.level, h.levels.size());
  io.zeros(2);
  io.label("label", x.label);
  io.vec("position", x.position);
  io.box(x.box);
  io.number("height", x.height);
  io.zeros(4);
};

constexpr auto kPortal = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("first region", x.region0, h.regions.size());
  io.index("second region", x.region1, h.regions.size());
  io.name(x.label);
  io.vec("first point", x.p0);
  io.vec("second point", x.p1);
  io.zeros(4);
};

constexpr auto kSurface = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("region", x.region, h.regions.size());
  io.zeros(1);
  io.label("label", x.label);
  io.vec("position", x.position);
  io.vec("normal", x.normal);
  io.box(x.box);
  io.zeros(5);
};

constexpr auto kVertex = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("surface", x.surface, h.surfaces.size());
  io.name(x.label);
  io.vec("position", x.position);
  io.vec("normal", x.normal);
  io.zeros(3);
};

constexpr auto kPanorama = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.id(x.name);
  io.place(i);
  io.index("region", x.region, h.regions.size());
  io.zeros(1);
  io.vec("position", x.position);
  io.zeros(5);
};

constexpr auto kImage = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("panorama", x.panorama, h.panoramas.size());
  io.id(x.name);
  io.integer("camera", x.camera);
  io.integer("yaw", x.yaw);
  for (auto& value : x.camera_from_world) io.number("extrinsics", value);
  for (auto& value : x.intrinsics) io.number("intrinsics", value);
  io.count("width", x.width);
  io.count("height", x.height);
  io.vec("position", x.position);
  io.zeros(5);
};

constexpr auto kCategory = [](auto& io, auto& x, std::size_t i, const House&) {
  io.place(i);
  io.integer("mapping index", x.mapping_index);
  io.name(x.mapping_name);
  io.integer("mpcat40 index", x.mpcat40_index);
  io.name(x.mpcat40_name);
  io.zeros(5);
};

constexpr auto kObject = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("region", x.region, h.regions.size());
  io.index("category", x.category, h.categories.size());
  io.vec("position", x.position);
  io.vec("first axis", x.axis0);
  io.vec("second axis", x.axis1);
  io.vec("radii", x.radii);
  io.zeros(8);
};

constexpr auto kSegment = [](auto& io, auto& x, std::size_t i, const House& h) {
  io.place(i);
  io.index("object", x.object, h.objects.size());
  io.integer("id", x.id);
  io.number("area", x.area);
  io.vec("position", x.position);
  io.box(x.box);
  io.zeros(5);
};

/// One kind of record.
struct Kind {
  std::string_view letter;
  const char* name;
  std::size_t words;
  bool in_first_version;  ///< ASCII 1.0
  std::size_t (*count)(const House&);
  void (*read)(RecordReader&, House&);
  void (*write)(RecordWriter&, std::string_view letter, const House&);
};

template <auto kList, auto kFields>
constexpr Kind kind(std::string_view letter, const char* name, std::size_t words,
                    bool in_first_version = true) {
  return {letter,
          name,
          words,
          in_first_version,
          [](const House& house) { return (house.*kList).size(); },
          [](RecordReader& reader, House& house) {
            auto& records = house.*kList;
            typename std::remove_reference_t<decltype(records)>::value_type record;
            kFields(reader, record, records.size(), house);
            records.push_back(std::move(record));
          },
          [](RecordWriter& writer, std::string_view with, const House& house) {
            for (std::size_t i = 0; i < (house.*kList).size(); ++i) {
              writer.line(with);
              kFields(writer, (house.*kList)[i], i, house);
            }
          }};
}

/// In the order that the file has them.
constexpr std::array<Kind, 10> kKinds{
    kind<&House::levels, kLevel>("L", "levels", 18),
    kind<&House::regions, kRegion>("R", "regions", 20),
    kind<&House::portals, kPortal>("P", "portals", 15, false),
    kind<&House::surfaces, kSurface>("S", "surfaces", 22),
    kind<&House::vertices, kVertex>("V", "vertices", 13),
    kind<&House::panoramas, kPanorama>("P", "panoramas", 13),
    kind<&House::images, kImage>("I", "images", 41),
    kind<&House::categories, kCategory>("C", "categories", 11, false),
    kind<&House::objects, kObject>("O", "objects", 24, false),
    kind<&House::segments, kSegment>("E", "segments", 19, false),
};

/// The counts of the H record, as places in kKinds: images, panoramas, vertices, surfaces,
/// segments, objects, categories, regions, portals, levels.
constexpr std::array<std::size_t, kKinds.size()> kHeaderCounts{6, 5, 4, 3, 9, 8, 7, 1, 2, 0};

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
  std::optional<RecordReader> next() {
    while (const auto line = lines_.next()) {
      auto found = words(*line);
      if (!found.empty()) return RecordReader(std::move(found), lines_.where(), faults_);
    }
    return std::nullopt;
  }

  bool read_version() {
    const auto line = lines_.next();
    const auto found = words(line.value_or(""));
    if (found.size() == 2 && found[0] == "ASCII" && found[1].starts_with("1.")) {
      return found[1] == "1.0";
    }
    faults_.error("line 1", "bad-header",
                  fmt::format("{}, not \"ASCII 1.0\" or \"ASCII 1.1\"", quote(line.value_or(""))));
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
                                                     quote(record->letter()), record->size())
                                       : "the end of the file",
                                wanted));
      return;
    }
    record->name(house_.name);
    record->name(house_.label);
    for (const std::size_t k : kHeaderCounts) {
      if (!short_header || kKinds[k].in_first_version) record->count(kKinds[k].name, counts_[k]);
    }
    if (!short_header) record->zeros(5);
    record->box(house_.box);
  }

  void read_records() {
    auto record = next();
    for (std::size_t k = 0; k < kKinds.size(); ++k) {
      const Kind& kind = kKinds[k];
      const std::uint32_t wanted = counts_[k];
      std::uint32_t found = 0;
      for (; record && record->letter() == kind.letter && found < wanted; ++found) {
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
      if (found == wanted) continue;
      const std::string what = record ? "a record " + quote(record->letter()) : "the end";
      faults_.error(lines_.where(), "bad-count",
                    fmt::format("{} after {} {}, but H says {}", what, found, kind.name, wanted));
      return;
    }
    if (record) {
      record->error("bad-count", fmt::format("a record {} after all that H says there are",
                                             quote(record->letter())));
    }
  }

  Lines lines_;
  FaultList faults_;
  House house_;
  std::array<std::uint32_t, kKinds.size()> counts_{};  // by kind
};

}  // namespace

House parse_house(std::string_view text, const std::string& file) {
  return Parser(text, file).parse();
}

std::string to_text(const House& house) {
  RecordWriter writer;
  writer.line("ASCII 1.1");
  writer.line("H");
  writer.name(house.name);
  writer.name(house.label);
  for (const std::size_t k : kHeaderCounts) writer.place(kKinds[k].count(house));
  writer.zeros(5);
  writer.box(house.box);
  writer.zeros(5);
  for (const Kind& kind : kKinds) kind.write(writer, kind.letter, house);
  return writer.take();
}

}  // namespace enfilade::mesh
