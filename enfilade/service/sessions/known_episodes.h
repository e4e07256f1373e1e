/// \file  Outcomes of the episodes of runs, read from transcripts and kept by the files' times. The
/// benchmark's own scorer scores them where the site has the goals.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/sessions/run_folder.h"
#include "enfilade/service/sessions/transcripts.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::service::sessions {

/// Where a trajectory ended, and what its scorer says.
struct Outcome {
  std::string end;  ///< the last viewpoint's id
  /// The metrics of scorer_of(), in their order. Empty if the goal is hidden, or the transcript's
  /// instruction is another than the site's.
  std::vector<double> values = {};
  double goal_distance = 0;  ///< metres from its end to the goal, by tasks::judge(); with `values`
};

/// What is known of one episode of a run.
struct KnownEpisode {
  TranscriptSummary summary;  ///< without its `result`
  /// No value if the site does not have the split or the episode, or the result does not fit it.
  std::optional<Outcome> outcome = {};
};

/// The scorer of a split: its benchmark's first, as `enfilade ask` and `enfilade score` print it.
const tasks::Scorer& scorer_of(const PublicSplit& split);

/// An episode's value of one of the scorer's columns: a share from 0 to 1, or metres.
/// No value if it was not scored, or is not finite.
std::optional<double> value_of(const KnownEpisode& known, const tasks::Scorer& scorer,
                               const tasks::Measure& measure);

/// The three measures that lists have.
struct ShortScore {
  std::optional<bool> success = {};
  std::optional<double> spl = {};        ///< a share
  std::optional<double> nav_error = {};  ///< metres from the goal
};
/// The score of an episode. Empty for runs without outcomes (Run::has_outcomes()).
ShortScore score_of(const Run& run, const KnownEpisode& known);

/// An entry of a results file, with its path of the split alone.
struct ReadWalk {
  tasks::EpisodeSet episodes;
  tasks::Trajectory trajectory;
};
/// \param result JSON
/// \returns no value if it is not of this episode, or cannot be read
std::optional<ReadWalk> read_walk(const std::shared_ptr<const Site>& site,
                                  const EpisodePlace& place, const std::string& result);

/// Reads transcripts, and keeps what is known of them while the files stay as they are. At most
/// 64 MiB. Any thread.
class KnownEpisodes {
 public:
  explicit KnownEpisodes(std::shared_ptr<const Site> site);
  std::shared_ptr<const KnownEpisode> of(const Run& run, const NamedPath& transcript);

 private:
  std::shared_ptr<const KnownEpisode> read(const Run& run, const NamedPath& transcript) const;

  std::shared_ptr<const Site> site_;
  /// By the file's path, size and time, and the run's split.
  detail::OnceCache<std::string, std::shared_ptr<const KnownEpisode>> known_;
};

}  // namespace enfilade::service::sessions
