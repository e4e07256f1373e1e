/// \file  Episodes for language models and assistants: a split of any benchmark, its pictures, and
/// the options of the verbs that walk it.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "enfilade/arena/mcp.h"
#include "enfilade/arena/pictures.h"
#include "enfilade/arena/words.h"
#include "enfilade/arena/world.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::apps {

/// A split for sessions.
struct OpenedWorld {
  std::unique_ptr<arena::World> world;
  arena::ViewSources sights;
  std::string title;  ///< of the benchmark
};
/// Makes words of a world's pictures.
using WordsMaker = std::function<arena::WordsSource(const arena::ViewSources&)>;
/// \param task as in --task \param words empty: none
/// \throws as benchmark_of(), dataset::Dataset::split(), arena::FloorWorld
OpenedWorld open_world(const std::shared_ptr<const dataset::Dataset>& data, const std::string& task,
                       const std::string& split, const WordsMaker& words = {});

/// Adds `--subset N|FILE|all`, which arena::subset_named() reads.
void add_subset_option(CLI::App& verb, std::string& subset);
/// Adds `--steps N`; 0: as the benchmark has it.
void add_steps_option(CLI::App& verb, std::uint32_t& steps);
/// The limits that it gives.
arena::SessionLimits limits_of(const arena::World& world, std::uint32_t steps);

/// `enfilade mcp --port`: listens until SIGINT or SIGTERM. \param done how far the episodes are,
/// for people \throws UsageError in a build without HTTP; as arena::McpHttp
void serve_mcp_over_http(arena::McpServer& server, int port, const std::string& done);

}  // namespace enfilade::apps
