// enfilade import: people's own panoramas into a scan, in the layout of Matterport3DSimulator.
#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/file.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/equirectangular.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;
using scan::Connectivity;
using scan::ConnectivityEntry;

constexpr double kSpacing = 2.25;  // metres; the mean length of an edge in R2R's graphs
constexpr std::uint32_t kLargestFace = 8192;
constexpr int kQuality = 95;

struct Arguments {
  std::string scan, output, positions, faces, name, edges;
  std::vector<std::string> pictures;
  std::vector<std::pair<std::string, std::string>> pairs;
  std::uint32_t size = 0;
  std::optional<double> exposure, heading;
  double eye_height = 1.5, reach = 5;
  bool force = false;
};

struct Place {
  Vec3d position;
  std::optional<double> heading;  // degrees
};

// A panorama on its way in.
struct Panorama {
  std::string viewpoint;
  std::vector<std::string> files;  // one, or six by index(CubeFace)
  std::vector<std::uint8_t> strip;
  std::uint32_t size = 0;
};

[[noreturn]] void refuse(const std::string& file, std::string where, std::string code,
                         std::string message) {
  throw InvalidInput(
      {{Severity::kError, file, std::move(where), std::move(code), std::move(message)}});
}

// Ids become parts of file names, and stand between blanks in lists.
bool is_id(std::string_view id) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  return !id.empty() && id.front() != '-' && std::ranges::all_of(id, allowed);
}

void check_id(std::string_view what, const std::string& id, std::string_view advice) {
  if (is_id(id)) return;
  throw UsageError(
      fmt::format("{} {:?}: letters, digits, _ and - are allowed{}", what, id, advice));
}

// --- where the panoramas were taken ----------------------------------------------------------

std::optional<double> number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc() || stop != end || !(std::abs(value) < 1e6)) return std::nullopt;
  return value;
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

// Lines of "name x y z [heading]", blanks or commas between; # begins a comment, and a first line
// that begins with "name" is a table's head.
std::map<std::string, Place> load_places(const std::string& file) {
  std::map<std::string, Place> places;
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

image::CubeMap<std::uint8_t> cut_panorama(const std::string& file, const Arguments& a) {
  const image::Image8 picture = image::load_picture(file, a.exposure);
  const std::int64_t excess = std::int64_t{picture.width} - 2 * std::int64_t{picture.height};
  if (std::abs(excess) > 1 || picture.width < 4) {
    refuse(file, "", "not-equirectangular",
           fmt::format("{} x {} pixels, not twice as wide as high: no panorama of all directions",
                       picture.width, picture.height));
  }
  const std::uint32_t size =
      a.size > 0 ? a.size : std::min(1024U, rounded_to_blocks(picture.width / 4));
  return cube_from_equirectangular(picture, size);
}

image::Image8 half_turn(const image::Image8& picture) {
  image::Image8 turned = picture;
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < picture.width; ++x) {
      std::copy_n(picture.at(x, y), picture.channels,
                  turned.at(picture.width - 1 - x, picture.height - 1 - y));
    }
  }
  return turned;
}

image::CubeMap<std::uint8_t> load_faces(const std::vector<std::string>& files, const Arguments& a) {
  image::CubeMap<std::uint8_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = image::load_picture(files[k], a.exposure);
    const std::uint32_t width = faces[k].width, height = faces[k].height;
    if (width != height || width != faces[0].width || width < a.size) {
      const std::string wanted = k == 0 ? "" : fmt::format(" like {}", files[0]);
      refuse(files[k], "", "bad-face",
             fmt::format("{} x {} pixels; a face has to be square{}{}", width, height, wanted,
                         a.size == 0 ? "" : fmt::format(", and of --size {} at least", a.size)));
    }
  }
  const std::uint32_t size =
      a.size > 0 ? a.size : std::min(1024U, rounded_to_blocks(faces[0].width));
  for (image::Image8& face : faces) face = image::shrink(face, size, size);
  // Everyone else's top and bottom are seen by turning up or down from the front, Matterport3D's
  // from the back.
  for (const CubeFace face : {CubeFace::kUp, CubeFace::kDown}) {
    faces[index(face)] = half_turn(faces[index(face)]);
  }
  return faces;
}

void make_strip(Panorama& panorama, const Arguments& a) {
  const auto faces = panorama.files.size() == 1 ? cut_panorama(panorama.files[0], a)
                                                : load_faces(panorama.files, a);
  panorama.size = faces[0].width;
  panorama.strip = image::encode_jpeg(join_strip(faces), kQuality, true);
}

// --- what to do ------------------------------------------------------------------------------

// --faces: six pictures in an order such as "frblud", by index(CubeFace).
std::vector<std::string> sort_faces(const Arguments& a) {
  constexpr std::string_view kLetters = "ublfrd";  // by index(CubeFace)
  if (!std::ranges::is_permutation(a.faces, kLetters)) {
    throw UsageError(fmt::format(
        "--faces {:?}: each of f r b l u d (front right back left up down) is wanted once",
        a.faces));
  }
  if (a.pictures.size() != kCubeFaces || a.name.empty()) {
    throw UsageError(
        fmt::format("--faces: {} pictures{}; it takes the six of one panorama and its "
                    "--name",
                    a.pictures.size(), a.name.empty() ? " and no --name" : ""));
  }
  std::vector<std::string> files;
  for (const char letter : kLetters) files.push_back(a.pictures[a.faces.find(letter)]);
  return files;
}

std::vector<Panorama> list_panoramas(const Arguments& a) {
  std::vector<Panorama> panoramas;
  if (!a.faces.empty()) {
    panoramas.push_back({a.name, sort_faces(a), {}, 0});
  } else if (!a.name.empty() && a.pictures.size() != 1) {
    throw UsageError(fmt::format("--name: for one panorama, not {}", a.pictures.size()));
  } else {
    for (const std::string& file : a.pictures) {
      panoramas.push_back(
          {a.name.empty() ? fs::path(file).stem().string() : a.name, {file}, {}, 0});
    }
  }
  std::set<std::string> seen;
  for (const Panorama& panorama : panoramas) {
    check_id("viewpoint", panorama.viewpoint,
             "; it is the picture's name without its suffix: rename that, or give --name");
    if (!seen.insert(panorama.viewpoint).second) {
      throw UsageError(
          fmt::format("viewpoint {:?}: two of the pictures have that name", panorama.viewpoint));
    }
  }
  return panoramas;
}

// The scan's graph as it is, empty if it is a new one.
Connectivity load_or_begin(const Arguments& a) {
  const fs::path folder = fs::path(a.output) / "connectivity";
  const fs::path file = scan::connectivity_file(folder, a.scan);
  if (fs::exists(file)) return scan::load_connectivity(folder, a.scan);
  return {a.scan, file.string(), {}};
}

std::optional<ViewpointIndex> find(const Connectivity& graph, const std::string& viewpoint) {
  const auto at = std::ranges::find(graph.entries, viewpoint, &ConnectivityEntry::id);
  if (at == graph.entries.end()) return std::nullopt;
  return ViewpointIndex(static_cast<std::size_t>(at - graph.entries.begin()));
}

std::array<double, 16> pose_of(Vec3d p, double heading) {
  const Mat3d r = world_from_camera(degrees(heading), Radians(0));
  return {r.m[0], r.m[1], r.m[2], p.x, r.m[3], r.m[4], r.m[5], p.y,
          r.m[6], r.m[7], r.m[8], p.z, 0,      0,      0,      1};
}

// Adds the panorama's entry, or changes what is given of the one that is there.
ViewpointIndex place(const Panorama& panorama, const Arguments& a,
                     const std::map<std::string, Place>& places, Connectivity& graph) {
  const auto known = find(graph, panorama.viewpoint);
  if (!known) {
    graph.entries.emplace_back();
    graph.entries.back().id = panorama.viewpoint;
  }
  const std::size_t at = known ? known->at() : graph.entries.size() - 1;
  ConnectivityEntry& entry = graph.entries[at];
  if (!a.positions.empty()) {
    const auto given = places.find(panorama.viewpoint);
    if (given == places.end()) {
      throw LookupError(
          fmt::format("{}: has no position of viewpoint {:?}", a.positions, panorama.viewpoint));
    }
    const Place& here = given->second;
    entry.pose = pose_of(here.position, here.heading.value_or(a.heading.value_or(0)));
  } else if (!known) {
    entry.pose =
        pose_of({kSpacing * static_cast<double>(at), 0, a.eye_height}, a.heading.value_or(0));
  } else if (a.heading) {
    entry.pose = pose_of(entry.position(), *a.heading);
  }
  entry.included = true;
  entry.height = a.eye_height;
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

void connect_all(const Arguments& a, const std::vector<ViewpointIndex>& fresh,
                 Connectivity& graph) {
  if (a.edges == "near") connect_near(fresh, a.reach, graph);
  if (a.edges == "line") {
    for (const ViewpointIndex v : fresh) {
      if (v.at() > 0) connect(ViewpointIndex(v.at() - 1), v, graph);
    }
  }
  for (const auto& [from, to] : a.pairs) {
    const auto v = find(graph, from), w = find(graph, to);
    if (!v || !w || v == w) {
      throw UsageError(
          fmt::format("--edge {} {}: names no two viewpoints of scan {}", from, to, graph.scan));
    }
    connect(*v, *w, graph);
  }
}

void list_scan(const fs::path& connectivity, const std::string& scan) {
  const fs::path file = connectivity / "scans.txt";
  std::string content = fs::exists(file) ? read_file(file) : "";
  std::istringstream words(content);
  for (std::string word; words >> word;) {
    if (word == scan) return;
  }
  if (!content.empty() && content.back() != '\n') content += '\n';
  write_file_atomically(file, content + scan + "\n");
}

// Pictures first: a graph never names a panorama that is not there.
void write(const Arguments& a, const std::vector<Panorama>& panoramas, const Connectivity& graph) {
  const fs::path images = fs::path(a.output) / a.scan / "matterport_skybox_images";
  const fs::path connectivity = fs::path(a.output) / "connectivity";
  make_folder(images);
  make_folder(connectivity);
  for (const Panorama& panorama : panoramas) {
    write_file_atomically(
        images / (panorama.viewpoint + "_skybox_small.jpg"),
        {reinterpret_cast<const char*>(panorama.strip.data()), panorama.strip.size()});
  }
  write_file_atomically(scan::connectivity_file(connectivity, a.scan), to_json(graph));
  list_scan(connectivity, a.scan);
}

void report(const Arguments& a, const std::vector<Panorama>& panoramas, const Connectivity& graph,
            std::size_t known) {
  for (const Panorama& panorama : panoramas) {
    const Vec3d p = graph.entries[find(graph, panorama.viewpoint)->at()].position();
    fmt::print("{}: faces of {} pixels, at ({:.2f}, {:.2f}, {:.2f}) m\n", panorama.viewpoint,
               panorama.size, p.x, p.y, p.z);
  }
  std::size_t ends = 0;
  for (const ConnectivityEntry& entry : graph.entries) ends += entry.unobstructed.size();
  fmt::print("{}: scan {}: {} imported; viewpoints now: {}; edges: {}\n", a.output, a.scan,
             panoramas.size(), graph.entries.size(), ends / 2);
  if (a.positions.empty() && graph.entries.size() > known) {
    fmt::print(
        "Where they were taken is not known (--positions): they stand in a line, {} m "
        "apart.\n",
        kSpacing);
  }
}

void check(const Arguments& a, const Connectivity& graph, const std::vector<Panorama>& panoramas) {
  if (a.size > kLargestFace) {
    throw UsageError(fmt::format("--size {}: at most {} pixels are allowed", a.size, kLargestFace));
  }
  if (a.force) return;
  for (const Panorama& panorama : panoramas) {
    if (!find(graph, panorama.viewpoint)) continue;
    throw UsageError(fmt::format("viewpoint {:?} is in scan {} already ({}); --force replaces it",
                                 panorama.viewpoint, a.scan, graph.file));
  }
}

void import_scan(Arguments a) {
  check_id("scan", a.scan, "");
  std::vector<Panorama> panoramas = list_panoramas(a);
  Connectivity graph = load_or_begin(a);
  check(a, graph, panoramas);
  const std::size_t known = graph.entries.size();
  const auto places =
      a.positions.empty() ? std::map<std::string, Place>{} : load_places(a.positions);
  std::vector<ViewpointIndex> fresh;
  for (const Panorama& panorama : panoramas) fresh.push_back(place(panorama, a, places, graph));
  if (a.edges.empty()) a.edges = !a.pairs.empty() ? "none" : a.positions.empty() ? "line" : "near";
  connect_all(a, fresh, graph);
  // All of them before the first is written: a broken picture leaves the scan as it was.
  const Progress progress = progress_bar("importing");
  for (std::size_t k = 0; k < panoramas.size(); ++k) {
    if (progress) progress(k, panoramas.size());
    make_strip(panoramas[k], a);
  }
  if (progress) progress(panoramas.size(), panoramas.size());
  write(a, panoramas, graph);
  report(a, panoramas, graph, known);
}

void add_picture_options(CLI::App& verb, Arguments& a) {
  verb.add_option("pictures", a.pictures,
                  "Equirectangular panoramas: JPEG, PNG or Radiance HDR. A file's name without its "
                  "suffix becomes the viewpoint's id")
      ->required()
      ->type_name("PICTURE");
  verb.add_option("--scan", a.scan, "Name of the building; a new one, or one to add to")
      ->required()
      ->type_name("NAME");
  verb.add_option("-o,--output", a.output, "Folder that the scan is written to")
      ->required()
      ->type_name("DIR");
  verb.add_option("--name", a.name, "Id of the viewpoint, if there is one panorama")
      ->type_name("ID");
  verb.add_option(
          "--faces", a.faces,
          "The pictures are the six faces of one panorama, in this order: letters of front, "
          "right, back, left, up, down, such as frblud. Up and down as seen when one turns "
          "up or down from the front")
      ->type_name("ORDER");
  verb.add_option("--size", a.size,
                  "Edge of a face, pixels (default: the picture's resolution, at most 1024)")
      ->check(whole_number(1))
      ->type_name("N");
  verb.add_option("--exposure", a.exposure,
                  "Of HDR pictures, stops: light is multiplied by 2^EV (default: for each picture "
                  "so that its median is mid-grey)")
      ->check(finite_number(-64))
      ->type_name("EV");
  verb.add_flag("--force", a.force, "Replace viewpoints that are there already");
}

void add_graph_options(CLI::App& verb, Arguments& a) {
  verb.add_option("--heading", a.heading,
                  "Heading of the pictures' middles (front faces), degrees clockwise from north "
                  "(default: 0)")
      ->check(finite_number(-360))
      ->type_name("DEG");
  verb.add_option(
          "--positions", a.positions,
          "Text or CSV file of lines \"name x y z [heading]\": the eye in metres, x east, y "
          "north, z up, and degrees (default: a line of viewpoints 2.25 m apart)")
      ->type_name("FILE");
  verb.add_option("--eye-height", a.eye_height, "Height of the eye above the floor, metres")
      ->check(finite_number())
      ->capture_default_str()
      ->type_name("M");
  verb.add_option("--edges", a.edges,
                  "Which viewpoints to connect: near (each two within --reach; default "
                  "with --positions), line (from each to the next; default without), none (default "
                  "with --edge)")
      ->check(CLI::IsMember({"near", "line", "none"}));
  verb.add_option("--reach", a.reach, "Longest edge of --edges near, metres")
      ->check(finite_number())
      ->capture_default_str()
      ->type_name("M");
  verb.add_option("--edge", a.pairs, "Add an edge between these two viewpoints; may be repeated")
      ->allow_extra_args(false)
      ->type_name("A B");
}

}  // namespace

void add_import(CLI::App& app, int& status) {
  CLI::App& verb =
      *app.add_subcommand("import",
                          "Make a scan from your own panoramas, in Matterport3DSimulator's files: "
                          "DIR/NAME/matterport_skybox_images/ID_skybox_small.jpg and "
                          "DIR/connectivity/NAME_connectivity.json");
  const auto arguments = std::make_shared<Arguments>();
  add_picture_options(verb, *arguments);
  add_graph_options(verb, *arguments);
  set_examples(verb,
               {"enfilade import --scan myhouse -o my-data kitchen.jpg hall.hdr",
                "enfilade import --scan myhouse -o my-data *.jpg --positions tripod.csv",
                "enfilade import --scan myhouse -o my-data *.jpg --edge kitchen hall --edge hall "
                "porch",
                "enfilade import --scan myhouse -o my-data --name attic --faces frblud "
                "attic_0.png attic_1.png attic_2.png attic_3.png attic_4.png attic_5.png"});
  verb.callback([arguments, &status] {
    import_scan(*arguments);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
