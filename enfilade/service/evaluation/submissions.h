/// \file  Submissions: checked when they are received, stored, and scored in the background. Scores
/// for clients: only means over a whole split leave the server, as the navigation error of one
/// episode would give its goal away. With secret goals, leakage.h bounds the shown means. Nothing
/// else may depend on goals: not the order of rows, not the time of a response's change.
#pragma once
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/accounts/tokens.h"
#include "enfilade/service/evaluation/ledger.h"
#include "enfilade/service/phases.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/split.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::evaluation {

/// The result of scoring a file.
struct ScoredSubmission {
  std::string score;   ///< as Submission::score
  double primary = 0;  ///< the mean of the phase's primary metric: shares from 0 to 1; may be NaN
  std::string ends;    ///< trajectory_ends()
};

/// Checks a whole file. \param episodes of the phase \returns its warnings
/// \throws InvalidInput with its faults (up to 1000). For continuous trajectories also for steps
/// that are longer, or more actions, than the benchmark allows. The public scorers check neither,
/// and would accept a jump to the goal.
std::vector<Diagnostic> check_results(const SecretEpisodes& episodes, const std::string& results);
/// Whether a fault is an id that the split does not have.
bool is_unknown_episode(const Diagnostic& fault);
/// Whether a results file names no episode but those of `split`, whatever other faults it has. The
/// answer depends on the ids alone, which the split's public file has too.
bool names_episodes_of(const tasks::Split& split, const std::string& results);
/// \throws as check_results()
ScoredSubmission score_results(const Phase& phase, const SecretEpisodes& episodes,
                               const std::string& results);

// Submissions that equal an earlier one in all but a few episodes. Goals can be read from scores by
// small changes, so organisers are notified. Teams are not, and nothing is refused: tuning a method
// may give such files too.

/// The end and the answer (an object, a turning point, a point in the panorama) of each trajectory,
/// as hashes of 4 bytes, in order. Success, navigation error and grounding depend on nothing else
/// of it. Detours, turns and another order of the file change nothing. The bytes of two files on
/// the same graphs can be compared. Continuous trajectories have their end to a quarter of a metre,
/// a step's length, and whether the agent stopped there.
std::string trajectory_ends(const tasks::Trajectories& trajectories);

/// How many episodes end elsewhere; none if the two are of different numbers of episodes.
std::optional<std::size_t> count_differing(std::string_view ends, std::string_view other);

/// An earlier submission, of whatever team, and how many episodes end elsewhere.
struct NearCopy {
  std::int64_t of = 0;
  std::int64_t differing = 0;
  auto columns() { return std::tie(of, differing); }
};

/// The nearest of the submissions before `id` in these phases, the first of several; no value if
/// there is no near-copy. In one, 5 episodes or 2 % may differ, whichever is more, but no more than
/// a quarter.
/// \param phases whose files can be compared: they have the same episodes
std::optional<NearCopy> find_near_copy(store::Database& db, const std::vector<std::string>& phases,
                                       std::int64_t id, std::string_view ends);

enum class SubmissionState : std::uint8_t { kQueued, kScored, kFailed, kWithdrawn };
constexpr std::array<std::string_view, 4> names_of(SubmissionState /*enum*/) {
  return {"queued", "scored", "failed", "withdrawn"};
}

/// Links about a method: addresses that begin with https://, or empty.
struct MethodLinks {
  std::string paper, code;

  auto columns() { return std::tie(paper, code); }
};

/// Whether others can have a method's weights, as its team says.
enum class Weights : std::uint8_t { kUnsaid, kOpen, kClosed };
constexpr std::array<std::string_view, 3> names_of(Weights /*enum*/) {
  return {"unsaid", "open", "closed"};
}

/// What a team says of the method of a submission. All of it is optional.
struct MethodDescription {
  static constexpr std::size_t kLongest = 5000;  ///< characters of a text

  std::string text;    ///< Markdown
  std::string bibtex;  ///< entries to cite
  MethodLinks links;
  Weights weights = Weights::kUnsaid;
  /// Whether everybody may see the submission's trajectories, and how each of them is scored.
  bool walks_public = false;

  auto columns() { return std::tie(text, bibtex, links, weights, walks_public); }
};

/// A submission without its results file.
struct Submission {
  std::int64_t id = 0;
  std::int64_t team = 0;
  std::string team_name, phase, method;
  SubmissionState state = SubmissionState::kQueued;
  std::int64_t created = 0;
  /// tasks::to_record() of its ScoreTable; empty unless scored.
  std::string score;
  bool approved = false;        ///< its team is
  std::optional<double> shown;  ///< the score on the ladder; no value without an improvement
  NearCopy near_copy;           ///< of an earlier submission; of 0: no near copy
  MethodLinks links;
  Weights weights = Weights::kUnsaid;
  bool walks_public = false;  ///< as MethodDescription::walks_public

  auto columns() {
    return std::tie(id, team, team_name, phase, method, state, created, score, approved, shown,
                    near_copy, links, weights, walks_public);
  }
};

/// The sender of a file, its phase and method.
struct Delivery {
  std::int64_t team = 0;
  std::string address;  ///< of the client
  std::string phase;
  std::string method;
  MethodLinks links;
};

/// The answer to a results file.
struct Receipt {
  Submission submission;
  std::vector<Diagnostic> warnings;
  bool known = false;  ///< the same file was submitted before: nothing was added
};

/// A results file of another split than its phase's: one fault "other-split" in place of one for
/// each entry.
class OtherSplit : public InvalidInput {
 public:
  /// \param sent to which phase  \param right whose split's episodes the file names
  OtherSplit(const Phase& sent, const Phase& right);
  /// The name of the phase that the file can be sent to.
  const std::string& phase() const noexcept { return phase_; }

 private:
  std::string phase_;
};

/// All functions may be called from any thread. Acknowledged files are on the disk; queued
/// ones are scored after a restart.
class Submissions {
 public:
  using Report = std::function<void(std::string_view fault)>;

  /// Starts the thread that scores. The destructor waits for the submission that is being scored;
  /// the others stay queued. \pre the database outlives *this
  /// \param report called by that thread when the database fails; it then waits, and tries again.
  /// Must not throw; may be empty
  /// \throws as Ledger
  Submissions(std::shared_ptr<const Site> site, store::Database& db, Report report = {},
              Leaks leaks = Leaks::kRefused);

  /// Checks a whole results file and queues it. A repeated file of the same team, phase and method
  /// is one submission, so that a client may repeat a request without a response. It is not checked
  /// again, and the receipt has no warnings.
  /// \throws InvalidInput with the faults of the file (up to 1000), which then counts as a refused
  /// one
  /// \throws OtherSplit if all its ids are of another phase of the benchmark that is open
  /// \throws Refusal
  /// - kNotFound for an unknown phase
  /// - kInvalidInput for a bad name or link of the method
  /// - kForbidden if the goals are secret and the team is not approved, or the phase has its teams
  /// - kConflict after the phase's end
  /// - kRateLimited past one of its limits
  Receipt receive(const Delivery& delivery, const std::string& results);
  /// A team's, or with team 0 all teams', newest first: the first 500 whose id is below `before`.
  std::vector<Submission> list(std::int64_t team, std::int64_t before) const;
  std::optional<Submission> find(std::int64_t id) const;
  /// Takes it off the leaderboard, for good; it still counts for the limits.
  /// \throws Refusal kNotFound if it isn't the team's
  /// \throws Refusal kConflict if it was withdrawn before, or if its goals are secret and the phase
  /// has ended: the team's next best would be shown instead
  void withdraw(std::int64_t team, std::int64_t id);
  /// What its team says of its method. \pre there is such a submission
  MethodDescription description(std::int64_t id) const;
  /// Replaces it. \pre there is such a submission
  /// \throws Refusal kInvalidInput for a bad text or link; kConflict for trajectories of secret
  /// goals, which are never shown
  void describe(const Submission& submission, const MethodDescription& description);
  /// Its results file. \pre there is such a submission
  std::string results(std::int64_t id) const;
  /// Scored submissions of a phase, oldest first.
  std::vector<Submission> scored(const Phase& phase) const;
  std::int64_t queued() const;

  /// Whether the phase takes no more submissions.
  bool has_ended(const Phase& phase) const;
  /// Whether the last scores of a phase with secret goals may be shown. They are not hidden for
  /// good, the phase has ended, and all its submissions are scored. The first time that this is so
  /// is stored. From then on the phase has ended for any clock and file of phases: the last scores
  /// must not help with another submission.
  bool is_final(const Phase& phase) const;
  /// Ledger::leakage(); rows that can be seen from now on count.
  std::map<std::string, Leakage> leakage() const;
  const Ledger& ledger() const noexcept { return ledger_; }
  /// How many of the phase's submissions are near-copies.
  std::int64_t count_near_copies(const Phase& phase) const;

 private:
  void work(const std::stop_token& stop);
  bool score_next();
  void store_score(std::int64_t id, const Phase& phase, const ScoredSubmission& judged);
  std::int64_t find_same(const Delivery& delivery, const std::string& digest) const;
  const Phase* find_right_phase(const Phase& sent, const std::string& results) const;
  void check_open(const Phase& phase, std::int64_t team) const;

  std::shared_ptr<const Site> site_;
  store::Database& db_;
  Report report_;
  Ledger ledger_;
  mutable std::map<std::string, std::atomic<bool>> final_;  // by phase: is_final() was true
  std::mutex checking_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool asked_ = true;    // something may be queued
  std::jthread worker_;  // last: it uses the others
};

/// How much of a phase's scores a client may see.
enum class Visibility : std::uint8_t {
  kNothing,       ///< not even that a submission is scored: how long that took depends on goals
  kImprovements,  ///< scores shown on a ladder
  kBestRows,      ///< each team's best submission, its means rounded, without intervals
  kAll,
};

/// A phase as one client sees it now.
struct PhaseView {
  Visibility visibility = Visibility::kNothing;
  /// The phase's rules; null: a phase that is no longer there, of which nothing is seen but by
  /// organisers.
  const Phase* phase = nullptr;
};
/// \param role of the client; no value for strangers  \param is_final Submissions::is_final()
PhaseView view_of(const Phase* phase, std::optional<accounts::ClientRole> role, bool is_final);

/// The submission that represents each team, in the order of the leaderboard. It is the best by the
/// primary metric, or with a ladder the last improvement; the first of several. Rows are sorted by
/// the shown values, older ones first if equal. With secret goals, only approved teams.
/// \param scored of one phase, oldest first
/// \param all every submission instead of each team's best; only where all scores are seen
/// \pre visibility is not kNothing
std::vector<Submission> best_submissions(const std::vector<Submission>& scored,
                                         const PhaseView& view, bool all = false);

/// All means of a score with their intervals, as a client sees them who may see everything: shares
/// from 0 to 1, metres.
nlohmann::ordered_json exact_means_json(const tasks::ScoreTable& score);

/// The stored score of a submission; no value without one, and if the phase had another benchmark
/// or scorer then.
std::optional<tasks::ScoreTable> score_of(const Submission& submission, const Phase& phase);

/// With "means" as far as the client may see them, shares from 0 to 1 in any scorer's units.
/// Otherwise "withheld" gives the reason: "until-end", "no-improvement", "not-best", "hidden", or
/// "other-scorer" if the phase had another task or scorer when it was scored.
/// \param stands_for_team whether it is among best_submissions(); used for kBestRows
nlohmann::ordered_json submission_json(const Submission& submission, const PhaseView& view,
                                       bool stands_for_team);

/// The columns that the rows' means have, in their order: [{"name", "short", "title", "unit": "m"
/// or "share", "better"?: "higher" or "lower"}].
nlohmann::ordered_json columns_json(const Phase& phase);
/// Rows that others have published of the phase's benchmark and split: [{"agent", "source",
/// "means"}], with "means" as submission_json(), without intervals. None for synthetic buildings.
/// \param episodes of the split
nlohmann::ordered_json published_json(const Phase& phase, std::size_t episodes, bool synthetic);
/// Submissions, as submission_json(), as a sheet, with the ends of the intervals where they are
/// seen.
std::string leaderboard_csv(const nlohmann::ordered_json& rows, const Phase& phase);

}  // namespace enfilade::service::evaluation
