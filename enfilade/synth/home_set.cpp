#include "enfilade/synth/home_set.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <memory>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/store.h"
#include "enfilade/synth/built_home.h"
#include "enfilade/synth/detail/home_list.h"
#include "enfilade/synth/home_panoramas.h"

namespace enfilade::synth {
namespace {

namespace fs = std::filesystem;
using detail::HomeList;

constexpr std::string_view kMarker = "# Model homes: a SYNTHETIC data set made by Enfilade\n";
constexpr std::size_t kMostHomes = 10000;
// Changes whenever the same options give other pictures.
constexpr int kGeneration = 1;
// Shares of a home's work, for progress: building and graph, light, pictures.
constexpr std::size_t kUnits = 100, kBuilt = 8, kLit = 28;

struct Preset {
  std::string_view name;
  HomeSetOptions options;
};

const std::array<Preset, 3>& presets() {
  static const std::array<Preset, 3> kPresets = [] {
    HomeSetOptions small;
    small.homes = 2;
    small.kind = HomeKind::kFlat;
    small.least_area = small.most_area = 60;
    small.face_size = 64;
    small.samples = 1;
    HomeSetOptions demo;
    demo.least_area = 90;
    demo.most_area = 135;
    HomeSetOptions full;
    full.homes = 90;
    full.least_area = 350;
    full.most_area = 850;
    full.face_size = 512;
    return std::array<Preset, 3>{{{"small", small}, {"demo", demo}, {"full", full}}};
  }();
  return kPresets;
}

void validate(const HomeSetOptions& o) {
  const auto check = [](bool good, const std::string& message) {
    if (!good) throw ArgumentError(message);
  };
  check(o.homes >= 1 && o.homes <= kMostHomes,
        fmt::format("homes: {}, not from 1 to {}", o.homes, kMostHomes));
  check(o.least_area >= 0 && o.most_area >= o.least_area,
        fmt::format("area: {} to {} m2, not a range of numbers >= 0", o.least_area, o.most_area));
  check(o.face_size <= 4096, fmt::format("face_size: {}, not from 0 to 4096", o.face_size));
  check(o.jpeg_quality >= 1 && o.jpeg_quality <= 100,
        fmt::format("jpeg_quality: {}, not from 1 to 100", o.jpeg_quality));
}

// What is drawn for one home of a set depends on the set's seed and its number only, so that a
// larger set begins with the homes of a smaller one.
PlanOptions plan_of(const HomeSetOptions& options, std::size_t home) {
  Rng rng(options.seed, stream_of("home", 4), home);
  PlanOptions plan;
  plan.seed = rng.next() >> 11;  // 53 bits: exact in every JSON reader
  plan.kind = options.kind;
  if (!plan.kind) {
    const double draw = rng.uniform();
    plan.kind = draw < 0.55   ? HomeKind::kHouse
                : draw < 0.75 ? HomeKind::kFlat
                : draw < 0.9  ? HomeKind::kOffice
                              : HomeKind::kHotelFloor;
  }
  if (options.most_area > 0) {
    plan.area = options.least_area + (options.most_area - options.least_area) * rng.uniform();
    // Sets of small homes should have stairs, too, which small plans have no room for.
    constexpr double kStairsShare = 0.25, kTwoStoreys = 170;
    const bool may = plan.kind == HomeKind::kHouse || plan.kind == HomeKind::kOffice;
    if (may && options.homes > 3 && plan.area < kTwoStoreys && rng.uniform() < kStairsShare) {
      plan.area = kTwoStoreys;
      plan.storeys = 2;
    }
  }
  return plan;
}

std::string readme(const HomeSetOptions& o) {
  return fmt::format(
      "{}\n"
      "Nothing in this folder is real: {} made-up buildings with furniture (`homes.json`), their\n"
      "navigation graphs (`connectivity/`), rooms (`regions/`), panoramas (`store/`) and, if they\n"
      "were asked for, paths with instructions that a program wrote (`r2r/`). Numbers from it are\n"
      "not comparable with any from Matterport3D or Room-to-Room.\n\n"
      "Seed {}, faces of {} texels; the same options give the same bytes.\n",
      kMarker, o.homes, o.seed, o.face_size);
}

void make_folder(const fs::path& folder) {
  std::error_code code;
  if (!fs::create_directories(folder, code) && code) {
    throw FileError(fmt::format("{}: {}", folder.string(), code.message()));
  }
}

// The list of an earlier run with the same options, or an empty one in a folder that is claimed.
HomeList claim(const fs::path& folder, const HomeSetOptions& options) {
  std::error_code code;
  const fs::path list_file = folder / "homes.json";
  if (fs::exists(list_file, code)) {
    HomeList list = detail::parse_home_list(read_file(list_file), list_file.string());
    const std::string differs = detail::difference(list.options, options);
    if (differs.empty()) return list;
    throw FileError(fmt::format("{}: holds homes made with other options ({}); name another folder",
                                folder.string(), differs));
  }
  if (fs::is_directory(folder, code) && !fs::is_empty(folder, code)) {
    const fs::path marker = folder / "README.md";
    if (!fs::exists(marker, code) || !read_file(marker).starts_with(kMarker)) {
      throw FileError(
          fmt::format("{}: holds files that are not model homes; name a new or an "
                      "empty folder",
                      folder.string()));
    }
  }
  make_folder(folder);
  write_file_atomically(folder / "README.md", readme(options));
  return {options, {}};
}

HomeEntry describe(const BuiltHome& built, const PlanOptions& plan,
                   const scan::Connectivity& connectivity) {
  const graph::NavGraph graph(connectivity);
  HomeEntry entry;
  entry.scan = connectivity.scan;
  entry.plan = plan;
  entry.kind = to_string(built.home.plan.kind);
  entry.viewpoints = graph.included_count();
  entry.edges = graph.edge_count() / 2;
  entry.triangles = built.home.mesh.triangles.size();
  for (const PlanRoom& room : built.home.plan.rooms) {
    entry.rooms.push_back({room.type, room.name, room.storey, {}});
  }
  for (std::size_t v = 0; v < connectivity.entries.size(); ++v) {
    const scan::ConnectivityEntry& viewpoint = connectivity.entries[v];
    Vec3d foot = viewpoint.position();
    foot.z -= viewpoint.height;
    if (const auto room = room_at(built.home.plan, foot)) {
      entry.rooms[*room].viewpoints.push_back(viewpoint.id);
    }
  }
  return entry;
}

void take_pictures(const BuiltHome& built, const scan::Connectivity& connectivity,
                   const HomeSetOptions& options, const fs::path& folder,
                   const Progress& progress) {
  mesh::BakeOptions bake;
  bake.threads = options.threads;
  // A third of the time that the finest takes, and hard to tell from it in rooms.
  bake.detail = 0.5F;
  bake.rays = 48;
  const auto lit = std::make_shared<mesh::LitMesh>(built.tracer, built.home.lights, bake);
  if (progress) progress(kLit - kBuilt, kUnits - kBuilt);
  mesh::CaptureOptions capture;
  capture.samples = options.samples;
  const std::string state =
      fmt::format("model home, generation {}, seed {}, {} triangles, samples {}", kGeneration,
                  built.home.plan.seed, built.home.mesh.triangles.size(), options.samples);
  const MeshPanoramas panoramas(lit, connectivity, options.face_size, capture, state);
  scan::PackOptions pack;
  pack.colour = scan::ColourCoding::kJpeg;
  pack.jpeg_quality = options.jpeg_quality;
  pack.threads = options.threads;
  scan::pack(panoramas, folder / "store", pack, [&](std::size_t done, std::size_t total) {
    if (progress) {
      progress(kLit - kBuilt + (kUnits - kLit) * done / std::max<std::size_t>(total, 1),
               kUnits - kBuilt);
    }
  });
}

HomeEntry write_home(const fs::path& folder, const HomeSetOptions& options, std::size_t place,
                     const SetProgress& progress) {
  const std::string scan = fmt::format("home_{:04}", place + 1);
  const PlanOptions plan = plan_of(options, place);
  const auto tell = [&](std::size_t units) {
    if (progress) progress(scan, place * kUnits + units, options.homes * kUnits);
  };
  tell(0);
  const BuiltHome built = build_home(plan);
  const scan::Connectivity connectivity = build_graph(built, scan, options.threads);
  write_file_atomically(scan::connectivity_file(folder / "connectivity", scan),
                        to_json(connectivity));
  tell(kBuilt);
  if (options.face_size > 0) {
    take_pictures(built, connectivity, options, folder,
                  [&](std::size_t done, std::size_t) { tell(kBuilt + done); });
  }
  tell(kUnits);
  return describe(built, plan, connectivity);
}

// RegionMap's layout, out of the list.
std::string regions_of(const HomeList& list) {
  std::string json = "{";
  for (const HomeEntry& home : list.homes) {
    json += fmt::format("{}\n\"{}\": {{", json.size() > 1 ? "," : "", home.scan);
    bool first = true;
    for (std::size_t r = 0; r < home.rooms.size(); ++r) {
      if (home.rooms[r].viewpoints.empty()) continue;
      json += fmt::format("{}\"{}\": [", first ? "" : ", ", r);
      for (std::size_t k = 0; k < home.rooms[r].viewpoints.size(); ++k) {
        json += fmt::format("{}\"{}\"", k > 0 ? ", " : "", home.rooms[r].viewpoints[k]);
      }
      json += "]";
      first = false;
    }
    json += "}";
  }
  return json + "\n}\n";
}

void write_list(const fs::path& folder, const HomeList& list) {
  std::string scans;
  for (const HomeEntry& home : list.homes) scans += home.scan + "\n";
  write_file_atomically(folder / "regions" / "region_to_panorama.json", regions_of(list));
  write_file_atomically(folder / "connectivity" / "scans.txt", scans);
  write_file_atomically(folder / "homes.json",
                        detail::to_json(list));  // last: it says what is done
}

}  // namespace

HomeSetOptions home_set_preset(std::string_view name) {
  for (const Preset& preset : presets()) {
    if (preset.name == name) return preset.options;
  }
  throw ArgumentError(fmt::format("preset: {:?} is none of small, demo, full", name));
}

std::vector<std::string> home_set_presets() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.emplace_back(preset.name);
  return names;
}

std::vector<HomeEntry> write_homes(const fs::path& folder, const HomeSetOptions& options,
                                   const SetProgress& progress) {
  validate(options);
  HomeList list = claim(folder, options);
  for (const char* part : {"connectivity", "regions"}) make_folder(folder / part);
  for (std::size_t i = list.homes.size(); i < options.homes; ++i) {
    list.homes.push_back(write_home(folder, options, i, progress));
    write_list(folder, list);
  }
  return list.homes;
}

std::vector<HomeEntry> read_home_list(const fs::path& folder) {
  const fs::path file = folder / "homes.json";
  return detail::parse_home_list(read_file(file), file.string()).homes;
}

}  // namespace enfilade::synth
