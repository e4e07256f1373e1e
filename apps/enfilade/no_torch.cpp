// The verbs that need libtorch, in a build without it: they are there, and say what is missing.
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/trained_agent.h"
#include "apps/enfilade/verbs.h"

namespace enfilade::apps {
namespace {

constexpr const char* kMissing =
    ": this build has no libtorch. Build with -DEN_WITH_TORCH=ON, which needs libtorch-dev and "
    "libopenblas0-pthread";

void add_missing(CLI::App& app, const std::string& name, const std::string& what) {
  CLI::App& verb = *app.add_subcommand(name, what + " (not in this build: it has no libtorch)");
  verb.allow_extras();
  verb.callback([name] { throw UsageError(name + kMissing); });
}

}  // namespace

std::unique_ptr<agents::Agent> load_trained_agent(const std::string& folder,
                                                  const std::string& /*features*/,
                                                  const r2r::EpisodeSet& /*episodes*/) {
  throw UsageError(folder + kMissing);
}

void add_evaluate(CLI::App& app, int& /*status*/) {
  add_missing(app, "evaluate", "Walk a trained agent through splits");
}
void add_features(CLI::App& app, int& /*status*/) {
  add_missing(app, "features", "Compute image features");
}
void add_pretrain(CLI::App& app, int& /*status*/) {
  add_missing(app, "pretrain", "Train the small encoder");
}
void add_train(CLI::App& app, int& /*status*/) {
  add_missing(app, "train", "Train the sequence-to-sequence agent");
}

}  // namespace enfilade::apps
