#include "enfilade/capture/import_panoramas.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/equirectangular.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/matterport_names.h"

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
};

// --- where the panoramas were taken ----------------------------------------------------------

std::optional<double> number(const std::string& text) {
  const auto value = parse_number<double>(text);
  return value && std::abs(*value) < 1e6 ? value : std::nullopt;
}

Place parse_place(const std::vector<std::string>& words, const std::string& file,
                  const std::string& where) {
  if (words.size() != 4 && words.size() != 5) {
    refuse(file, where, "bad-position",
           fmt::format("{} values, not 4 or 5: name x y z [heading]", words.size()));
  }
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

Places load_places(const fs::path& path) {
  const std::string file = path.string();
  Places places;
  std::istringstream lines(read_file(file));
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::string where = fmt::format("line {}", ++count);
    line.resize(std::min(line.find('#'), line.size()));
    std::ranges::replace(line, ',', ' ');
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (words.empty() || (places.empty() && words[0] == "name")) continue;
    if (!places.emplace(words[0], parse_place(words, file, where)).second) {
      refuse(file, where, "repeated-position",
             fmt::format("{:?} has a position already", words[0].substr(0, 40)));
    }
  }
  return places;
}

// --- pictures to strips ----------------------------------------------------------------------

// A whole number of JPEG blocks, so that a strip can be cut into faces without loss.
std::uint32_t rounded_to_blocks(std::uint32_t size) { return size < 16 ? size : size / 16 * 16; }

image::CubeMap<std::uint8_t> cut_panorama(const std::string& file, const ImportOptions& o) {
  const image::Image8 picture = image::load_picture(file, o.exposure);
  const std::int64_t excess = std::int64_t{picture.width} - 2 * std::int64_t{picture.height};
  if (std::abs(excess) > 1 || picture.width < 4) {
    refuse(file, "", "not-equirectangular",
           fmt::format("{} x {} pixels, not twice as wide as high: no panorama of all directions",
                       picture.width, picture.height));
  }
  const std::uint32_t size =
      o.face_size > 0 ? o.face_size : std::min(1024U, rounded_to_blocks(picture.width / 4));
  return cube_from_equirectangular(picture, size);
}

image::CubeMap<std::uint8_t> load_faces(const std::vector<std::string>& files,
                                        const ImportOptions& o) {
  image::CubeMap<std::uint8_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = image::load_picture(files[k], o.exposure);
    const std::uint32_t width = faces[k].width, height = faces[k].height;
    if (width != height || width != faces[0].width || width < o.face_size) {
      const std::string wanted = k == 0 ? "" : fmt::format(" like {}", files[0]);
      refuse(files[k], "", "bad-face",
             fmt::format(
                 "{} x {} pixels; a face has to be square{}{}", width, height, wanted,
                 o.face_size == 0 ? "" : fmt::format(", and of size {} at least", o.face_size)));
    }
  }
  const std::uint32_t size =
      o.face_size > 0 ? o.face_size : std::min(1024U, rounded_to_blocks(faces[0].width));
  for (image::Image8& face : faces) face = image::shrink(face, size, size);
  // Usually the top and bottom faces are seen by turning up or down from the front; Matterport3D's
  // are seen from the back.
  for (const CubeFace face : {CubeFace::kUp, CubeFace::kDown}) {
    faces[index(face)] = half_turn(faces[index(face)]);
  }
  return faces;
}

Strip make_strip(const PanoramaFiles& panorama, const ImportOptions& o) {
  const auto faces = panorama.files.size() == 1 ? cut_panorama(panorama.files[0], o)
                                                : load_faces(panorama.files, o);
  return {image::encode_jpeg(join_strip(faces), kQuality, true), faces[0].width};
}

// --- the graph -------------------------------------------------------------------------------

// The scan's graph; an empty one for a new scan.
Connectivity load_or_begin(const fs::path& folder, const std::string& scan) {
  const fs::path file = scan::connectivity_file(folder, scan);
  if (file_exists(file)) return scan::load_connectivity(folder, scan);
  return {scan, file.string(), {}};
}

std::optional<ViewpointIndex> find(const Connectivity& graph, const std::string& viewpoint) {
  const auto at = std::ranges::find(graph.entries, viewpoint, &ConnectivityEntry::id);
  if (at == graph.entries.end()) return std::nullopt;
  return ViewpointIndex(static_cast<std::size_t>(at - graph.entries.begin()));
}

std::array<double, 16> pose_of(Vec3d p, double heading) {
  return pose_matrix(world_from_camera(degrees(heading), Radians(0)), p);
}

// Adds the panorama's entry, or updates an existing one.
ViewpointIndex place(const PanoramaFiles& panorama, const ImportOptions& o, const Places& places,
                     Connectivity& graph) {
  const auto known = find(graph, panorama.viewpoint);
  if (!known) {
    graph.entries.emplace_back();
    graph.entries.back().id = panorama.viewpoint;
  }
  const std::size_t at = known ? known->at() : graph.entries.size() - 1;
  ConnectivityEntry& entry = graph.entries[at];
  if (!o.positions.empty()) {
    const auto given = places.find(panorama.viewpoint);
    if (given == places.end()) {
      throw LookupError(fmt::format("{}: has no position of viewpoint {:?}", o.positions.string(),
                                    panorama.viewpoint));
    }
    const Place& here = given->second;
    entry.pose = pose_of(here.position, here.heading.value_or(o.heading.value_or(0)));
  } else if (!known) {
    entry.pose =
        pose_of({kImportSpacing * static_cast<double>(at), 0, o.eye_height}, o.heading.value_or(0));
  } else if (o.heading) {
    entry.pose = pose_of(entry.position(), *o.heading);
  }
  entry.included = true;
  entry.height = o.eye_height;
  return ViewpointIndex(at);
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

void connect_near(const std::vector<ViewpointIndex>& fresh, double reach, Connectivity& graph) {
  for (const ViewpointIndex v : fresh) {
    for (std::size_t w = 0; w < graph.entries.size(); ++w) {
      const Vec3d step = graph.entries[w].position() - graph.entries[v.at()].position();
      const bool near = std::hypot(step.x, step.y, step.z) <= reach;
      if (near && w != v.at() && graph.entries[w].included) connect(v, ViewpointIndex(w), graph);
    }
  }
}

void connect_all(const ImportOptions& o, const std::vector<ViewpointIndex>& fresh,
                 Connectivity& graph) {
  if (o.edges == ImportEdges::kNear) connect_near(fresh, o.reach, graph);
  if (o.edges == ImportEdges::kLine) {
    for (const ViewpointIndex v : fresh) {
      if (v.at() > 0) connect(ViewpointIndex(v.at() - 1), v, graph);
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
  const fs::path images = folder / graph.scan / "matterport_skybox_images";
  make_folder(images);
  for (std::size_t k = 0; k < strips.size(); ++k) {
    const std::vector<std::uint8_t>& jpeg = strips[k].jpeg;
    write_file_atomically(
        images / scan::skybox_strip_name(panoramas[k].viewpoint, scan::Layer::kColour),
        {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  }
  save_connectivity(folder / "connectivity", graph);
}

void check(std::span<const PanoramaFiles> panoramas, const ImportOptions& o,
           const Connectivity& graph) {
  if (o.face_size > kLargestImportedFace) {
    throw ArgumentError(
        fmt::format("face_size: {}, not from 0 to {}", o.face_size, kLargestImportedFace));
  }
  std::set<std::string> seen;
  for (const PanoramaFiles& panorama : panoramas) {
    const std::string& id = panorama.viewpoint;
    if (!scan::is_scan_id(id)) {
      throw ArgumentError(fmt::format("viewpoint {:?}: letters, digits, _ and - are allowed", id));
    }
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
  for (const PanoramaFiles& panorama : panoramas) {
    fresh.push_back(place(panorama, options, places, graph));
  }
  connect_all(options, fresh, graph);
  // Encodes all before writing the first: a broken picture leaves the scan unchanged.
  std::vector<Strip> strips;
  for (const PanoramaFiles& panorama : panoramas) {
    if (progress) progress(strips.size(), panoramas.size());
    strips.push_back(make_strip(panorama, options));
  }
  if (progress) progress(panoramas.size(), panoramas.size());
  write(folder, panoramas, strips, graph);
  ImportReport report;
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    report.panoramas.push_back(
        {panoramas[k].viewpoint, strips[k].face_size, graph.entries[fresh[k].at()].position()});
  }
  report.viewpoints = graph.entries.size();
  report.added = report.viewpoints - known;
  for (const ConnectivityEntry& entry : graph.entries) report.edges += entry.unobstructed.size();
  report.edges /= 2;
  return report;
}

}  // namespace enfilade::capture
