#include <fmt/format.h>
#include <array>
#include <map>
#include <memory>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/small_building.h"
#include "enfilade/homes/speaking/instructions.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/r2r/path_sampling.h"
#include "enfilade/scan/regions.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewest = 3, kMost = 1000;
constexpr std::size_t kPathsPerBuilding = 30;
constexpr double kValSeenShare = 0.2;
constexpr std::array kSplits{"train", "val_seen", "val_unseen", "test"};

// The first line tells an earlier data set of this kind from somebody's files.
constexpr std::string_view kMarker = "# A small SYNTHETIC data set made by Enfilade\n";

std::string readme(std::size_t buildings, std::uint64_t seed) {
  return fmt::format(
      "{}\n"
      "Nothing in this folder is real: {} made-up two-storey houses (`connectivity/`), their "
      "rooms\n"
      "(`regions/`), and paths with instructions that a program wrote (`r2r/`), in the formats of\n"
      "Matterport3D's navigation graphs and of Room-to-Room. It is there to try things on; "
      "numbers\n"
      "from it are not comparable with any from Matterport3D.\n\n"
      "Made by `enfilade synth -o FOLDER --buildings {} --seed {}`, which gives the same bytes\n"
      "again.\n",
      kMarker, buildings, buildings, seed);
}

// Refuses to write over anything that write_small_dataset() has not made.
void claim(const fs::path& folder) {
  std::error_code code;
  const bool there = fs::exists(folder, code);
  if (there && fs::is_directory(folder, code) && !fs::is_empty(folder, code)) {
    const fs::path marker = folder / "README.md";
    if (!fs::exists(marker, code) || !read_file(marker).starts_with(kMarker)) {
      throw FileError(
          fmt::format("{}: holds files that are not a synthetic data set; name a new "
                      "or an empty folder",
                      folder.string()));
    }
  }
  for (const char* part : {"connectivity", "regions", "r2r"}) make_folder(folder / part);
}

scan::ScanRegions regions_of(const SmallBuilding& building) {
  scan::ScanRegions regions{building.connectivity.scan, {}};
  for (const Room& room : building.rooms) {
    std::vector<std::string>& ids = regions.viewpoints.emplace_back();
    for (const ViewpointIndex v : room.viewpoints) {
      ids.push_back(building.connectivity.entries[v.at()].id);
    }
  }
  return regions;
}

// Viewpoint -> the name of its room.
std::vector<std::string> room_names(const SmallBuilding& building) {
  std::vector<std::string> names(building.connectivity.entries.size());
  for (const Room& room : building.rooms) {
    for (const ViewpointIndex v : room.viewpoints) names[v.at()] = room.name;
  }
  return names;
}

void add_instructions(std::vector<r2r::PathAnnotation>& paths,
                      const std::vector<SmallBuilding>& buildings, const graph::GraphSet& graphs) {
  std::unordered_map<std::string, std::vector<std::string>> names;
  for (const SmallBuilding& b : buildings) names[b.connectivity.scan] = room_names(b);
  for (r2r::PathAnnotation& path : paths) {
    const graph::NavGraph& graph = graphs.graph(path.scan);
    const std::vector<std::string>& rooms = names.at(path.scan);
    std::vector<ViewpointIndex> viewpoints;
    for (const std::string& id : path.path) viewpoints.push_back(graph.find(id).value());
    path.instructions = speaking::describe_path(
        graph, viewpoints, path.heading,
        [&rooms](ViewpointIndex v) -> const std::string& { return rooms[v.at()]; });
  }
}

std::map<std::string, r2r::Annotations> make_splits(const std::vector<SmallBuilding>& buildings,
                                                    const std::string& regions,
                                                    std::uint64_t seed) {
  std::vector<graph::NavGraph> graphs;
  for (const SmallBuilding& b : buildings) graphs.emplace_back(b.connectivity);
  const auto set = graph::GraphSet::of(std::move(graphs));
  r2r::SamplingOptions sampling;
  sampling.paths = kPathsPerBuilding * buildings.size();
  sampling.seed = seed;
  std::vector<r2r::PathAnnotation> paths =
      r2r::sample_paths(*set, scan::RegionMap::parse(regions, "region_to_panorama.json"), sampling);
  add_instructions(paths, buildings, *set);
  r2r::SplitOptions split;
  split.val_seen_share = kValSeenShare;
  split.seed = seed;
  return r2r::split_by_building(paths, split);
}

}  // namespace

void write_small_dataset(const fs::path& folder, std::size_t buildings, std::uint64_t seed) {
  if (buildings < kFewest || buildings > kMost) {
    throw ArgumentError(
        fmt::format("buildings: {}, not in {} .. {} (train, val_unseen and test "
                    "need one each)",
                    buildings, kFewest, kMost));
  }
  claim(folder);
  write_file_atomically(folder / "README.md", readme(buildings, seed));  // first: the claim
  Rng seeds(seed, stream_of("buildings", 9));
  std::vector<SmallBuilding> made;
  std::vector<scan::ScanRegions> rooms;
  std::string scans;
  for (std::size_t i = 1; i <= buildings; ++i) {
    made.push_back(make_small_building(seeds.next(), fmt::format("synth_{}", i)));
    rooms.push_back(regions_of(made.back()));
    const scan::Connectivity& c = made.back().connectivity;
    write_file_atomically(scan::connectivity_file(folder / "connectivity", c.scan), to_json(c));
    scans += c.scan + "\n";
  }
  write_file_atomically(folder / "connectivity" / "scans.txt", scans);
  const std::string regions = to_json(rooms);
  write_file_atomically(folder / "regions" / "region_to_panorama.json", regions);
  const auto splits = make_splits(made, regions, seed);
  for (const char* split : kSplits) {
    write_file_atomically(folder / "r2r" / fmt::format("R2R_{}.json", split),
                          to_json(splits.at(split)));
  }
}

}  // namespace enfilade::homes
