/// \file  Data jobs that many machines share: cut into shares here, run by an engine that exists.
#pragma once
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

/// The one or the other, as the options of engines' verbs say it. \param commands empty: none
/// \throws UsageError for both; as these
ClusterJob job_of(const Words& words, std::size_t shards, const std::filesystem::path& commands);

/// Where one share of a file's content goes: "features.safetensors" ->
/// "features.3-of-16.safetensors".
std::filesystem::path shard_file(const std::filesystem::path& file, const Shard& shard);

/// Writes FOLDER/plan.json, and makes FOLDER/done, in which there is a file for each share that is
/// done: a job that is begun again does the others only.
/// \throws UsageError for a folder of another job; FileError
void claim_job_folder(const std::filesystem::path& folder, const ClusterJob& job);

}  // namespace enfilade::apps
