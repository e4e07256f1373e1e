#include "enfilade/capture/import_panoramas.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/image.h"
#include "enfilade/image/photo.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/matterport_images.h"

namespace enfilade::capture {
namespace {

namespace fs = std::filesystem;
using scan::Connectivity;
using scan::ConnectivityEntry;

constexpr int kQuality = 95;

struct Place {
  Vec3d position;
  std::optional<double> heading;  // degrees
};
using Places = std::map<std::string, Place>;

struct Strip {
  std::vector<std::uint8_t> jpeg;
  std::uint32_t face_size = 0;
  std::optional<double> heading;  // degrees, as the picture's file says
  std::vector<Diagnostic> findings;
};

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// --- where the panoramas were taken ----------------------------------------------------------

std::optional<double> number(const std::string& text) {
  const auto value = parse_number<double>(text);
  return value && std::abs(*value) < 1e6 ? value : std::nullopt;
}

Place parse_place(const std::vector<std::string>& words, const std::string& file,
                  const std::string& where) {
  if (words.size() != 4 && words.size() != 5) {
    const bool commas = words.size() == 7 || words.size() == 9;  // 1,5 taken for two numbers
    refuse(file, where, "bad-position",
           fmt::format("{} values, not 4 or 5: name x y z [heading]{}", words.size(),
                       commas ? "; decimal commas need semicolons between values" : ""));
  }
  if (words[0].empty()) refuse(file, where, "bad-position", "no name before x y z");
  std::array<double, 4> values{};
  for (std::size_t k = 1; k < words.size(); ++k) {
    const auto value = number(words[k]);
    if (!value) {
      refuse(file, where, "bad-position",
             fmt::format("{:?} is not a number of metres or degrees", words[k].substr(0, 40)));
    }
    values[k - 1] = *value;
  }
  Place place{{values[0], values[1], values[2]}, std::nullopt};
  if (words.size() == 5) place.heading = values[3];
  return place;
}

// The id that a name in a list stands for: without folder and a picture's suffix.
std::string id_of(const std::string& name) {
  std::string last = name.substr(name.find_last_of("/\\") + 1);  // npos + 1 is 0
  const std::size_t dot = last.rfind('.');
  if (dot == std::string::npos || dot == 0) return last;
  std::string suffix = last.substr(dot + 1);
  std::ranges::transform(suffix, suffix.begin(), lower);
  constexpr std::array kSuffixes{"jpg", "jpeg", "png", "hdr", "insp", "tif", "tiff"};
  return std::ranges::find(kSuffixes, suffix) == kSuffixes.end() ? last : last.substr(0, dot);
}

// A line's values; empty cells at its end are left out. Between semicolons or tabs, commas are
// decimal ones.
std::vector<std::string> split_line(std::string_view line) {
  const bool semicolons = line.find(';') != std::string::npos;
  const bool tabs = line.find('\t') != std::string::npos && line.find(", ") == std::string::npos &&
                    line.find(",\t") == std::string::npos;
  const bool decimal_commas = semicolons || tabs;
  const auto is_separator = [&](char c) {
    return c == ';' || c == '\t' || c == '\r' || (!semicolons && c == ' ') ||
           (!decimal_commas && c == ',');
  };
  struct Word {
    std::string text;
    bool cell = true;  // stands after a separator that is no blank
  };
  std::vector<Word> parts(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && is_separator(c)) {
      parts.push_back({"", c != ' ' && c != '\r'});
    } else {
      parts.back().text += c;
    }
  }
  std::vector<std::string> words;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::string_view word = trimmed(parts[k].text);
    const bool blank_follows = k + 1 < parts.size() && !parts[k + 1].cell;
    if (word.empty() && blank_follows) {
      parts[k + 1].cell = parts[k].cell;  // the blanks go with the separator before them
    } else if (!word.empty() || parts[k].cell) {
      words.emplace_back(word);
    }
  }
  while (!words.empty() && words.back().empty()) words.pop_back();
  // Not in the name.
  for (std::size_t k = 1; decimal_commas && k < words.size(); ++k) {
    if (std::ranges::count(words[k], ',') == 1) std::ranges::replace(words[k], ',', '.');
  }
  return words;
}

// "name x y z", "Filename;X;Y;Z", ...: no number beyond the first column.
bool is_header(const std::vector<std::string>& words) {
  return std::none_of(words.begin() + 1, words.end(),
                      [](const std::string& word) { return number(word).has_value(); }) &&
         (words.size() >= 4 || std::ranges::equal(words[0], std::string_view("name"), {}, lower));
}

// The columns x, y, z, where a header names them so, have to be in that order.
void check_header(const std::vector<std::string>& words, const std::string& file,
                  const std::string& where) {
  std::string axes;  // h: the heading, which comes last
  for (const std::string& word : words) {
    const char axis = lower(word.empty() ? ' ' : word[0]);
    const bool heading = axis == 'h' && word.size() > 3 && lower(word[1]) == 'e';
    if (heading || (word.size() == 1 && axis >= 'x' && axis <= 'z')) axes += axis;
  }
  if (axes.size() < 3 || axes.starts_with("xyz")) return;
  refuse(file, where, "bad-position",
         fmt::format("columns \"{}\"; the order is: name x y z [heading]", fmt::join(words, " ")));
}

Places load_places(const fs::path& path) {
  const std::string file = path.string();
  const std::string text = read_plain_text(path);
  Places places;
  std::size_t count = 0;
  bool first = true;
  for (const std::string_view line : all_lines(text)) {
    const std::string where = fmt::format("line {}", ++count);
    const std::vector<std::string> words = split_line(line.substr(0, line.find('#')));
    if (words.empty()) continue;
    const bool header = first && is_header(words);
    first = false;
    if (header) {
      check_header(words, file, where);
    } else if (!places.emplace(id_of(words[0]), parse_place(words, file, where)).second) {
      refuse(file, where, "repeated-position",
             fmt::format("{:?} has a position already", id_of(words[0]).substr(0, 40)));
    }
  }
  return places;
}

// --- pictures to strips ----------------------------------------------------------------------

// A whole number of JPEG blocks, so that a strip can be cut into faces without loss.
std::uint32_t rounded_to_blocks(std::uint32_t size) { return size < 16 ? size : size / 16 * 16; }

// Pixels that are kept of a picture: what cameras write, and two for a texel of larger faces. A
// sphere is 4 x 2 faces.
std::uint64_t most_pixels(const ImportOptions& o) {
  constexpr std::uint64_t kFaces = 4 * 2, kPixelsOfATexel = 2 * 2;
  return std::max(image::kMostPhotoPixels,
                  kFaces * kPixelsOfATexel * o.face_size * std::uint64_t{o.face_size});
}

bool is_sphere(std::uint32_t width, std::uint32_t height) {
  return std::abs(std::int64_t{width} - 2 * std::int64_t{height}) <= 1 && width >= 4;
}

void add_finding(std::vector<Diagnostic>& findings, Severity severity, const std::string& file,
                 std::string code, std::string message) {
  findings.push_back({severity, file, "", std::move(code), std::move(message)});
}

// The whole sphere's picture of a part of one: black where there is none. The part may be a smaller
// copy of the one that GPano's fields describe, and becomes one if the sphere has more than `most`
// pixels. No value if the fields are no part of a sphere.
std::optional<image::Image8> whole_sphere(const image::Image8& part,
                                          const image::SphereNotes::Crop& crop,
                                          std::uint64_t most) {
  const double scale = part.width / crop.width;
  constexpr double kRounding = 2;  // pixels: sizes were rounded, perhaps twice
  if (std::abs(part.height - scale * crop.height) > kRounding ||
      std::abs(crop.full_width - 2 * crop.full_height) > kRounding || crop.left > crop.full_width ||
      crop.top + crop.height > crop.full_height + kRounding ||
      crop.width > crop.full_width + kRounding) {
    return std::nullopt;
  }
  const double rows = std::round(scale * crop.full_height);
  if (rows < 2 || 2 * rows > image::kLongestEdge || 2 * rows * rows > image::kMostPixels) {
    return std::nullopt;
  }
  if (2 * rows * rows > static_cast<double>(most)) {
    if (part.width == 1) return std::nullopt;  // has no smaller copy
    return whole_sphere(shrink(part, image::halved(part.width, 1), image::halved(part.height, 1)),
                        crop, most);
  }
  const auto height = static_cast<std::uint32_t>(rows);
  image::Image8 whole(2 * height, height, 3);
  const auto left = static_cast<std::size_t>(std::lround(scale * crop.left));
  const auto top = static_cast<std::size_t>(std::lround(scale * crop.top));
  for (std::size_t y = 0; y < part.height && top + y < whole.height; ++y) {
    for (std::size_t x = 0; x < std::min(part.width, whole.width); ++x) {
      std::ranges::copy_n(part.at(x, y), 3, whole.at((left + x) % whole.width, top + y));
    }
  }
  return whole;
}

// The picture of all directions.
image::Image8 sphere_of(image::Photo& photo, const std::string& file, std::uint64_t most,
                        std::vector<Diagnostic>& findings) {
  image::Image8& picture = photo.picture;
  const auto& crop = photo.sphere.crop;
  std::string why;
  if (crop && crop->is_part()) {
    if (auto whole = whole_sphere(picture, *crop, most)) {
      add_finding(findings, Severity::kWarning, file, "cropped-sphere",
                  fmt::format("GPano: {:.0f} x {:.0f} of {:.0f} x {:.0f} pixels, {:.0f} x {:.0f} "
                              "degrees; other directions are black",
                              crop->width, crop->height, crop->full_width, crop->full_height,
                              360 * crop->width / crop->full_width,
                              180 * crop->height / crop->full_height));
      return std::move(*whole);
    }
    why = fmt::format("; a crop of {:.0f} x {:.0f} of {:.0f} x {:.0f} pixels (GPano) does not fit",
                      crop->width, crop->height, crop->full_width, crop->full_height);
  }
  if (!is_sphere(photo.stored_width, photo.stored_height)) {
    if (why.empty() && photo.orientation >= 5) {
      why = fmt::format("; it was turned by EXIF orientation {}", photo.orientation);
    }
    refuse(file, "", "not-equirectangular",
           fmt::format("{} x {} pixels, not twice as wide as high: no panorama of all directions{}",
                       photo.stored_width, photo.stored_height, why));
  }
  if (!why.empty()) {
    add_finding(findings, Severity::kWarning, file, "bad-sphere",
                "the whole sphere is taken" + why);
  }
  return std::move(picture);
}

image::CubeMap<std::uint8_t> cut_panorama(const std::string& file, const ImportOptions& o,
                                          Strip& strip) {
  const std::uint64_t most = most_pixels(o);
  image::Photo photo = image::load_photo(file, o.exposure, most);
  strip.findings = std::move(photo.findings);
  std::vector<Diagnostic>& findings = strip.findings;
  const image::SphereNotes& notes = photo.sphere;
  const image::Image8 sphere = sphere_of(photo, file, most, findings);
  std::string kind = notes.projection;
  std::ranges::transform(kind, kind.begin(), lower);
  if (!kind.empty() && kind != "equirectangular") {
    add_finding(findings, Severity::kWarning, file, "unknown-projection",
                fmt::format("GPano: {:?}; taken as equirectangular", kind.substr(0, 40)));
  }
  if (o.use_pose) strip.heading = notes.heading;
  const bool tilted = o.use_pose && !notes.is_level();
  if (tilted) {
    add_finding(
        findings, Severity::kNote, file, "levelled",
        fmt::format("GPano: pitch {:g}, roll {:g} degrees: undone", notes.pitch, notes.roll));
  }
  const std::uint32_t size =
      o.face_size > 0 ? o.face_size : std::min(1024U, rounded_to_blocks(sphere.width / 4));
  return cube_from_equirectangular(sphere, size, Radians(0), 0,
                                   tilted ? level_from_picture(notes) : Mat3d());
}

image::CubeMap<std::uint8_t> load_faces(const std::vector<std::string>& files,
                                        const ImportOptions& o, Strip& strip) {
  image::CubeMap<std::uint8_t> faces;
  std::uint32_t first = 0, size = o.face_size;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    image::Photo photo = image::load_photo(files[k], o.exposure, most_pixels(o));
    std::ranges::move(photo.findings, std::back_inserter(strip.findings));
    const std::uint32_t width = photo.stored_width, height = photo.stored_height;
    if (k == 0) first = width;
    if (width != height || width != first || width < o.face_size) {
      const std::string wanted = k == 0 ? "" : fmt::format(" like {}", files[0]);
      refuse(files[k], "", "bad-face",
             fmt::format(
                 "{} x {} pixels; a face has to be square{}{}", width, height, wanted,
                 o.face_size == 0 ? "" : fmt::format(", and of size {} at least", o.face_size)));
    }
    if (size == 0) size = std::min(1024U, rounded_to_blocks(width));
    faces[k] = image::shrink(photo.picture, size, size);  // before the next one is read
  }
  // Usually the top and bottom faces are seen by turning up or down from the front; Matterport3D's
  // are seen from the back.
  for (const CubeFace face : {CubeFace::kUp, CubeFace::kDown}) {
    faces[index(face)] = half_turn(faces[index(face)]);
  }
  return faces;
}

Strip make_strip(const PanoramaFiles& panorama, const ImportOptions& o) {
  Strip strip;
  const auto faces = panorama.files.size() == 1 ? cut_panorama(panorama.files[0], o, strip)
                                                : load_faces(panorama.files, o, strip);
  strip.jpeg = image::encode_jpeg(join_strip(faces), kQuality, true);
  strip.face_size = faces[0].width;
  return strip;
}

// --- the graph -------------------------------------------------------------------------------

// The scan's graph; an empty one for a new scan.
Connectivity load_or_begin(const fs::path& folder, const std::string& scan) {
  if (scan::find_connectivity(folder, scan)) return scan::load_connectivity(folder, scan);
  return {scan, scan::connectivity_file(folder, scan).string(), {}};
}

std::optional<ViewpointIndex> find(const Connectivity& graph, const std::string& viewpoint) {
  const auto at = std::ranges::find(graph.entries, viewpoint, &ConnectivityEntry::id);
  if (at == graph.entries.end()) return std::nullopt;
  return ViewpointIndex(static_cast<std::size_t>(at - graph.entries.begin()));
}

std::array<double, 16> pose_of(Vec3d p, double heading) {
  return pose_matrix(world_from_camera(degrees(heading), Radians(0)), p);
}

struct Placed {
  ViewpointIndex viewpoint;
  bool headed = false;  // its heading was given, or is an existing viewpoint's
};

// Adds the panorama's entry, or updates an existing one.
Placed place(const PanoramaFiles& panorama, const ImportOptions& o, const Places& places,
             Connectivity& graph) {
  const auto known = find(graph, panorama.viewpoint);
  if (!known) {
    graph.entries.emplace_back();
    graph.entries.back().id = panorama.viewpoint;
  }
  const std::size_t at = known ? known->at() : graph.entries.size() - 1;
  ConnectivityEntry& entry = graph.entries[at];
  bool headed = o.heading || (known && o.positions.empty());
  if (!o.positions.empty()) {
    const auto given = places.find(panorama.viewpoint);
    if (given == places.end()) {
      throw LookupError(fmt::format("{}: has no position of viewpoint {:?}", o.positions.string(),
                                    panorama.viewpoint));
    }
    const Place& here = given->second;
    headed = headed || here.heading;
    entry.pose = pose_of(here.position, here.heading.value_or(o.heading.value_or(0)));
  } else if (!known) {
    entry.pose =
        pose_of({kImportSpacing * static_cast<double>(at), 0, o.eye_height}, o.heading.value_or(0));
  } else if (o.heading) {
    entry.pose = pose_of(entry.position(), *o.heading);
  }
  entry.included = true;
  entry.height = o.eye_height;
  return {ViewpointIndex(at), headed};
}

void connect(ViewpointIndex from, ViewpointIndex to, Connectivity& graph) {
  const auto add = [](std::vector<ViewpointIndex>& places, ViewpointIndex v) {
    if (std::ranges::find(places, v) == places.end()) places.push_back(v);
    std::ranges::sort(places);
  };
  for (const auto& [a, b] : {std::pair(from, to), std::pair(to, from)}) {
    add(graph.entries[a.at()].unobstructed, b);
    add(graph.entries[a.at()].visible, b);
  }
}

void connect_all(const ImportOptions& o, const std::vector<ViewpointIndex>& fresh,
                 Connectivity& graph) {
  for (const ViewpointIndex v : fresh) {
    if (o.edges == ImportEdges::kLine && v.at() > 0) connect(ViewpointIndex(v.at() - 1), v, graph);
    if (o.edges != ImportEdges::kNear) continue;
    for (std::size_t w = 0; w < graph.entries.size(); ++w) {
      const Vec3d step = graph.entries[w].position() - graph.entries[v.at()].position();
      const bool near = std::hypot(step.x, step.y, step.z) <= o.reach;
      if (near && w != v.at() && graph.entries[w].included) connect(v, ViewpointIndex(w), graph);
    }
  }
  for (const auto& [from, to] : o.pairs) {
    const auto v = find(graph, from), w = find(graph, to);
    if (!v || !w || v == w) {
      throw ArgumentError(
          fmt::format("edge {} {}: names no two viewpoints of scan {}", from, to, graph.scan));
    }
    connect(*v, *w, graph);
  }
}

// --- files -----------------------------------------------------------------------------------

// Pictures first, so that a graph never names a panorama that is missing.
void write(const fs::path& folder, std::span<const PanoramaFiles> panoramas,
           const std::vector<Strip>& strips, const Connectivity& graph) {
  const OutputFolder out(folder);
  const std::string images = graph.scan + "/matterport_skybox_images/";
  out.remove_unfinished(graph.scan + "/matterport_skybox_images", ".jpg");
  for (const char* ending : {".json", "scans.txt"}) out.remove_unfinished("connectivity", ending);
  for (std::size_t k = 0; k < strips.size(); ++k) {
    const std::vector<std::uint8_t>& jpeg = strips[k].jpeg;
    out.write(images + scan::skybox_strip_name(panoramas[k].viewpoint, scan::Layer::kColour),
              {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  }
  save_connectivity(out.folder("connectivity"), graph);
}

void check(std::span<const PanoramaFiles> panoramas, const ImportOptions& o,
           const Connectivity& graph) {
  check_range("face_size", o.face_size, 0, kLargestImportedFace);
  std::set<std::string> seen;
  for (const PanoramaFiles& panorama : panoramas) {
    const std::string& id = panorama.viewpoint;
    if (!is_id(id)) throw ArgumentError(fmt::format("viewpoint {}", fault_of_id(id)));
    if (panorama.files.size() != 1 && panorama.files.size() != kCubeFaces) {
      throw ArgumentError(
          fmt::format("viewpoint {:?}: {} pictures, not 1 or 6", id, panorama.files.size()));
    }
    if (!seen.insert(id).second) {
      throw ArgumentError(fmt::format("viewpoint {:?}: two of the pictures have that name", id));
    }
    if (!o.force && find(graph, id)) {
      throw ArgumentError(
          fmt::format("viewpoint {:?} is in scan {} already ({}); force replaces it", id,
                      graph.scan, graph.file));
    }
  }
}

// Files of later steps name a viewpoint "<scan>_<viewpoint>".
void add_note_on_ids(std::span<const PanoramaFiles> panoramas, const Connectivity& graph,
                     std::vector<Diagnostic>& findings) {
  const auto has_bar = [](const PanoramaFiles& one) {
    return one.viewpoint.find('_') != std::string::npos;
  };
  const auto count = std::ranges::count_if(panoramas, has_bar);
  if (count == 0) return;
  const std::string& id = std::ranges::find_if(panoramas, has_bar)->viewpoint;
  std::string better = id;
  std::ranges::replace(better, '_', '-');
  add_finding(
      findings, Severity::kNote, graph.file, "id-with-bar",
      fmt::format("ids with \"_\": {}, the first {:?}: programs of others may cut names there; "
                  "{:?} is safe",
                  count, id, better));
}

}  // namespace

ImportReport import_panoramas(const fs::path& folder, const std::string& scan,
                              std::span<const PanoramaFiles> panoramas,
                              const ImportOptions& options, const Progress& progress) {
  scan::require_scan_id(scan);
  scan::check_scan_list(folder / "connectivity");  // now, as the pictures are written first
  Connectivity graph = load_or_begin(folder / "connectivity", scan);
  check(panoramas, options, graph);
  const std::size_t known = graph.entries.size();
  const Places places = options.positions.empty() ? Places{} : load_places(options.positions);
  std::vector<ViewpointIndex> fresh;
  std::vector<bool> headed;
  for (const PanoramaFiles& panorama : panoramas) {
    const Placed placed = place(panorama, options, places, graph);
    fresh.push_back(placed.viewpoint);
    headed.push_back(placed.headed);
  }
  connect_all(options, fresh, graph);
  // Encodes all before writing the first: a broken picture leaves the scan unchanged.
  std::vector<Strip> strips;
  for (const PanoramaFiles& panorama : panoramas) {
    if (progress) progress(strips.size(), panoramas.size());
    strips.push_back(make_strip(panorama, options));
    const std::size_t k = strips.size() - 1;
    if (!headed[k] && strips[k].heading) {
      ConnectivityEntry& entry = graph.entries[fresh[k].at()];
      entry.pose = pose_of(entry.position(), *strips[k].heading);
      add_finding(strips[k].findings, Severity::kNote, panorama.files[0], "own-heading",
                  fmt::format("GPano: heading {:g} degrees: applied", *strips[k].heading));
    }
  }
  if (progress) progress(panoramas.size(), panoramas.size());
  write(folder, panoramas, strips, graph);
  ImportReport done;
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    done.panoramas.push_back(
        {panoramas[k].viewpoint, strips[k].face_size, graph.entries[fresh[k].at()].position()});
    std::ranges::move(strips[k].findings, std::back_inserter(done.findings));
  }
  add_note_on_ids(panoramas, graph, done.findings);
  done.viewpoints = graph.entries.size();
  done.added = done.viewpoints - known;
  for (const ConnectivityEntry& entry : graph.entries) done.edges += entry.unobstructed.size();
  done.edges /= 2;
  return done;
}

}  // namespace enfilade::capture
