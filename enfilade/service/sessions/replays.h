/// \file  Runs of the arena shown step by step: folders that `enfilade ask`, `enfilade mcp` and
/// Python's arena have written.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/sessions/known_episodes.h"
#include "enfilade/service/sessions/painters.h"
#include "enfilade/service/sessions/run_folder.h"
#include "enfilade/service/sessions/run_tables.h"
#include "enfilade/service/site.h"

namespace enfilade::service::sessions {

/// The runs in a folder, read anew at each request, as they may still be written. What is known of
/// a transcript is kept while the file stays as it is. All functions may be called from any thread.
///
/// A transcript's line is served with the model's input and output, the tokens and the reason of
/// the end, and no other field. If goals are hidden, an episode is served only if its id and its
/// instruction are those of the site's split, without its success. If a phase keeps goals secret,
/// runs of splits that the site does not have are not served. Names in requests are compared with
/// those in folders, and never made into paths; links inside a run are not followed.
class Replays {
 public:
  static constexpr std::size_t kMostRuns = 1000;  ///< that are listed

  /// \param folder holds the folders of runs, or is one; empty: there are no runs
  /// \param painters not null, unless there are no runs
  /// \throws FileError if it is no folder
  Replays(std::shared_ptr<const Site> site, const std::filesystem::path& folder,
          std::shared_ptr<Painters> painters);

  /// {"runs": [Run::to_json(), ...]}, by name; unknown values of a run are null.
  /// \param episode only runs that have it; empty: all
  nlohmann::ordered_json runs(std::string_view episode);
  /// As an entry of runs(), with episode_list(). \throws Refusal kNotFound for an unknown run; as
  /// episode_list()
  nlohmann::ordered_json run(std::string_view name, const EpisodeQuery& query);
  /// As an entry of runs(), with measures_json(). \throws Refusal kNotFound for an unknown run
  nlohmann::ordered_json measures(std::string_view name);
  /// compare_json() with "runs", a list of both. \throws Refusal kNotFound for an unknown run; as
  /// compare_json()
  nlohmann::ordered_json compare(std::string_view name, std::string_view other, std::size_t offset,
                                 std::size_t limit);
  /// {"run", "task", "split", "model", "prompt", "outcomes", "episode", "instruction", "scan",
  /// "steps", "end", "outcome"?, "place_problem"?}. A step has "observation", "call", "told", and
  /// optionally "text", "flaw", "prompt_tokens", "answer_tokens", "at" and "pictures". The last two
  /// are found by repeating the calls. They are left out from the first step on at which that comes
  /// out differently; place_problem reports that. `outcome` is that of outcome_json(), with
  /// "success" and "spl" by the benchmark's scorer. It is left out if goals are hidden.
  /// \throws Refusal kNotFound for an unknown run or episode; kInvalidInput for a transcript that
  /// cannot be read, naming file and line
  nlohmann::ordered_json episode(std::string_view run, std::string_view episode);
  /// Picture `number`, from 0, of step `step`, from 1, as the model saw it: JPEG. The last ones are
  /// kept, 64 MiB at most.
  /// \throws Refusal as episode(); kNotFound for a picture that was not sent, or that this site
  /// would draw differently
  std::shared_ptr<const std::string> picture(std::string_view run, std::string_view episode,
                                             std::size_t step, std::size_t number);

 private:
  Run find(std::string_view name);

  std::shared_ptr<const Site> site_;
  std::filesystem::path folder_;
  std::shared_ptr<Painters> painters_;
  SplitIndices indices_;
  KnownEpisodes known_;
  detail::OnceCache<std::string, std::shared_ptr<const std::string>> drawn_;  // by the order's key
};

}  // namespace enfilade::service::sessions
