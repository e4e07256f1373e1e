// enfilade speak: instructions by a trained speaker, for paths without any.
#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/speaker.h"
#include "enfilade/tasks/path_sampling.h"

namespace enfilade::apps::speak_verb {
namespace {

struct Options {
  std::string model, data, features, output;
  std::vector<std::string> splits{"train"};
  tasks::SamplingOptions sampling{.pairs = tasks::PairRule::kViewpoints, .paths = 10'000};
  bool draw_words = false;
  neural::SpeakOptions speaking;
  int threads = 0;
};

// Paths that the splits have, for their scans and the ids that are taken.
struct Known {
  std::vector<std::string> scans;  // each once, in the order of the files
  std::int64_t largest_id = 0;
};

Known known_paths(const Options& options, const dataset::Dataset& data) {
  Known known;
  std::set<std::string> seen;
  for (const std::string& split : options.splits) {
    for (const tasks::PathAnnotation& path : data.annotations(split).paths) {
      if (seen.insert(path.scan).second) known.scans.push_back(path.scan);
      known.largest_id = std::max(known.largest_id, path.path_id);
    }
  }
  if (known.scans.empty()) throw UsageError("speak: the splits have no paths, so no buildings");
  return known;
}

tasks::Annotations drawn_paths(const Options& options, const dataset::Dataset& data) {
  const Known known = known_paths(options, data);
  tasks::SamplingOptions sampling = options.sampling;
  // As many in each building; small ones have less to give.
  sampling.per_building = sampling.paths / known.scans.size() + 1;
  const auto graphs = graph::GraphSet::open(data.connectivity_folder(), known.scans);
  tasks::Annotations drawn{
      "spoken", options.output,
      sample_paths(*graphs, data.regions(), sampling, progress_bar("sampling"))};
  if (drawn.paths.empty()) {
    throw UsageError(fmt::format(
        "speak: no path of {} to {} edges and at least {} m in the {} buildings of these splits",
        sampling.min_edges, sampling.max_edges, sampling.min_length, known.scans.size()));
  }
  for (tasks::PathAnnotation& path : drawn.paths) path.path_id += known.largest_id;
  return drawn;
}

void speak(const Options& options) {
  neural::set_threads(options.threads);
  neural::Speaker speaker(options.model);
  const dataset::Dataset data = open_data(options.data);
  std::optional<features::FeatureSet> features;
  if (!options.features.empty()) features = features::FeatureSet::open(options.features);
  tasks::Annotations drawn = drawn_paths(options, data);
  const auto& graphs = data.graphs();
  const tasks::EpisodeSet paths{drawn.split, graphs, look_up_paths(drawn, *graphs), {}};
  neural::SpeakOptions speaking = options.speaking;
  if (options.draw_words) speaking.drawn = options.sampling.seed;
  speaking.environment_seed = options.sampling.seed;
  const auto texts = speaker.describe(paths, features ? &*features : nullptr, speaking,
                                      progress_bar(fmt::format("{}, speaking", options.model)));
  // A path that the speaker has no word for would be no instruction.
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (!texts[i].empty()) drawn.paths[i].instructions = {texts[i]};
  }
  const std::size_t silent =
      std::erase_if(drawn.paths, [](const auto& path) { return path.instructions.empty(); });
  write_output(options.output, to_json(drawn));
  if (options.output == "-") return;
  say("{} ({}, iteration {}): {} paths, an instruction each -> {}\n", options.model,
      to_string(speaker.config().training.agent), speaker.iteration(), drawn.paths.size(),
      options.output);
  if (silent > 0) say("{} paths left out, of which it said nothing\n", silent);
  if (drawn.paths.size() + silent < options.sampling.paths) {
    say("{} paths were asked for; the buildings gave no more within the limits\n",
        options.sampling.paths);
  }
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("speak", kSpeakHelp);
  const auto options = std::make_shared<Options>();
  add_value(verb, "model", options->model, "MODELDIR",
            "Model directory of `enfilade train --agent speaker`")
      ->required();
  add_data_option(verb, options->data);
  add_value(verb, "--features", options->features, "FILE",
            "Image features, if the speaker uses vision");
  add_value(verb, "-o,--output", options->output, "FILE",
            "Annotations to write, such as DATA/r2r/R2R_NAME.json; - for standard output")
      ->required();
  add_setting(verb, "--splits", options->splits, "NAMES", "Splits whose buildings the paths are in")
      ->delimiter(',');
  add_whole_number(verb, "--paths", options->sampling.paths, "Most paths");
  add_whole_number(verb, "--min-edges", options->sampling.min_edges, "Fewest edges of a path");
  add_whole_number(verb, "--max-edges", options->sampling.max_edges, "Most edges of a path");
  add_setting(verb, "--min-length", options->sampling.min_length, "",
              "Least length of a path, metres", finite_number());
  add_whole_number(verb, "--seed", options->sampling.seed,
                   "Seed of paths, words and dropout; one seed gives one file", 0);
  verb.add_flag("--draw-words", options->draw_words,
                "Sample words by probability, instead of the most probable ones");
  add_whole_number(verb, "--most-words", options->speaking.most_words,
                   "Most words of an instruction");
  add_setting(verb, "--environmental-dropout", options->speaking.environmental_dropout, "",
              "Share of feature columns that a whole batch lacks", finite_number(0, 0.99));
  add_whole_number(verb, "--batch", options->speaking.batch_size, "Paths at once");
  add_threads_option(verb, options->threads);
  set_examples(verb, {"enfilade train --agent speaker --features resnet.safetensors -o speaker",
                      "enfilade speak speaker --data DIR --features resnet.safetensors --paths "
                      "20000 -o DIR/r2r/R2R_aug.json",
                      "enfilade train --agent panoramic --data DIR --splits train,aug --features "
                      "resnet.safetensors -o listener"});
  verb.callback([options] { speak(*options); });
}

}  // namespace enfilade::apps::speak_verb
