/// \file  Verbs that run in several processes: train and evaluate.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "enfilade/neural/ranks.h"

namespace enfilade::apps {

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
