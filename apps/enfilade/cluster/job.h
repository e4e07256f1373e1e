/// \file  Data jobs that many machines share: cut into shares here, run by an engine that exists.
#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/shard.h"

namespace enfilade::apps {

/// The words of a command, without the program.
using Words = std::vector<std::string>;

/// A job. Shards may run in any order and on any computer with the same files; their output
/// equals that of one computer.
struct ClusterJob {
  std::vector<Words> shares;
  Words collect = {};  ///< once all shares are done; empty: nothing is left to do

  /// {"program", "cwd", "shares", "collect"}: what engines read.
  std::string to_json() const;
};

/// The shards of a verb. \param words  "features", "--data", ...: a verb that has --shard
/// \throws UsageError for another verb, or one that has a shard already
ClusterJob job_of_verb(const Words& words, std::size_t shards);
/// A job of a file's lines, one command each, without the word `enfilade`. Blank lines and those
/// with # are skipped.
/// \throws FileError; InvalidInput for no command, or for an open quote
ClusterJob job_of_commands(const std::filesystem::path& file);

/// Options of the verbs of all engines.
struct JobOptions {
  std::size_t shards = 16, cpus = 1;
  std::string folder = "job", commands;
};
/// Adds them to a verb, whose other words are those of the sharded verb.
void add_job_options(CLI::App& verb, JobOptions& options);
/// A job in its folder. FOLDER/plan.json describes it, and FOLDER/done has a file for each finished
/// shard, so that a restarted job does only the others.
struct ClaimedJob {
  ClusterJob job;
  std::filesystem::path folder;  ///< absolute
};
/// Makes the folder. \pre the verb was parsed
/// \throws UsageError for a verb and commands at once, or a folder of another job; FileError; as
/// job_of_verb(), job_of_commands()
ClaimedJob claim_job(const CLI::App& verb, const JobOptions& options);

/// Output file of one shard: "features.safetensors" -> "features.3-of-16.safetensors".
std::filesystem::path shard_file(const std::filesystem::path& file, const Shard& shard);

}  // namespace enfilade::apps
