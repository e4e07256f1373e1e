/// \file  Runs of the arena shown step by step: folders that `enfilade ask`, `enfilade mcp` and
/// Python's arena have written.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "enfilade/service/site.h"

namespace enfilade::service::playing {

/// The runs in a folder, read anew at each request, as they may still be written. All functions may
/// be called from any thread.
///
/// Only the model's input and output in a transcript are served, no other fields of a line. If
/// goals are hidden, an episode is served only if its id and its instruction are those of the
/// site's split. If a phase keeps goals secret, runs of splits that the site does not have are not
/// served. Names in requests are compared with those in folders, and never made into paths; links
/// inside a run are not followed.
class Replays {
 public:
  static constexpr std::size_t kMostRuns = 1000;                ///< that are listed
  static constexpr std::uintmax_t kMostBytes = 16ULL << 20ULL;  ///< of a transcript
  static constexpr std::size_t kMostLines = 10'000;             ///< of a transcript

  /// \param folder holds the folders of runs, or is one; empty: there are no runs
  /// \throws FileError if it is no folder
  Replays(std::shared_ptr<const Site> site, const std::filesystem::path& folder);

  /// {"runs": [{"run", "task", "split", "model", "prompt", "episodes", "problem"?}]}, by name;
  /// unknown values of a run are null.
  /// \param episode only runs that have it; empty: all
  nlohmann::ordered_json runs(std::string_view episode) const;
  /// As an entry of runs(), with "list": [{"episode", "ending", "steps", "mistakes"}, or
  /// {"episode", "problem"}].
  /// \throws Refusal kNotFound for an unknown run
  nlohmann::ordered_json run(std::string_view name, std::size_t offset, std::size_t limit) const;
  /// {"run", "task", "split", "model", "prompt", "episode", "instruction", "scan", "steps", "end",
  /// "place_problem"?}. A step has "observation", "call", "told", and optionally "text",
  /// "prompt_tokens", "answer_tokens" and "at". `at` is found by replaying the calls. It is left
  /// out from the first step on at which the replay differs; place_problem reports that.
  /// \throws Refusal kNotFound for an unknown run or episode; kInvalidInput for a transcript that
  /// cannot be read, naming file and line
  nlohmann::ordered_json episode(std::string_view run, std::string_view episode) const;

 private:
  struct Run;
  Run find(std::string_view name) const;

  std::shared_ptr<const Site> site_;
  std::filesystem::path folder_;
};

}  // namespace enfilade::service::playing
