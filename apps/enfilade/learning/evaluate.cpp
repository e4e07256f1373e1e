// enfilade evaluate: a trained agent over whole splits.
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/speaker.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps::evaluate_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string model, data, features, objects, meshes, task, output, device = "cpu";
  std::vector<std::string> splits{"val_seen", "val_unseen"};
  int threads = 0;
  std::size_t batch_size = 100;
  RankOptions ranks;
};

// Warns of data that differ from those of training.
std::vector<tasks::EpisodeSet> load_splits(const Options& options,
                                           const models::ModelConfig& config,
                                           const features::FeatureSet* features) {
  const dataset::Dataset data = open_data(options.data);
  const tasks::Task task = task_of(options.task, data);
  models::DataFingerprint here;
  if (features != nullptr) here.features = features->info();
  std::vector<tasks::EpisodeSet> splits;
  for (const std::string& split : options.splits) {
    splits.push_back(data.episodes(task, split));
    here.add(data.annotations(task, split));
    here.add_graphs(splits.back());
  }
  const auto warnings =
      differences(config.data, here, models::ModelFiles{options.model}.config().string());
  if (!warnings.empty()) print_diagnostics(warnings);
  return splits;
}

void evaluate(const Options& options, neural::TrainedAgent& agent,
              const tasks::EpisodeSet& episodes, neural::Ranks& ranks) {
  ranks.agree({{"iteration of the model", std::to_string(agent.iteration())},
               {"split", episodes.split},
               {"episodes", std::to_string(episodes.episodes.size())},
               {"--batch", std::to_string(options.batch_size)}});
  const std::string& name = episodes.split;
  const models::ModelFiles files{options.model};
  const fs::path folder(options.output);
  const bool named = !options.output.empty();
  const auto trajectories = agent.walk(
      {options.batch_size, named ? folder / (name + ".json") : files.results(name),
       named ? folder / (name + ".attention.json") : files.attention(name), &ranks,
       named ? fs::path() : files.folder},
      ranks.is_first() ? progress_bar(fmt::format("{}, {}", options.model, name)) : Progress());
  if (!ranks.is_first()) return;
  say("{} ({}, iteration {}) on {}: {} episodes\n", options.model, agent.name(), agent.iteration(),
      name, trajectories.size());
  if (goals_hidden(episodes)) {
    say("The goals of this split are hidden; hand the results file in.\n");
  } else {
    const tasks::Benchmark& benchmark = tasks::benchmark(episodes.task);
    say("{}",
        to_table(compute_score(trajectories, episodes, benchmark.scorer(benchmark.table_scorer))));
  }
}

// A speaker describes the paths of splits.
void evaluate_speaker(const Options& options) {
  neural::Speaker speaker(options.model);
  std::optional<features::FeatureSet> file;
  if (!options.features.empty()) file = features::FeatureSet::open(options.features);
  for (const tasks::EpisodeSet& split :
       load_splits(options, speaker.config(), file ? &*file : nullptr)) {
    const models::SpeakerRecord score =
        speaker.score(split, file ? &*file : nullptr, options.batch_size,
                      progress_bar(fmt::format("{}, {}", options.model, split.split)));
    say("{} (speaker, iteration {}) on {}: {} instructions\n"
        "loss a word {:.4f}, perplexity {:.3f}, words predicted {:.1f} %, BLEU-4 {:.1f}\n",
        options.model, score.iteration, score.split, score.instructions, score.loss,
        score.perplexity, 100 * score.accuracy, 100 * score.bleu);
  }
}

// Evaluates a continuous agent.
void evaluate_continuous(const Options& options) {
  const std::string task = options.task.empty() ? "r2r-ce" : options.task;
  const tasks::Benchmark* named = tasks::find_benchmark(task);
  if (named == nullptr || !named->continuous()) {
    throw UsageError(
        fmt::format("--task {}: {} is a continuous agent, of r2r-ce", task, options.model));
  }
  if (!options.features.empty() || !options.objects.empty()) {
    throw UsageError("--features, --objects: not for a continuous agent");
  }
  for (const std::string& split : options.splits) {
    const OutputFolder out = options.output.empty() ? OutputFolder(options.model).folder("results")
                                                    : OutputFolder(options.output);
    const fs::path file = out.file(models::ModelFiles{}.results(split).filename().string());
    run_agent_over_split({.data = options.data,
                          .meshes = options.meshes,
                          .output = file.string(),
                          .agent = options.model,
                          .split = split,
                          .task = task,
                          .run = {.batch_size = options.batch_size},
                          .threads = options.threads});
  }
}

// No value: there is no model, which is reported later.
std::optional<models::AgentKind> kind_of(const Options& options) {
  const models::ModelFiles files{options.model};
  if (!fs::exists(files.config())) return std::nullopt;
  return models::load_model_config(files.config()).training.agent;
}

void evaluate_walker(const Options& options, const std::optional<neural::RankPlace>& place,
                     neural::Ranks& ranks) {
  const auto agent = neural::load_trained_agent(options.model, device_of(options.device, place));
  std::optional<features::FeatureSet> file;
  if (agent->config().training.network.inputs.vision && !options.features.empty()) {
    file = without_class_scores(features::FeatureSet::open(options.features),
                                agent->config().training.network.features);
  }
  const features::FeatureSet* features = usable_features(agent->config(), file ? &*file : nullptr);
  const std::vector<tasks::EpisodeSet> splits =
      load_splits(options, agent->config(), file ? &*file : nullptr);
  if (!options.objects.empty()) {
    agent->set_objects(
        std::make_shared<const features::ObjectSet>(features::ObjectSet::open(options.objects)));
  }
  for (const tasks::EpisodeSet& split : splits) {
    agent->enter(split, features);
    evaluate(options, *agent, split, ranks);
  }
}

void run(const Options& options) {
  const std::optional<neural::RankPlace> place = neural::find_place();
  neural::Ranks ranks = join_ranks(place, options.ranks, options.threads);
  const auto kind = kind_of(options);
  if (!ranks.alone() &&
      (kind == models::AgentKind::kSeq2SeqCe || kind == models::AgentKind::kSpeaker)) {
    throw UsageError(fmt::format("evaluate: the {} is evaluated by one process, not by {}",
                                 to_string(*kind), ranks.size()));
  }
  if (kind == models::AgentKind::kSeq2SeqCe) return evaluate_continuous(options);
  if (!options.meshes.empty()) throw UsageError("--meshes: for a continuous agent only");
  if (kind == models::AgentKind::kSpeaker) return evaluate_speaker(options);
  tell_failures(ranks, [&] { evaluate_walker(options, place, ranks); });
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("evaluate", kEvaluateHelp);
  const auto options = std::make_shared<Options>();
  add_value(verb, "model", options->model, "MODELDIR",
            "Model directory of `enfilade train`; speakers: prints perplexity and BLEU-4")
      ->required();
  add_data_option(verb, options->data);
  add_value(verb, "--features", options->features, "FILE",
            "Image features, if the agent uses vision");
  add_value(verb, "--objects", options->objects, "FILE",
            "Object features (HDF5), if the agent uses them: REVERIE, SOON");
  add_task_option(verb, options->task, "r2r, or what the data set has", Worlds::kBoth);
  add_value(verb, "--meshes", options->meshes, "DIR",
            "Continuous agents: folder of meshes SCAN.glb, .obj or .ply, instead of the data "
            "set's");
  add_setting(verb, "--split", options->splits, "NAMES", "train, val_seen, val_unseen, test, ...")
      ->delimiter(',');
  add_value(verb, "-o,--output", options->output, "DIR",
            "Folder for <split>.json, a results file, and <split>.attention.json (default: "
            "results/ in the model directory)");
  add_whole_number(verb, "--batch", options->batch_size, "Episodes at once");
  add_setting(verb, "--device", options->device, "", "cpu, cuda, cuda:1, ...");
  add_threads_option(verb, options->threads, "0: all cores, divided among the processes");
  add_rank_options(verb, options->ranks);
  set_examples(verb, {"enfilade evaluate student --features resnet.safetensors",
                      "torchrun --no-python --nproc-per-node 4 enfilade evaluate duet "
                      "--features vit.hdf5",
                      "enfilade evaluate submission --split test --features resnet.safetensors",
                      "enfilade evaluate ce --data homes --split val_unseen"});
  verb.callback([options] { run(*options); });
}

}  // namespace enfilade::apps::evaluate_verb
