// enfilade train: an agent that learns.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <unistd.h>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/learning/training_options.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/neural/continuous_agent.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/train.h"

namespace enfilade::apps::train_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, features, output, from, device = "cpu", precision = "float32";
  std::string encoder = "home", weights, meshes;  // of the continuous agent
  int threads = 0;
  TrainingOptions training;
  std::vector<std::string> splits{"train"}, validation{"val_seen", "val_unseen"};
  std::optional<std::size_t> buildings;
  RankOptions ranks;
  bool all_reduce = false;
};

std::string duration(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  if (seconds < 90 * 60) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

// What training says, on the terminal: a line an evaluation, and one that is written over.
class Reporter {
 public:
  Reporter(const std::string& name, std::string output)
      : name_(printable(name)), output_(std::move(output)), live_(isatty(STDERR_FILENO) != 0) {}

  neural::TrainingListener listener() {
    return {[this](std::uint64_t iteration) {
              say("{}: going on from iteration {}\n", output_, iteration);
            },
            [this](const neural::TrainingProgress& progress) { show(progress); },
            [this](const models::EvaluationRecord& record) { show(record); },
            [this](const models::SpeakerRecord& record) { show(record); },
            [this](const neural::GatheringProgress& progress) { show(progress); }};
  }
  double data_share() const { return progress_.data_share; }

 private:
  void show(const neural::TrainingProgress& progress) {
    progress_ = progress;
    if (!live_) return;
    fmt::print(stderr, "\r{}: {} of {}, loss {:.3f}{}, {} left\033[K", name_, progress.iteration,
               progress.iterations, progress.loss, success_, duration(progress.seconds_left));
  }

  void show(const neural::GatheringProgress& gathering) {
    if (live_) {
      fmt::print(stderr, "\r{}: set {} of {}, walk {} of {}\033[K", name_, gathering.set,
                 gathering.sets, gathering.walks, gathering.total);
    }
    if (gathering.walks < gathering.total) return;
    if (live_) fmt::print(stderr, "\r\033[K");
    say("set {} of {}: {} walks; train loss {:.3f}, {}\n", gathering.set, gathering.sets,
        gathering.total, progress_.loss, duration(clock_.seconds()));
    std::fflush(stdout);
  }

  void show(const models::EvaluationRecord& record) {
    if (live_) fmt::print(stderr, "\r\033[K");
    if (record.iteration != evaluated_) success_ = ", success";
    evaluated_ = record.iteration;
    success_ += fmt::format(" {:.1f}", 100 * record.success_rate);
    say("{:>7}  {:<12} loss {:.3f}  TL {:5.2f}  NE {:5.2f}  SR {:4.1f}  OSR {:4.1f}  "
        "SPL {:4.1f}   train loss {:.3f}, {} left\n",
        record.iteration, record.split, record.loss, record.trajectory_length, record.nav_error,
        100 * record.success_rate, 100 * record.oracle_success_rate, 100 * record.spl,
        progress_.loss, duration(progress_.seconds_left));
    std::fflush(stdout);
  }

  void show(const models::SpeakerRecord& record) {
    if (live_) fmt::print(stderr, "\r\033[K");
    say("{:>7}  {:<12} loss {:.3f}  perplexity {:.2f}  words {:4.1f}  BLEU-4 {:4.1f}   train loss "
        "{:.3f}, {} left\n",
        record.iteration, record.split, record.loss, record.perplexity, 100 * record.accuracy,
        100 * record.bleu, progress_.loss, duration(progress_.seconds_left));
    std::fflush(stdout);
  }

  std::string name_, output_;
  bool live_;
  Stopwatch clock_;
  neural::TrainingProgress progress_;
  std::uint64_t evaluated_ = 0;
  std::string success_;
};

models::TrainConfig config_of(const Options& options) {
  models::TrainConfig config = options.training.config();
  config.splits = options.splits;
  config.validation = options.validation;
  config.buildings = options.buildings;
  validate(config);
  return config;
}

// What an iteration frees the next one takes again: without this a tenth of a Transformer's
// training went into the allocator.
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 64 << 20);
}

// Training data of a continuous agent.
neural::TrainingData load_continuous_training(const Options& options,
                                              const models::TrainConfig& config,
                                              const dataset::Dataset& data) {
  neural::ContinuousSight sight{.scene_of = {}, .encoder = {}, .threads = options.threads};
  if (!options.features.empty()) {
    throw UsageError(
        "train: --features: pictures of the graph's viewpoints; --task r2r-ce draws its own, and "
        "takes --weights");
  }
  if (config.network.inputs.vision) {
    if (options.weights.empty()) {
      throw UsageError(
          "train: --weights FILE is needed, of --encoder (`enfilade pretrain` makes that of home), "
          "or --inputs language for an agent that does not see");
    }
    sight.encoder.name = options.encoder;
    sight.encoder.weights = options.weights;
    sight.encoder.preprocessing = neural::Preprocessing::kTorchvision;
    sight.scene_of = [&options, data](const std::string& scan) {
      return scene_of_scan(data, {.folder = options.meshes}, scan, options.threads);
    };
  }
  return neural::load_continuous_data(
      data.folder(), agents::continuous_setup(options.training.task()), config, sight);
}

void refuse_continuous_options(const Options& options) {
  for (const auto& [name, value] :
       {std::pair("--weights", options.weights), std::pair("--meshes", options.meshes)}) {
    if (!value.empty()) throw UsageError(fmt::format("train: {}: of --task r2r-ce alone", name));
  }
}

neural::TrainingData load_data(const Options& options, const models::TrainConfig& config) {
  const dataset::Dataset root = open_data(options.data);
  if (config.agent == models::AgentKind::kSeq2SeqCe)
    return load_continuous_training(options, config, root);
  refuse_continuous_options(options);
  std::optional<fs::path> features;
  if (config.network.inputs.vision) {
    if (options.features.empty()) {
      throw UsageError(
          "train: --features FILE is needed (`enfilade features` makes it), or --inputs language "
          "for an agent that does not see");
    }
    features = options.features;
  }
  return neural::load_training_data(root, config, features);
}

// The default parts of a batch.
std::optional<std::size_t> parts_of(const Options& options, const neural::Ranks& ranks,
                                    bool launched) {
  if (options.all_reduce) return 0;
  const fs::path config = models::ModelFiles{options.output}.config();
  if (fs::exists(config)) return models::load_model_config(config).training.parts;
  if (!launched) return std::nullopt;
  return neural::usual_parts(ranks.size());
}

void train(const Options& options, const std::optional<neural::RankPlace>& place,
           neural::Ranks& ranks) {
  models::TrainConfig config = config_of(options);
  if (!config.parts) config.parts = parts_of(options, ranks, place.has_value());
  const neural::TrainingData data = load_data(options, config);
  if (const neural::ContinuousData* const continuous = data.continuous()) {
    fix_updates(config, continuous->training.episodes.size());
  }
  Reporter reporter(fs::path(options.output).filename().string(), options.output);
  std::optional<fs::path> from;
  if (!options.from.empty()) from = options.from;
  const neural::Computing computing{
      device_of(options.device, place),
      models::parse_name<neural::Precision>("precision", options.precision), &ranks};
  const neural::TrainingListener listener =
      ranks.is_first() ? reporter.listener() : neural::TrainingListener();
  const bool trained = neural::train(config, data, options.output, computing, listener, from);
  if (!ranks.is_first()) return;
  if (!trained) {
    say("{}: complete, {} iterations\n", options.output, config.iterations);
    return;
  }
  say("{}: trained, {} iterations; environment and data took {:.1f} % of training\n",
      options.output, config.iterations, 100 * reporter.data_share());
}

void run(const Options& options) {
  keep_freed_memory();
  const std::optional<neural::RankPlace> place = neural::find_place();
  neural::Ranks ranks = join_ranks(place, options.ranks, options.threads);
  tell_failures(ranks, [&] { train(options, place, ranks); });
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("train", kTrainHelp);
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_value(verb, "--features", options->features, "FILE",
            "Image features (made by `enfilade features`)");
  add_setting(verb, "--encoder", options->encoder, "NAME",
              fmt::format("r2r-ce: image encoder: {}", fmt::join(neural::encoder_names(), ", ")));
  add_value(verb, "--weights", options->weights, "FILE",
            "r2r-ce: encoder's weights, constant, copied into the model directory");
  add_value(verb, "--meshes", options->meshes, "DIR",
            "r2r-ce: folder of meshes SCAN.glb, .obj or .ply, instead of the data set's");
  add_value(verb, "-o,--output", options->output, "MODELDIR",
            "Model directory; an existing one resumes from its last checkpoint")
      ->required();
  add_value(verb, "--from", options->from, "MODELDIR",
            "duet: start from this model's weights and vocabulary, of equal sizes");
  add_setting(verb, "--splits", options->splits, "",
              "Splits for training and vocabulary; for the test submission "
              "train,val_seen,val_unseen")
      ->delimiter(',');
  add_value(verb, "--buildings", options->buildings, "N",
            "Train in the first N buildings of the splits (default: all)")
      ->check(whole_number(1));
  add_setting(verb, "--validation", options->validation, "", "Validation splits")->delimiter(',');
  options->training.add_to(verb);
  add_setting(verb, "--device", options->device, "", "cpu, cuda, cuda:1, ...");
  add_setting(verb, "--precision", options->precision, "",
              "GPU matrix products: float32, tf32 or bfloat16 (not seq2seq)")
      ->check(CLI::IsMember({"float32", "tf32", "bfloat16"}));
  add_threads_option(verb, options->threads, "0: all cores, divided among the processes");
  auto* const all_reduce =
      verb.add_flag("--all-reduce", options->all_reduce,
                    "Several processes: faster, but the weights depend on their number");
  all_reduce->excludes(verb.get_option("--parts"));
  add_rank_options(verb, options->ranks);
  set_examples(
      verb,
      {"enfilade train --data DIR --features resnet.safetensors -o student",
       "enfilade train --feedback teacher --inputs language -o language-only",
       "enfilade train --agent panoramic --features vit.safetensors -o panoramic",
       "enfilade train --agent duet --recipe small --data homes --features home.hdf5 -o duet",
       "enfilade train --agent duet --stage pretrain --features vit.hdf5 -o pretrained",
       "enfilade train --agent duet --from pretrained --features vit.hdf5 -o duet",
       "enfilade train --task r2r-ce --recipe small --data homes --weights encoder.safetensors "
       "-o ce",
       "enfilade train --agent speaker --features vit.safetensors -o speaker",
       "torchrun --no-python --nproc-per-node 4 enfilade train --features f.hdf5 -o student",
       "srun --ntasks 8 enfilade train --agent duet --features vit.hdf5 -o duet",
       "enfilade train --splits train,val_seen,val_unseen --features f.hdf5 -o submission"});
  verb.callback([options] { run(*options); });
}

}  // namespace enfilade::apps::train_verb
