// The verbs that need libtorch in `enfilade`: they start `enfilade-learn`.
#include <fmt/format.h>
#include <unistd.h>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/file.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

fs::path learn_program() { return own_program().parent_path() / "enfilade-learn"; }

// The process's own command line, as CLI11 changes the one of main().
std::vector<std::string> own_arguments() {
  const std::string all = read_file("/proc/self/cmdline");
  std::vector<std::string> arguments;
  for (std::size_t at = 0; at < all.size(); at += arguments.back().size() + 1) {
    arguments.emplace_back(all.c_str() + at);
  }
  return arguments;
}

void add_elsewhere(CLI::App& app, const char* name, const char* what) {
  CLI::App& verb = *app.add_subcommand(name, what);
  // All arguments are passed on, --help too.
  verb.set_help_flag();
  verb.prefix_command();
  verb.callback([] { hand_over_to_learn(); });
}

}  // namespace

bool can_learn() { return access(learn_program().c_str(), X_OK) == 0; }

void hand_over_to_learn() {
  const fs::path program = learn_program();
  if (!can_learn()) {
    throw UsageError(
        fmt::format("this needs PyTorch's library, which is in the program {}: it is not there. {}",
                    program.string(), kHowToLearn));
  }
  // Threads of OpenMP that wait in a loop for their next small part keep BLAS's, and everybody
  // else's, from working: beside two busy programs pictures were encoded four times as slowly as
  // with threads that sleep at once. On an idle machine sleeping at once costs a quarter. Looking a
  // thousand times before they sleep costs a tenth idle and a quarter busy. Read when the library
  // is loaded, so it is too late in the other program.
  // NOLINTBEGIN(concurrency-mt-unsafe): before any thread
  if (std::getenv("OMP_WAIT_POLICY") == nullptr) setenv("GOMP_SPINCOUNT", "1000", 0);
  setenv("OMP_WAIT_POLICY", "passive", 0);
  // NOLINTEND(concurrency-mt-unsafe)
  const int error = become(program, own_arguments());
  throw FileError(fmt::format("{}: cannot be started: {}", program.string(), std::strerror(error)));
}

std::optional<neural::TorchReport> torch_report() { return std::nullopt; }

std::unique_ptr<agents::Agent> load_trained_agent(const std::string& /*folder*/,
                                                  const std::string& /*features*/,
                                                  const tasks::EpisodeSet& /*episodes*/) {
  hand_over_to_learn();
  return nullptr;  // not reached
}

std::unique_ptr<agents::ContinuousAgent> load_continuous_agent(
    const std::string& /*folder*/, const dataset::Dataset& /*data*/, const MeshSource& /*meshes*/,
    const tasks::ContinuousEpisodes& /*episodes*/, int /*threads*/) {
  hand_over_to_learn();
  return nullptr;  // not reached
}

void evaluate_verb::add(CLI::App& app, int&) { add_elsewhere(app, "evaluate", kEvaluateHelp); }
void features_verb::add(CLI::App& app, int&) { add_elsewhere(app, "features", kFeaturesHelp); }
void import_weights_verb::add(CLI::App& app, int&) {
  add_elsewhere(app, "import-weights", kImportWeightsHelp);
}
void pretrain_verb::add(CLI::App& app, int&) { add_elsewhere(app, "pretrain", kPretrainHelp); }
void speak_verb::add(CLI::App& app, int&) { add_elsewhere(app, "speak", kSpeakHelp); }
void train_verb::add(CLI::App& app, int&) { add_elsewhere(app, "train", kTrainHelp); }

}  // namespace enfilade::apps
