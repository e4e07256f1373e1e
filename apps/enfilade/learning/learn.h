/// \file  The second program, `enfilade-learn`: all verbs, and libtorch
/// (docs/design/learn-program.md).
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/enfilade/mesh_files.h"
#include "enfilade/agents/agent.h"
#include "enfilade/agents/continuous_agent.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::apps {

// One-line help of the verbs, for both programs.
inline constexpr const char* kEvaluateHelp =
    "Run a trained agent on whole splits and write its results";
inline constexpr const char* kFeaturesHelp = "Compute image features of each viewpoint's 36 views";
inline constexpr const char* kImportWeightsHelp =
    "Make a model directory of released weights: DUET, ScaleVLN, EnvDrop";
inline constexpr const char* kPretrainHelp =
    "Train the small encoder `home` for pictures of synthetic homes";
inline constexpr const char* kSpeakHelp =
    "Describe new paths with a trained speaker, for back-translation";
inline constexpr const char* kTrainHelp = "Train an agent or a speaker; an interrupted run resumes";

/// Advice if the second program is missing: wheels do not have it.
inline constexpr const char* kHowToLearn =
    "Build Enfilade with -DEN_WITH_TORCH=ON (libtorch-dev, libopenblas0-pthread, libhdf5-dev); or, "
    "in a Python environment that has PyTorch, in a clone of Enfilade or its unpacked source "
    "distribution: pip install --no-build-isolation ./packaging/learn (the package "
    "enfilade-learn). docs/installing.md tells more.";

/// Whether verbs that need libtorch work: true in `enfilade-learn`, and in `enfilade` if that lies
/// beside it.
bool can_learn();

/// In `enfilade`: replaces this process by `enfilade-learn` with the same command line. In
/// `enfilade-learn`: returns. \throws UsageError if !can_learn(); FileError if it cannot be started
void hand_over_to_learn();

/// State of libtorch here; no value in `enfilade`.
std::optional<neural::TorchReport> torch_report();

/// The agent of a model directory, for these episodes. Prints the differences between their data
/// and that of its training. In `enfilade`: hand_over_to_learn().
/// \param features file; empty: none
/// \throws ArgumentError if the model uses vision and has no features, or of another size; errors
/// of the files
std::unique_ptr<agents::Agent> load_trained_agent(const std::string& folder,
                                                  const std::string& features,
                                                  const tasks::EpisodeSet& episodes);

/// The same for a continuous agent.
/// \param meshes as in scene_of_scan()
/// \param threads of rendering, 0: all cores
/// \throws ArgumentError for a model of a graph agent; errors of the files
std::unique_ptr<agents::ContinuousAgent> load_continuous_agent(
    const std::string& folder, const dataset::Dataset& data, const MeshSource& meshes,
    const tasks::ContinuousEpisodes& episodes, int threads);

// Other verbs of this program as steps of a longer work.

/// Prints the command and runs it in a process of its own (libtorch is another program's). Prints
/// the seconds that it took.
/// \returns its exit code
/// \throws FileError if it cannot be started
int run_step(const std::vector<std::string>& words);

/// Runs the verbs `pretrain`, `features`, `train` (the panoramic agent), `table` and `report` over
/// a folder of synthetic homes, and prints each command line first. Existing output files that are
/// newer than their inputs stay. A stopped training is continued.
/// \returns the exit code of the first that failed, or 0
int learn_in_homes(const std::filesystem::path& homes, const std::filesystem::path& output);

// Verbs that run in several processes, train and evaluate: in `enfilade-learn`.

/// A user's options for the processes beside this one.
struct RankOptions {
  std::uint64_t timeout = 1800;  ///< seconds
};
/// Adds `--timeout`.
void add_rank_options(CLI::App& verb, RankOptions& options);

/// Sets the number of threads, connects the processes that the launcher started, and compares
/// program, libtorch, kind of processor and threads.
/// \param threads 0: this process's share of the computer's cores
/// \throws as Ranks, and Ranks::agree()
neural::Ranks join_ranks(const std::optional<neural::RankPlace>& place, const RankOptions& options,
                         int threads);

/// "cuda" becomes a card of its own for each process of a computer; a launcher may show a process
/// only its own card. The name of a card, and "cpu", do not change.
std::string device_of(const std::string& device, const std::optional<neural::RankPlace>& place);

}  // namespace enfilade::apps
