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

/// The runs in a folder, read anew at each request: whoever writes them may go on. All functions
/// may be called from any thread.
///
/// Of a transcript only what the model got and gave is told; whatever else a line has stays where
/// it is. Where goals are hidden, an episode is shown only if its id and its instruction are those
/// of the site's split, and where a phase keeps goals secret, no run of a split that the site does
/// not have. Names that requests have are compared with those in folders, and no path is made of
/// them; links inside a run are not followed.
class Replays {
 public:
  static constexpr std::size_t kMostRuns = 1000;                ///< that are listed
  static constexpr std::uintmax_t kMostBytes = 16ULL << 20ULL;  ///< of a transcript
  static constexpr std::size_t kMostLines = 10'000;             ///< of a transcript

  /// \param folder holds the folders of runs, or is one; empty: there are no runs
  /// \throws FileError if it is no folder
  Replays(std::shared_ptr<const Site> site, const std::filesystem::path& folder);

  /// {"runs": [{"run", "task", "split", "model", "prompt", "episodes", "problem"?}]}, by name;
  /// what is not known of a run is null.
  /// \param episode only runs that have it; empty: all
  nlohmann::ordered_json runs(std::string_view episode) const;
  /// As an entry of runs(), with "list": [{"episode", "ending", "steps", "mistakes"}, or
  /// {"episode", "problem"}]. \throws Refusal kNotFound for a run that there is not
  nlohmann::ordered_json run(std::string_view name, std::size_t offset, std::size_t limit) const;
  /// {"run", "task", "split", "model", "prompt", "episode", "instruction", "scan", "steps", "end",
  /// "place_problem"?}. A step has "observation", "call", "told", and what there is of "text",
  /// "prompt_tokens", "answer_tokens" and "at". `at` is found by walking the calls again, and is
  /// left out from the first step on at which that comes out differently; place_problem says so.
  /// \throws Refusal kNotFound for what there is not; kInvalidInput for a transcript that cannot be
  /// read, naming file and line
  nlohmann::ordered_json episode(std::string_view run, std::string_view episode) const;

 private:
  struct Run;
  Run find(std::string_view name) const;

  std::shared_ptr<const Site> site_;
  std::filesystem::path folder_;
};

}  // namespace enfilade::service::playing
