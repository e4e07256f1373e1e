// enfilade sample: new Room-to-Room paths from graphs and regions.
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include <set>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/path_comparison.h"
#include "enfilade/tasks/path_sampling.h"

namespace enfilade::apps::sample_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, connectivity, regions, output;
  bool splits = false;
  std::vector<std::size_t> shares;
  bool compare = false;
  tasks::SamplingOptions sampling;
};

void check(const Options& options) {
  if (options.output.empty() && !options.compare) {
    throw UsageError("sample: where to? Give -o, or --compare to look at the paths only");
  }
  if (options.output == "-" && (options.splits || options.compare)) {
    throw UsageError("sample: -o - takes all of standard output: not with --splits or --compare");
  }
}

std::vector<tasks::PathAnnotation> draw(const Options& options, const graph::GraphSet& graphs,
                                        const scan::RegionMap& regions) {
  auto paths = tasks::sample_paths(graphs, regions, options.sampling, progress_bar("sampling"));
  if (!paths.empty()) return paths;
  std::size_t known = 0;
  for (const std::string& scan : regions.scans()) known += graphs.find(scan) ? 1 : 0;
  throw UsageError(fmt::format(
      "sample: no path goes from a room to another within the limits ({} to {} edges, at least {} "
      "m); of {} buildings, the region map names {}",
      options.sampling.min_edges, options.sampling.max_edges, options.sampling.min_length,
      graphs.size(), known));
}

std::size_t count_buildings(const std::vector<tasks::PathAnnotation>& paths) {
  std::set<std::string> scans;
  for (const tasks::PathAnnotation& path : paths) scans.insert(path.scan);
  return scans.size();
}

void write_splits(const Options& options, const std::vector<tasks::PathAnnotation>& paths) {
  tasks::SplitOptions split_options{.seed = options.sampling.seed};
  if (!options.shares.empty()) {
    split_options.train_scans = options.shares[0];
    split_options.val_unseen_scans = options.shares[1];
    split_options.test_scans = options.shares[2];
  }
  const auto splits = split_by_building(paths, split_options);
  const OutputFolder out(options.output);
  for (const auto& [name, split] : splits) {
    out.write(split.file, to_json(split));
    say("{:<12} {:>5} paths in {:>2} buildings -> {}\n", name, split.paths.size(),
        count_buildings(split.paths), (out.path() / split.file).string());
  }
}

void write_paths(const Options& options, const tasks::Annotations& drawn) {
  if (options.splits) {
    write_splits(options, drawn.paths);
    return;
  }
  write_output(options.output, to_json(drawn));
  if (options.output == "-") return;
  say("{} paths in {} buildings -> {}\n", drawn.paths.size(), count_buildings(drawn.paths),
      options.output);
}

void sample(const Options& options) {
  check(options);
  const fs::path connectivity = options.connectivity.empty()
                                    ? open_data(options.data).connectivity_folder()
                                    : fs::path(options.connectivity);
  const fs::path regions_file =
      options.regions.empty() ? open_data(options.data).regions_file() : fs::path(options.regions);
  const auto graphs = graph::GraphSet::open(connectivity);
  const auto regions = scan::RegionMap::load(regions_file);
  std::vector<tasks::Annotations> reference;
  if (options.compare) {  // with the splits whose goals are known
    const dataset::Dataset data = open_data(options.data);
    for (const char* split : {"train", "val_seen", "val_unseen"}) {
      reference.push_back(data.annotations(split));
    }
  }
  const tasks::Annotations drawn{"drawn", "drawn paths", draw(options, *graphs, regions)};
  if (!options.output.empty()) write_paths(options, drawn);
  if (options.compare) say("{}", to_table(compare_paths(drawn, reference, *graphs, regions)));
}

void add_limits(CLI::App& verb, tasks::SamplingOptions& sampling) {
  verb.add_option_function<std::string>(
          "--pairs",
          [&sampling](const std::string& rule) {
            sampling.pairs =
                rule == "rooms" ? tasks::PairRule::kRooms : tasks::PairRule::kViewpoints;
          },
          "Draw pairs of rooms, once each, or pairs of viewpoints (default: rooms)")
      ->check(CLI::IsMember({"rooms", "viewpoints"}))
      ->type_name("RULE");
  add_whole_number(verb, "--per-building", sampling.per_building, "Most paths per building");
  verb.add_option("--paths", sampling.paths, "Most paths in total (default: no limit)")
      ->check(whole_number(1));
  add_whole_number(verb, "--min-edges", sampling.min_edges, "Fewest edges of a path");
  add_whole_number(verb, "--max-edges", sampling.max_edges, "Most edges of a path");
  add_setting(verb, "--min-length", sampling.min_length, "", "Least length of a path, metres",
              finite_number());
  add_whole_number(verb, "--seed", sampling.seed, "The same seed gives the same paths", 0);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("sample", "Draw new R2R paths, from room to room, without instructions");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_value(verb, "--connectivity", options->connectivity, "DIR",
            "Navigation graphs, instead of the data set's");
  add_value(verb, "--regions", options->regions, "FILE",
            "Rooms of viewpoints {scan: {region: [viewpoints]}}, instead of the data set's "
            "regions/region_to_panorama.json");
  add_limits(verb, options->sampling);
  add_value(verb, "-o,--output", options->output, "FILE|DIR",
            "File to write, - for standard output; with --splits a folder");
  CLI::Option* splits =
      verb.add_flag("--splits", options->splits,
                    "Split by building into R2R_{train,val_seen,val_unseen,test,test_hidden}.json");
  add_value(verb, "--shares", options->shares, "N",
            "Buildings for train, val_unseen and test, scaled to those there are (default: "
            "61 11 18)")
      ->expected(3)
      ->needs(splits)
      ->check(whole_number());
  verb.add_flag("--compare", options->compare,
                "Print lengths and edge counts beside those of the data set");
  set_examples(verb, {"enfilade sample --compare", "enfilade sample --splits -o new_r2r",
                      "enfilade sample --pairs viewpoints --per-building 1000 -o many.json"});
  verb.callback([options] { sample(*options); });
}

}  // namespace enfilade::apps::sample_verb
