#include "enfilade/homes/home_set.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include "enfilade/capture/mesh_panoramas.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/corrections.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/sets/home_list.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/regions.h"
#include "enfilade/scan/store.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;
using sets::HomeList;
using sets::scan_name;

constexpr std::string_view kMarker = "# Model homes: a SYNTHETIC data set made by Enfilade\n";
constexpr std::size_t kMostHomes = 10000;
// Raised when a change of the program makes other pictures from the same options.
constexpr int kGeneration = 3;
// Progress of a home: the whole, when its mesh and graph are made, when its light is computed; its
// pictures take the rest.
constexpr std::size_t kUnits = 100, kBuilt = 8, kLit = 28;
// Folder of the lists that runs of shards write, one for each home, until a run of the whole set
// adds them to its list.
constexpr const char* kShards = "shards";
// Stands for an entry's checksum of corrections while its graph is being corrected again.
constexpr const char* kUnfinished = "unfinished";

void validate(const HomeSetOptions& o) {
  const auto check = [](bool good, const std::string& message) {
    if (!good) throw ArgumentError(message);
  };
  check_range("homes", static_cast<double>(o.homes), 1, kMostHomes);
  check((o.least_area == 0 && o.most_area == 0) ||
            (o.least_area >= kLeastArea && o.most_area <= kMostArea && o.least_area <= o.most_area),
        fmt::format("area: {} to {} m2, not a range within {} to {}, or 0", o.least_area,
                    o.most_area, kLeastArea, kMostArea));
  check_range("face_size", o.face_size, 0, 4096);
  check(o.samples == 1 || o.samples == 4 || o.samples == 9 || o.samples == 16,
        fmt::format("samples: {}, not 1, 4, 9 or 16", o.samples));
  check_range("jpeg_quality", o.jpeg_quality, 1, 100);
  check_range("pretty", static_cast<double>(o.pretty), 0, static_cast<double>(o.homes));
  check(o.shard.index < o.shard.count && o.shard.count <= kMostHomes,
        fmt::format("shard: index {} of {}, not below it or not from 1 to {}", o.shard.index,
                    o.shard.count, kMostHomes));
}

// The index of a home in a set of `homes`, from its name. Refuses a name that is not in the set, at
// `where` of `file`.
std::size_t place_of(const std::string& scan, std::size_t homes, const fs::path& file,
                     const std::string& where) {
  const auto place = sets::place_of_scan(scan);
  if (place && *place < homes) return *place;
  refuse(file.string(), where, "unknown-scan",
         fmt::format("{:?} is none of the {} homes of this set: {} to {}", scan, homes,
                     scan_name(0), scan_name(homes - 1)));
}

bool has_stairs(const HomeSetOptions& options, std::size_t home) {
  const HomeKind kind = options.kind.value_or(HomeKind::kHouse);
  const bool may = kind == HomeKind::kHouse || kind == HomeKind::kOffice;
  return may && options.stairs_every > 0 && home % options.stairs_every == 1 % options.stairs_every;
}

// Those of one home's pictures: a pretty one has others than the rest of the set.
HomeSetOptions picture_options(const HomeSetOptions& options, std::size_t home) {
  HomeSetOptions own = options;
  if (std::ranges::binary_search(pretty_homes(options), scan_name(home))) {
    own.light = HomeLight::kFine;
    own.face_size = kPrettyFaceSize;
    own.samples = kPrettySamples;
  }
  return own;
}

// The random numbers of a home depend on the set's seed and the home's place only, so that a larger
// set begins with the homes of a smaller one.
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
  }
  if (has_stairs(options, home)) {
    if (plan.kind != HomeKind::kOffice) plan.kind = HomeKind::kHouse;
    plan.area = 170;  // the least that two storeys fit into
    plan.storeys = 2;
  }
  return plan;
}

std::string readme(const HomeSetOptions& o) {
  const std::vector<std::string> pretty = pretty_homes(o);
  return fmt::format(
      "{}\n"
      "Nothing in this folder is real: {} made-up buildings with furniture (`homes.json`), their\n"
      "navigation graphs (`connectivity/`), rooms (`regions/`), panoramas (`store/`) and, if they\n"
      "were asked for, paths with instructions that a program wrote (`r2r/`). Numbers from it are\n"
      "not comparable with any from Matterport3D or Room-to-Room.\n\n"
      "Seed {}, faces of {} texels{}; the same options give the same bytes.\n",
      kMarker, o.homes, o.seed, o.face_size,
      pretty.empty() ? ""
                     : fmt::format(", but of {} and finer light in {}", kPrettyFaceSize,
                                   fmt::join(pretty, ", ")));
}

// People's corrections to the graph of one home.
struct HomeCorrections {
  fs::path file;
  graph::Corrections corrections;
  std::string checksum;  // of what they say, however it is laid out; 16 hex digits
};

constexpr std::string_view kSuffix = "_corrections.json";

// The files of corrections in a folder, sorted by name, so that the same fault is reported first on
// every machine.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const auto scan = name_before(entry.path(), kSuffix);
    // A plain and a packed file: the one that readers take.
    if (scan && find_text_file(folder / fmt::format("{}{}", *scan, kSuffix)) == entry.path()) {
      files.push_back(entry.path());
    }
  }
  if (code) throw FileError(fmt::format("{}: cannot open: {}", folder.string(), code.message()));
  if (files.empty()) {
    throw FileError(
        fmt::format("{}: holds no corrections: SCAN{} is expected", folder.string(), kSuffix));
  }
  std::ranges::sort(files);
  return files;
}

// The corrections in a folder, by the homes' places in the set; none for an empty path.
std::map<std::size_t, HomeCorrections> load_home_corrections(const fs::path& folder,
                                                             std::size_t homes) {
  std::map<std::size_t, HomeCorrections> all;
  if (folder.empty()) return all;
  for (const fs::path& file : files_in(folder)) {
    const std::string scan = name_before(file, kSuffix).value();
    const std::size_t home = place_of(scan, homes, file, "");
    graph::Corrections corrections = graph::load_corrections(file);
    if (corrections.scan != scan) {
      refuse(file.string(), "$.scan", "other-scan",
             fmt::format("{:?}, and the file is named after {:?}", corrections.scan, scan));
    }
    const std::string text = to_json(corrections);
    const std::string checksum = fmt::format("{:016x}", stream_of(text.data(), text.size()));
    all[home] = {file, std::move(corrections), checksum};
  }
  return all;
}

// Homes by their places in the set.
using Homes = std::map<std::size_t, HomeEntry>;

// Adds the homes of a list that an earlier run wrote. \throws FileError if its options were others
void add_list(const fs::path& file, const fs::path& folder, const HomeSetOptions& options,
              Homes& homes) {
  HomeList list = sets::parse_home_list(read_file(file), file.string());
  const std::string differs = sets::difference(list.options, options);
  if (!differs.empty()) {
    throw FileError(fmt::format("{}: holds homes made with other options ({}); name another folder",
                                folder.string(), differs));
  }
  for (std::size_t i = 0; i < list.homes.size(); ++i) {
    const std::string where = fmt::format("$.homes[{}].scan", i);
    const std::size_t place = place_of(list.homes[i].scan, options.homes, file, where);
    homes[place] = std::move(list.homes[i]);
  }
}

// Leaves a file that has this content already as it is, with its time: `enfilade demo` makes again
// what is older than the list of its homes.
void write_changed(const OutputFolder& out, const std::string& name, const std::string& content) {
  const fs::path file = out.path() / name;
  std::error_code code;  // ignored: the size of a missing file is 2^64 - 1, unlike any content's
  if (fs::file_size(file, code) == content.size() && read_file(file) == content) return;
  out.write(name, content);
}

void write_list(const OutputFolder& out, const std::string& name, const HomeSetOptions& options,
                const Homes& homes) {
  HomeList list{options, {}};
  for (const auto& [place, home] : homes) list.homes.push_back(home);
  write_changed(out, name, sets::to_json(list));
}

// Whether a folder has files, except those that another shard is about to put in place.
bool has_files(const fs::path& folder) {
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    if (!is_unfinished(entry.path())) return true;
  }
  return code && fs::is_directory(folder);  // one that cannot be read
}

// The homes that earlier runs with the same options made. A folder without a list has none; it must
// be new, empty or left by a killed run, and gets an empty list.
Homes claim(const fs::path& folder, const HomeSetOptions& options) {
  Homes homes;
  std::error_code code;
  const fs::path list_file = folder / "homes.json";
  if (fs::exists(list_file, code)) {
    add_list(list_file, folder, options, homes);
    if (fs::is_directory(folder / kShards, code)) {
      for (const auto& entry : fs::directory_iterator(folder / kShards, code)) {
        if (entry.path().extension() == ".json") add_list(entry.path(), folder, options, homes);
      }
    }
    return homes;
  }
  if (has_files(folder)) {
    const fs::path marker = folder / "README.md";
    if (!fs::exists(marker, code) || !read_file(marker).starts_with(kMarker)) {
      throw FileError(folder.string() +
                      ": holds files that are not model homes; name a new or an empty folder");
    }
  }
  const OutputFolder out(folder);
  out.write("README.md", readme(options));
  // Before any home is made: the list says with which options a killed run made its files.
  write_list(out, "homes.json", options, homes);
  return homes;
}

// \param tell is called with how many of the home's kUnits are done
void take_pictures(const BuiltHome& built, const scan::Connectivity& connectivity,
                   const HomeSetOptions& options, const OutputFolder& out,
                   const std::function<void(std::size_t units)>& tell) {
  const mesh::BakeOptions bake = bake_options(options.light, options.threads);
  const auto lit = std::make_shared<mesh::LitMesh>(built.tracer, built.home.lights, bake);
  tell(kLit);
  const mesh::CaptureOptions capture{.samples = options.samples};
  const std::string state = fmt::format(
      "model home, generation {}, seed {}, {} triangles, samples {}{}, faces of {}", kGeneration,
      built.home.plan.seed, built.home.mesh.triangles.size(), options.samples,
      options.light == HomeLight::kFine ? "" : ", coarse light", options.face_size);
  const capture::MeshPanoramas panoramas(lit, connectivity, options.face_size, capture, state);
  const scan::PackOptions pack{.colour = scan::ColourCoding::kJpeg,
                               .jpeg_quality = options.jpeg_quality,
                               .threads = options.threads};
  scan::pack(panoramas, out.folder("store").path(), pack, [&](std::size_t done, std::size_t total) {
    tell(kLit + (kUnits - kLit) * done / std::max<std::size_t>(total, 1));
  });
}

std::vector<scan::ScanRegions> regions_of(const Homes& homes) {
  std::vector<scan::ScanRegions> scans;
  for (const auto& [place, home] : homes) {
    scan::ScanRegions regions{home.scan, {}};
    for (const RoomEntry& room : home.rooms) regions.viewpoints.push_back(room.viewpoints);
    scans.push_back(std::move(regions));
  }
  return scans;
}

// A run over the homes of a shard.
class HomeWriter {
 public:
  HomeWriter(const fs::path& folder, const HomeSetOptions& options, const SetProgress& progress)
      : folder_(folder), options_(options), progress_(progress) {}

  HomeSetReport run() {
    corrections_ = load_home_corrections(options_.corrections, options_.homes);
    homes_ = claim(folder_, options_);
    for (const char* part : {"connectivity", "regions"}) static_cast<void>(out().folder(part));
    if (whole()) gather();
    for (std::size_t i = options_.shard.index; i < options_.homes; i += options_.shard.count) {
      const auto found = homes_.find(i);
      if (found == homes_.end()) {
        make(i);
      } else if (found->second.corrections != wanted(i)) {
        correct_again(i);
      } else if (found->second.lines.storeys.empty()) {
        save(i, completed(found->second, folder_), wanted(i));
      }
      if (options_.parts.any()) write_parts(i);
      report_.homes.push_back(homes_.at(i));
    }
    return std::move(report_);
  }

 private:
  OutputFolder out() const { return OutputFolder(folder_); }
  bool whole() const { return options_.shard.count == 1; }

  const HomeCorrections* corrections_of(std::size_t home) const {
    const auto found = corrections_.find(home);
    return found == corrections_.end() ? nullptr : &found->second;
  }
  std::string wanted(std::size_t home) const {
    const HomeCorrections* corrections = corrections_of(home);
    return corrections == nullptr ? "" : corrections->checksum;
  }

  // Writes the shards' homes, which claim() has read, into the set's list. Removes the shards'
  // lists and the unfinished files of killed runs.
  void gather() {
    if (!homes_.empty()) save_list();
    out().remove_all(kShards);
    std::vector<std::string> parts = home_tasks();
    for (const std::string& task : home_tasks()) parts.push_back("hidden/" + task);
    for (const char* split : {"train", "val_seen", "val_unseen"}) {
      parts.push_back(std::string("rxr/pose_traces/rxr_") + split);
    }
    parts.insert(parts.end(), {"", "connectivity", "regions", "r2r", "hidden"});
    for (const std::string& part : parts) out().remove_unfinished(part);
  }

  void make(std::size_t home) {
    const PlanOptions plan = plan_of(options_, home);
    const auto tell = [&](std::size_t units) {
      if (progress_) {
        progress_(scan_name(home), home * kUnits + units, options_.homes * kUnits);
      }
    };
    tell(0);
    const BuiltHome built =
        build(home, plan, options_.face_size > 0 ? HomeSurfaces::kTextured : HomeSurfaces::kPlain);
    const scan::Connectivity found = graph_of(home, built);
    const scan::Connectivity corrected = write_graph(home, found);
    tell(kBuilt);
    if (options_.face_size > 0) {
      // At the viewpoints before corrections: people correct the graph after seeing the pictures.
      take_pictures(built, found, picture_options(options_, home), out(), tell);
    }
    tell(kUnits);
    save(home, describe(built.home, plan, corrected), wanted(home));
  }

  // Writes Matterport3D's files, at the viewpoints before corrections, as make() does. Finished
  // files are kept.
  void write_parts(std::size_t home) const {
    const BuiltHome built = build(home, plan_of(options_, home), HomeSurfaces::kTextured);
    const scan::Connectivity found = graph_of(home, built);
    mesh::BakeOptions bake =
        options_.parts.coloured() ? mesh::BakeOptions{} : capture::least_light();
    bake.threads = options_.threads;
    const mesh::LitMesh lit(built.tracer, built.home.lights, bake);
    capture::ScanFilesOptions files;
    files.parts = options_.parts;
    files.parts.connectivity = false;
    if (options_.face_size > 0) files.face_size = options_.face_size;
    files.image_width = options_.image_width;
    files.samples = options_.samples;
    files.jpeg_quality = options_.jpeg_quality;
    files.threads = options_.threads;
    files.rooms = scan_rooms(built.home.plan);
    write_scan(lit, found, folder_, files);
  }

  void correct_again(std::size_t home) {
    const HomeEntry old = homes_.at(home);
    save(home, old, kUnfinished);
    const BuiltHome built = build(home, old.plan, HomeSurfaces::kPlain);
    const scan::Connectivity found = graph_of(home, built);
    save(home, describe(built.home, old.plan, write_graph(home, found)), wanted(home));
  }

  BuiltHome build(std::size_t home, const PlanOptions& plan, HomeSurfaces surfaces) const {
    try {
      return build_home(plan, surfaces);
    } catch (const NoPlan& none) {
      throw NoPlan(fmt::format("{}: {}. {} homes made before are kept in {}", scan_name(home),
                               none.what(), homes_.size(), folder_.string()));
    }
  }

  scan::Connectivity graph_of(std::size_t home, const BuiltHome& built) const {
    return home_graph(built, scan_name(home), options_.threads);
  }

  // Writes the graph with the home's corrections, if it has any. \returns what was written
  scan::Connectivity write_graph(std::size_t home, scan::Connectivity graph) {
    if (const HomeCorrections* there = corrections_of(home)) {
      graph::Corrected corrected = apply(graph, there->corrections, there->file.string());
      report_.notes.insert(report_.notes.end(), corrected.notes.begin(), corrected.notes.end());
      graph = std::move(corrected.connectivity);
    }
    out().write(scan::connectivity_file("connectivity", graph.scan).string(), to_json(graph));
    return graph;
  }

  void save(std::size_t home, HomeEntry entry, std::string corrections) {
    entry.corrections = std::move(corrections);
    homes_[home] = std::move(entry);
    if (whole()) {
      save_list();
    } else {
      write_list(out(), fmt::format("{}/{}.json", kShards, scan_name(home)), options_,
                 {{home, homes_.at(home)}});
    }
  }

  void save_list() const {
    std::string scans;
    for (const auto& [place, home] : homes_) scans += home.scan + "\n";
    out().write("regions/region_to_panorama.json", to_json(regions_of(homes_)));
    out().write("connectivity/scans.txt", scans);
    sets::write_alias_graph(out().folder("connectivity"));
    write_list(out(), "homes.json", options_, homes_);  // last: its homes are complete
  }

  const fs::path& folder_;
  const HomeSetOptions& options_;
  const SetProgress& progress_;
  std::map<std::size_t, HomeCorrections> corrections_;
  Homes homes_;
  HomeSetReport report_;
};

}  // namespace

HomeSetReport write_homes(const fs::path& folder, const HomeSetOptions& options,
                          const SetProgress& progress) {
  validate(options);
  return HomeWriter(folder, options, progress).run();
}

namespace {

// The home's graph as its store has it, if this version makes it, too. Else its pictures would be
// of another home.
scan::Connectivity graph_of_store(const HomeEntry& home, const BuiltHome& built,
                                  const scan::Store& store, const fs::path& folder, int threads) {
  scan::Connectivity graph = home_graph(built, home.scan, threads);
  if (built.home.mesh.triangles.size() != home.triangles ||
      to_json(graph) != to_json(store.connectivity())) {
    throw FileError(fmt::format(
        "{}: this version of Enfilade makes another {} of these options; its pictures stay",
        folder.string(), home.scan));
  }
  return graph;
}

std::uint32_t face_size_of(const scan::Store& store) {
  std::uint32_t size = 0;
  for (std::size_t v = 0; v < store.size(); ++v) {
    size = std::max(size, store.face_sizes(ViewpointIndex(v))[index(scan::Layer::kColour)]);
  }
  return size;
}

}  // namespace

std::vector<std::string> scans_to_enlarge(const fs::path& folder, std::uint32_t face_size) {
  const std::vector<std::string> pretty = pretty_homes(read_home_options(folder));
  std::vector<std::string> scans;
  for (const HomeEntry& home : read_home_list(folder)) {
    const fs::path file = scan::store_file(folder / "store", home.scan);
    if (!pretty.empty() && !std::ranges::binary_search(pretty, home.scan)) continue;
    if (!file_exists(file) || face_size_of(*scan::Store::open(file)) >= face_size) continue;
    scans.push_back(home.scan);
  }
  return scans;
}

std::vector<std::string> enlarge_pictures(const fs::path& folder, std::uint32_t face_size,
                                          int threads, const SetProgress& progress) {
  check_range("face_size", face_size, 1, 4096);
  const fs::path list_file = folder / "homes.json";
  const HomeList list = sets::parse_home_list(read_file(list_file), list_file.string());
  std::vector<std::string> scans = scans_to_enlarge(folder, face_size);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const std::string& scan = scans[k];
    const auto tell = [&](std::size_t units) {
      if (progress) progress(scan, k * kUnits + units, scans.size() * kUnits);
    };
    tell(0);
    const HomeEntry& home = *std::ranges::find(list.homes, scan, &HomeEntry::scan);
    const auto store = scan::Store::open(scan::store_file(folder / "store", scan));
    const BuiltHome built = build_home(home.plan);
    const scan::Connectivity graph = graph_of_store(home, built, *store, folder, threads);
    HomeSetOptions options =
        picture_options(list.options, place_of(scan, list.options.homes, list_file, ""));
    options.face_size = face_size;
    options.threads = threads;
    take_pictures(built, graph, options, OutputFolder(folder), tell);
    tell(kUnits);
  }
  return scans;
}

HomeSetOptions read_home_options(const fs::path& folder) {
  const fs::path file = folder / "homes.json";
  return sets::parse_home_list(read_file(file), file.string()).options;
}

std::vector<HomeEntry> read_home_list(const fs::path& folder) {
  const fs::path file = folder / "homes.json";
  return sets::parse_home_list(read_file(file), file.string()).homes;
}

}  // namespace enfilade::homes
