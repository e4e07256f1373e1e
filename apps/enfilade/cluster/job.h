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

/// A job. Shares may run in any order and on any machine that sees the same files; what they leave
/// is what one machine would have made.
struct ClusterJob {
  std::vector<Words> shares;
  Words collect = {};  ///< once all shares are done; empty: nothing is left to do

  /// {"program", "cwd", "shares", "collect"}: what engines read.
  std::string to_json() const;
};

/// What a verb is cut into. \param words  "features", "--data", ...: a verb that has --shard
/// \throws UsageError for another verb, or one that is cut already
ClusterJob job_of_verb(const Words& words, std::size_t shards);
/// A job of a file's lines, a command each, as one writes them behind `enfilade`; blank lines and
/// those with # are left out. \throws FileError; InvalidInput for none, or for quotes without end
ClusterJob job_of_commands(const std::filesystem::path& file);

/// What the verbs of all engines ask for.
struct JobOptions {
  std::size_t shards = 16, cpus = 1;
  std::string folder = "job", commands;
};
/// Adds them to a verb, whose other words are those of the verb that is cut.
void add_job_options(CLI::App& verb, JobOptions& options);
/// A job in its folder: FOLDER/plan.json says what it is, and FOLDER/done has a file for each share
/// that is done, so that a job which is begun again does the others only.
struct ClaimedJob {
  ClusterJob job;
  std::filesystem::path folder;  ///< absolute
};
/// Makes the folder. \pre the verb was parsed
/// \throws UsageError for a verb and commands at once, or a folder of another job; FileError; as
/// job_of_verb(), job_of_commands()
ClaimedJob claim_job(const CLI::App& verb, const JobOptions& options);

/// Where one share of a file's content goes: "features.safetensors" ->
/// "features.3-of-16.safetensors".
std::filesystem::path shard_file(const std::filesystem::path& file, const Shard& shard);

}  // namespace enfilade::apps
