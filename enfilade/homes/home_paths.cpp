#include <fmt/format.h>
#include <algorithm>
#include <map>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/speaking/sights.h"
#include "enfilade/homes/speaking/speaker.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/path_sampling.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> speak(const speaking::SpokenHome& home, const tasks::PathAnnotation& path,
                               std::uint64_t seed) {
  std::vector<ViewpointIndex> viewpoints;
  for (const std::string& id : path.path) viewpoints.push_back(home.graph.find(id).value());
  std::vector<std::string> instructions;
  for (const speaking::Speaker speaker : speaking::kSpeakers) {
    Rng rng(seed, static_cast<std::uint64_t>(path.path_id), static_cast<std::uint64_t>(speaker));
    instructions.push_back(
        speaking::describe(home, viewpoints, path.heading.value, speaker, rng.next()));
  }
  return instructions;
}

// Instructions for all paths in one home, which is built again for it.
void speak_in(const HomeEntry& entry, const graph::GraphSet& graphs, const HomePathOptions& options,
              std::vector<tasks::PathAnnotation>& paths) {
  const auto [begin, end] =
      std::ranges::equal_range(paths, entry.scan, {}, &tasks::PathAnnotation::scan);
  if (begin == end) return;
  const BuiltHome built = build_home(entry.plan, Surfaces::kPlain);
  const graph::NavGraph& graph = graphs.graph(entry.scan);
  const speaking::Sights sights(built.home, *built.tracer, graph, 8192, options.threads);
  const speaking::SpokenHome home{built.home, graph, sights};
  for (auto path = begin; path != end; ++path) {
    path->instructions = speak(home, *path, options.seed);
  }
}

void write_splits(const fs::path& folder, const std::map<std::string, tasks::Annotations>& splits,
                  bool test_split) {
  const auto write = [&](const char* part, const char* name, const char* split) {
    make_folder(folder / part);
    write_file_atomically(folder / part / fmt::format("R2R_{}.json", name),
                          to_json(splits.at(split)));
  };
  for (const char* split : {"train", "val_seen", "val_unseen"}) write("r2r", split, split);
  if (!test_split) return;
  write("r2r", "test", "test");
  write("hidden", "test", "test_hidden");
}

}  // namespace

HomePathReport write_home_paths(const fs::path& folder, const HomePathOptions& options,
                                const SetProgress& progress) {
  const std::vector<HomeEntry> homes = read_home_list(folder);
  const std::size_t least = options.test_split ? kLeastHomes : kLeastHomes - 1;
  if (homes.size() < least) {
    throw FileError(fmt::format("{}: {} homes, but splits by building need {} at least",
                                folder.string(), homes.size(), least));
  }
  const auto graphs = graph::GraphSet::open(folder / "connectivity");
  const tasks::SamplingOptions sampling{
      .per_building = options.per_home, .seed = options.seed, .threads = options.threads};
  const auto regions = scan::RegionMap::load(folder / "regions" / "region_to_panorama.json");
  std::vector<tasks::PathAnnotation> paths = tasks::sample_paths(*graphs, regions, sampling);
  for (std::size_t i = 0; i < homes.size(); ++i) {
    if (progress) progress(homes[i].scan, i, homes.size());
    speak_in(homes[i], *graphs, options, paths);
  }
  if (progress) progress("", homes.size(), homes.size());
  tasks::SplitOptions split{.val_seen_share = options.val_seen_share, .seed = options.seed};
  if (!options.test_split) split.test_scans = 0;
  write_splits(folder, tasks::split_by_building(paths, split), options.test_split);
  return {paths.size(), paths.size() * speaking::kSpeakers.size()};
}

}  // namespace enfilade::homes
