// enfilade study: success in unseen homes by the number of homes that an agent was trained in.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/learning/training_options.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/report/scaling_curve.h"
#include "enfilade/tasks/path_sampling.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps::study_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string output;
  std::vector<std::size_t> homes{10, 30, 100, 300};
  std::size_t seeds = 1;
  TrainingOptions training;
};

// How many homes leave `wanted` for training, by the shares of the splits.
std::size_t set_size(std::size_t wanted) {
  const tasks::SplitOptions split;
  const std::size_t all = split.train_scans + split.val_unseen_scans + split.test_scans;
  const double homes = static_cast<double>(wanted * all) / static_cast<double>(split.train_scans);
  // Shares are rounded, so that one more may be needed.
  return std::max<std::size_t>(static_cast<std::size_t>(std::ceil(homes)) + 1, 6);
}

// The whole study, a folder: each step goes on where it was, and does nothing when it is done.
class Study {
 public:
  explicit Study(const Options& options)
      : o_(options), config_(options.training.config()), folder_(options.output) {}

  int run() {
    // Of a killed run. A user's own files may be there.
    const OutputFolder out(folder_);
    for (const char* own : {"study.html", "study.svg"}) out.remove_unfinished({}, own);
    const std::size_t most = std::ranges::max(o_.homes);
    step({"homes", "-o", data(), "--preset", "training", "--homes", std::to_string(set_size(most)),
          "--tasks", "r2r"});
    if (!fs::exists(encoder())) step({"pretrain", "--data", data(), "-o", encoder().string()});
    if (!fs::exists(features())) {
      step({"features", "--data", data(), "--encoder", "home", "--weights", encoder().string(),
            "-o", features().string()});
    }
    for (const std::size_t homes : o_.homes) {
      for (std::size_t seed = 1; seed <= o_.seeds; ++seed) train(homes, seed);
    }
    if (status_ == kSuccess) write_page();
    return status_;
  }

 private:
  std::string data() const { return (folder_ / "homes").string(); }
  fs::path encoder() const { return folder_ / "encoder.safetensors"; }
  fs::path features() const { return folder_ / "features.safetensors"; }
  fs::path model(std::size_t homes, std::size_t seed) const {
    return folder_ / "models" / fmt::format("homes{}_seed{}", homes, seed);
  }

  void step(const std::vector<std::string>& words) {
    if (status_ == kSuccess) status_ = run_step(words);
  }

  void train(std::size_t homes, std::size_t seed) {
    std::vector<std::string> words{"train", "--data", data(), "--features", features().string()};
    words.insert(words.end(), {"-o", model(homes, seed).string()});
    words.insert(words.end(), {"--buildings", std::to_string(homes), "--validation", "val_unseen"});
    words.insert(words.end(), {"--evaluate-every", std::to_string(config_.iterations)});
    words.insert(words.end(), {"--seed", std::to_string(seed)});
    const std::vector<std::string> chosen = o_.training.words();
    words.insert(words.end(), chosen.begin(), chosen.end());
    step(words);
  }

  void write_page() const {
    const dataset::Dataset set(data());
    const tasks::EpisodeSet unseen = set.episodes("val_unseen");
    report::ScalingCurve curve{"Success by number of training homes", set.synthetic(), {}, {}, {}};
    say("\n{:>7}{:>6}  {:<24}{}\n", "homes", "seed", "SR (%)", "SPL (%)  val_unseen");
    for (const std::size_t homes : o_.homes) {
      for (std::size_t seed = 1; seed <= o_.seeds; ++seed) {
        const auto file = models::ModelFiles{model(homes, seed)}.results("val_unseen");
        const auto score = compute_score(load_results(file, unseen).trajectories, unseen);
        curve.points.push_back({homes, seed, score.mean("success"), score.mean("spl")});
        print(curve.points.back());
      }
    }
    const auto random = agents::make_agent("random");
    curve.random = compute_score(agents::run_agent(*random, unseen), unseen).mean("success");
    say("{:>13}  {:.1f} [{:.1f}, {:.1f}]\n", "random", 100 * curve.random->mean,
        100 * curve.random->low, 100 * curve.random->high);
    curve.facts = {
        {"agent", fmt::format("{}", to_string(config_.agent))},
        {"iterations", fmt::format("{} of {} episodes", config_.iterations, config_.batch_size)},
        {"options", fmt::format("{}", fmt::join(o_.training.words(), " "))},
        {"unseen episodes", std::to_string(unseen.episodes.size())},
        {"pictures", "one encoder for all, pretrained in all training homes"},
        {"machine", fmt::format("{}, {} cores", processor_name(), available_threads())},
        {"Enfilade", version_with_commit()}};
    const OutputFolder out(folder_);
    out.write("study.html", report::scaling_curve_page(curve));
    out.write("study.svg", report::scaling_curve_svg(curve));
    say("\nThe curve, one page for any browser: {}\n",
        fs::absolute(folder_ / "study.html").string());
  }

  static void print(const report::CurvePoint& point) {
    const auto text = [](const tasks::MeanInterval& value) {
      return fmt::format("{:.1f} [{:.1f}, {:.1f}]", 100 * value.mean, 100 * value.low,
                         100 * value.high);
    };
    say("{:>7}{:>6}  {:<24}{}\n", point.buildings, point.seed, text(point.success),
        text(point.spl));
  }

  const Options& o_;
  models::TrainConfig config_;
  fs::path folder_;
  int status_ = kSuccess;
};

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb =
      *app.add_subcommand("study", "Measure success in unseen homes by number of training homes");
  const auto options = std::make_shared<Options>();
  add_value(verb, "-o,--output", options->output, "DIR",
            "A new folder, or an interrupted study, which resumes")
      ->required();
  add_setting(verb, "--homes", options->homes, "N,...", "Training homes of each point",
              whole_number(1, 5000))
      ->delimiter(',');
  add_whole_number(verb, "--seeds", options->seeds, "Agents per point");
  // The study gives these itself, and its agents walk.
  options->training.add_to(verb, "small");
  for (const char* own : {"--seed", "--evaluate-every", "--stage", "--task"})
    options->training.leave_out(verb, own);
  set_examples(verb,
               {"enfilade study -o study --homes 10,30,100,300,1000",
                "enfilade study -o duet --agent duet --homes 10,30,100,300 --seeds 3",
                "enfilade study -o small --homes 3,6 --iterations 50 --batch 20"},
               "Each agent is trained in the first N of the same homes, and evaluated in the "
               "same unseen ones.\nSeeds, and points below the largest, can be added later; a "
               "larger one needs another folder.\nAll of it is synthetic, and says so.");
  verb.callback([options, &status] {
    if (!can_learn()) hand_over_to_learn();  // says what is missing
    std::ranges::sort(options->homes);
    const auto twice = std::ranges::unique(options->homes);
    options->homes.erase(twice.begin(), twice.end());
    status = Study(*options).run();
  });
}

}  // namespace enfilade::apps::study_verb
