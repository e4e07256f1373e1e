/// \file  Which objects a viewpoint's pictures show, and where: REVERIE's boxes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::tasks {

/// An object as one viewpoint's pictures show it.
struct ViewedObject {
  std::int64_t id = 0;
  std::string name;  ///< "plant#pot": category, and detail after a number sign.
  /// Views that show it, as MatterSim's viewIndex (0 to 35), in the order of the file.
  std::vector<std::uint8_t> views;
  /// Beside each view, the box in its picture of 640 x 480 pixels and 60 degrees: x, y of the left
  /// top corner, width, height.
  std::vector<std::array<std::int32_t, 4>> boxes;
  bool visible() const noexcept { return !views.empty(); }
  friend bool operator==(const ViewedObject&, const ViewedObject&) = default;
};

/// What people call an object: "plant" of "plant#pot", "wall" of "wall /otherroom".
std::string spoken_name(std::string_view name);
/// Whether people would ask for an object of this name. They do not ask for a part of the building
/// ("door frame", "wall /otherroom", mpcat40's "stairs"), nor by a word that fits anything
/// ("object", "unknown"). Any case; blanks or "_" between words.
bool can_be_asked_for(std::string_view name);

/// The objects around the viewpoints of many scans. Immutable after reading: any thread.
class ObjectBoxes {
 public:
  /// Counts of the boxes, for checks against published counts.
  struct Counts {
    std::size_t viewpoints = 0, without_objects = 0;  ///< of those
    std::size_t objects = 0, without_views = 0;       ///< entries by viewpoint
    std::size_t boxes = 0;
  };

  ObjectBoxes() = default;

  /// One file of all viewpoints. Both usual forms: `{"<scan>_<viewpoint>": {"<viewpoint>":
  /// {"<object>": {...}}}}`, and DUET's and HAMT's `BBoxes.json`, one level less. Either id may
  /// have underscores. The first form tells where the viewpoint's begins; the other is searched by
  /// the whole key. Fields of objects other than `name`, `visible_pos` and `bbox2d` are ignored.
  /// \throws InvalidInput listing its faults with JSON paths:
  /// - not JSON, missing, repeated or wrongly typed fields, other keys, bad ids
  /// - a view beyond 35 or given twice
  /// - a box without four numbers or of negative size, another number of boxes than of views
  static ObjectBoxes parse(std::string_view json, const std::string& file);
  /// A packed or plain file of that kind, or a folder of `<scan>_<viewpoint>.json`, REVERIE's form,
  /// packed (`.json.gz`) or plain. Other names in the folder are read over.
  /// \throws FileError, also for a folder without such files; InvalidInput as above, of all files
  /// in one list, in the order of their names
  static ObjectBoxes load(const std::filesystem::path& file_or_folder);
  /// Adds the objects around one viewpoint.
  /// \throws ArgumentError for a viewpoint that has objects already, and for content that parse()
  /// refuses
  void add(const std::string& scan, const std::string& viewpoint,
           std::vector<ViewedObject> objects);

  /// Those around a viewpoint, in the order of the file; empty for one that is not there. Valid as
  /// long as *this.
  std::span<const ViewedObject> at(std::string_view scan, std::string_view viewpoint) const;
  bool has(std::string_view scan, std::string_view viewpoint) const;
  /// Viewpoints of a scan that see an object, in ascending order of their ids. From keys with
  /// several underscores and no second level, each cut that gives this scan: "a_b_c" may be
  /// viewpoint "b_c" of "a". The scan's graph tells which exist.
  std::vector<std::string> seen_from(std::string_view scan, std::int64_t object) const;
  bool empty() const noexcept { return objects_.empty(); }
  Counts count() const;

  /// As one file, REVERIE's form (`nested`) or DUET's, a viewpoint a line. parse() gets equal boxes
  /// back. \throws ArgumentError for text that is not UTF-8
  std::string to_json(bool nested) const;

 private:
  const std::vector<ViewedObject>* find(std::string_view scan, std::string_view viewpoint) const;
  void insert(std::string_view scan, std::string_view viewpoint, bool is_sure,
              std::vector<ViewedObject> objects);

  // By scan, then by viewpoint.
  std::map<std::string, std::map<std::string, std::vector<ViewedObject>, std::less<>>, std::less<>>
      objects_;
  std::set<std::string, std::less<>> unsure_;  // keys with several places for a cut
};

}  // namespace enfilade::tasks
