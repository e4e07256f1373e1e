/// \file  A submission's scores in parts (by building, by path length, by episode), and two
/// submissions compared episode by episode. For phases with open goals only: of secret goals the
/// server gives away no more than leakage.h counts, which are means over a whole split.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

/// Whether a phase's scores are shown in parts: its goals are open, and the site shows those of its
/// split.
bool has_open_goals(const Site& site, const Phase& phase);

/// Scores by episode, computed at the first request for a submission and kept. One is computed at a
/// time. All functions may be called from any thread.
///
/// All of them \pre has_open_goals() of the phase, which is the submission's
/// \throws Refusal kConflict for a submission without a score, or that can no longer be scored
class Breakdowns {
 public:
  static constexpr std::size_t kWorst = 20;    ///< episodes that are listed
  static constexpr std::size_t kMostBins = 6;  ///< of path lengths

  /// \pre the submissions outlive *this
  Breakdowns(std::shared_ptr<const Site> site, const Submissions& submissions);
  ~Breakdowns();
  Breakdowns(const Breakdowns&) = delete;
  Breakdowns& operator=(const Breakdowns&) = delete;

  /// {"buildings": [{"scan", ...}], "lengths": [{"least", "most", ...}]}: both by name or length.
  /// Each part has "episodes", "groups" (how many the bootstrap draws from) and "means", as
  /// exact_means_json(). Lengths are those of reference paths, metres: from `least` to below
  /// `most`. Infinite ones are in no part.
  nlohmann::ordered_json parts(const Submission& submission, const Phase& phase);
  /// The kWorst episodes, or fewer: by the phase's primary metric, then by the navigation error.
  /// \returns [{"episode", "scan", "instruction", "values": {column: value or null}}], on graphs
  /// also "path" and "trajectory": viewpoint ids; [viewpoint id, heading, elevation], radians
  nlohmann::ordered_json worst(const Submission& submission, const Phase& phase);
  /// One of them. \throws Refusal kNotFound for an unknown episode
  nlohmann::ordered_json episode(const Submission& submission, const Phase& phase,
                                 std::string_view id);
  /// The paired bootstrap of `second` - `first`: {"first", "second", "episodes", "groups",
  /// "samples", "better", "worse", "means": {column: {"first", "second", "difference", "low",
  /// "high", "p"}}}. `better` and `worse` count the episodes in which the second's primary metric
  /// is larger or smaller.
  nlohmann::ordered_json compare(const Submission& first, const Submission& second,
                                 const Phase& phase);

 private:
  struct Scored;
  using SharedScored = std::shared_ptr<const Scored>;
  SharedScored scored(const Submission& submission, const Phase& phase);
  Scored score(const Submission& submission, const Phase& phase) const;

  std::shared_ptr<const Site> site_;
  const Submissions& submissions_;
  std::mutex scoring_;
  detail::OnceCache<std::int64_t, SharedScored> scored_;
};

}  // namespace enfilade::service::evaluation
