#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <span>

#include "enfilade/core/errors.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/benchmarks/benchmarks.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/sets/scan_names.h"
#include "enfilade/homes/sets/written_files.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/path_sampling.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;

// Instructions for all paths in one home, which is built again for it.
void speak_in(const HomeEntry& entry, const graph::GraphSet& graphs,
              benchmarks::Benchmarks& benchmarks, std::vector<tasks::PathAnnotation>& paths) {
  const auto own = std::ranges::equal_range(paths, entry.scan, {}, &tasks::PathAnnotation::scan);
  if (own.empty()) return;
  benchmarks.add_home(build_home(entry.plan, Surfaces::kPlain), graphs.graph(entry.scan),
                      std::span(own.begin(), own.end()));
}

void write_splits(sets::WrittenFiles& files,
                  const std::map<std::string, tasks::Annotations>& splits, bool test_split) {
  const auto write = [&](const char* part, const char* name, const char* split) {
    files.write(fs::path(part) / fmt::format("R2R_{}.json", name), to_json(splits.at(split)));
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
  const tasks::SamplingOptions sampling{.per_building = options.per_home,
                                        .seed = options.seed,
                                        .draws_of = sets::draws_of,
                                        .threads = options.threads};
  const auto regions = scan::RegionMap::load(folder / "regions" / "region_to_panorama.json");
  std::vector<tasks::PathAnnotation> paths = tasks::sample_paths(*graphs, regions, sampling);
  benchmarks::Benchmarks benchmarks(options);
  for (std::size_t i = 0; i < homes.size(); ++i) {
    if (progress) progress(homes[i].scan, i, homes.size());
    speak_in(homes[i], *graphs, benchmarks, paths);
  }
  if (progress) progress("", homes.size(), homes.size());
  tasks::SplitOptions split{.val_seen_share = options.val_seen_share, .seed = options.seed};
  if (!options.test_split) split.test_scans = 0;
  const auto splits = tasks::split_by_building(paths, split);
  sets::WrittenFiles files(folder);
  write_splits(files, splits, options.test_split);
  benchmarks.write(files, splits, *graphs);
  files.finish();
  return {paths.size(), benchmarks.instructions()};
}

}  // namespace enfilade::homes
