// How long a trained agent takes for a split, batch by batch on the CPU. The weights and features
// are random (SYNTHETIC): the time of a decision does not depend on them, the number of decisions
// does.
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <span>

#include "apps/common/program.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/tokenizer.h"
#include "tests/support/feature_files.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/untrained.h"

namespace {

using namespace enfilade;
namespace fs = std::filesystem;

constexpr std::size_t kPieces = 30'522;  // bert-base-uncased's

struct Options {
  std::string data, split = "val_unseen", preset = "duet";
  std::size_t episodes = 64, batch = 8;
  int threads = 2;
};

// Whole words as pieces, and pieces that no text has.
void write_pieces(const tasks::EpisodeSet& episodes, const fs::path& file) {
  std::vector<std::string> texts;
  for (const tasks::Episode& episode : episodes.episodes) texts.push_back(episode.text);
  std::string pieces = "[PAD]\n[UNK]\n[CLS]\n[SEP]\n[MASK]\n";
  auto n = static_cast<std::size_t>(std::ranges::count(pieces, '\n'));
  constexpr std::size_t kMarks = 3;
  const tasks::Vocabulary words = tasks::Vocabulary::build(texts, 1);
  for (std::size_t i = kMarks; i < words.size() && n < kPieces; ++i, ++n) {
    pieces += words.words()[i] + "\n";
  }
  for (; n < kPieces; ++n) pieces += fmt::format("[unused{}]\n", n);
  write_file_atomically(file, pieces);
}

// The first episodes, evenly from the whole.
tasks::EpisodeSet some_of(tasks::EpisodeSet episodes, std::size_t n) {
  std::vector<tasks::Episode> some;
  n = std::min(n, episodes.episodes.size());
  for (std::size_t i = 0; i < n; ++i) {
    some.push_back(episodes.episodes[i * episodes.episodes.size() / n]);
  }
  episodes.episodes = std::move(some);
  return episodes;
}

void run(const Options& options) {
  neural::set_threads(options.threads);
  const dataset::Dataset data = apps::open_data(options.data);
  const tasks::EpisodeSet all = data.episodes(options.split);
  const tasks::EpisodeSet episodes = some_of(all, options.episodes);
  const tests::TemporaryFolder folder("bench_walks");
  models::ModelConfig config;
  config.training = models::recipe(models::AgentKind::kDuet);
  config.training.duet = models::duet_preset(options.preset);
  config.training.text = models::TextKind::kWordPieces;
  config.training.network.vocabulary = kPieces;
  config.training.network.features = static_cast<std::size_t>(config.training.duet.image);
  tests::write_untrained(config, folder.path());
  write_pieces(all, models::ModelFiles{folder.path()}.text(config.training.text));
  const fs::path file = folder.path() / "f.safetensors";
  Rng rng(1);
  tests::write_feature_file(file, config.training.network.features, tests::keys_of(episodes),
                            [&](const features::FeatureKey&, std::span<float> out) {
                              for (float& x : out) x = static_cast<float>(rng.uniform() - 0.5);
                            });
  const auto views = features::FeatureSet::open(file);
  const auto agent = neural::load_trained_agent(folder.path());
  agent->enter(episodes, &views);
  const apps::Stopwatch watch;
  const auto walks = agent->walk({options.batch, {}, {}});
  const double seconds = watch.seconds();
  std::size_t decisions = 0;
  for (const tasks::Trajectory& walk : walks) decisions += walk.actions.value_or(0) + 1;
  const double each = seconds / static_cast<double>(walks.size());
  fmt::print(
      "{}: {} episodes of {}, {} at once, {} threads: {:.1f} s, {:.3f} s an episode, {:.1f} "
      "decisions each, {:.4f} s a decision; all {} episodes: {:.1f} min\n",
      options.preset, walks.size(), options.split, options.batch, options.threads, seconds, each,
      static_cast<double>(decisions) / static_cast<double>(walks.size()),
      seconds / static_cast<double>(decisions), all.episodes.size(),
      each * static_cast<double>(all.episodes.size()) / 60);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Time of DUET's walks over a split, with random weights and features.");
  Options options;
  int status = apps::kSuccess;
  apps::add_data_option(app, options.data);
  apps::add_setting(app, "--split", options.split, "NAME", "of the data set");
  apps::add_setting(app, "--preset", options.preset, "NAME", "duet or duet-s");
  apps::add_whole_number(app, "--episodes", options.episodes, "Episodes, evenly from the split");
  apps::add_whole_number(app, "--batch", options.batch, "Episodes at once");
  apps::add_threads_option(app, options.threads);
  app.callback([&] { run(options); });
  return apps::run_program(app, argc, argv, status);
}
