/// \file  Submissions: checked when they are received, stored, and scored in the background.
#pragma once
#include <array>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/accounts/tokens.h"
#include "enfilade/service/evaluation/near_copies.h"
#include "enfilade/service/evaluation/scoring.h"
#include "enfilade/service/evaluation/shared_goals.h"
#include "enfilade/service/phases.h"
#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

enum class SubmissionState : std::uint8_t { kQueued, kScored, kFailed, kWithdrawn };
constexpr std::array<std::string_view, 4> names_of(SubmissionState /*enum*/) {
  return {"queued", "scored", "failed", "withdrawn"};
}

/// Links about a method: addresses that begin with https://, or empty.
struct Links {
  std::string paper, code;

  auto columns() { return std::tie(paper, code); }
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
  Links links;

  auto columns() {
    return std::tie(id, team, team_name, phase, method, state, created, score, approved, shown,
                    near_copy, links);
  }
};

/// The sender of a file, its phase and method.
struct Delivery {
  std::int64_t team = 0;
  std::string address;  ///< of the client
  std::string phase;
  std::string method;
  Links links;
};

/// How much is given away of the goals that a phase shares with others: see leakage.h.
struct Leakage {
  double most = 0;   ///< bits that the limits of all these phases allow, or used bits if more
  double used = 0;   ///< bits so far
  double goals = 0;  ///< bits of the goals themselves
  std::vector<std::string> phases;  ///< names of the phases that share the goals
};

/// The answer to a results file.
struct Receipt {
  Submission submission;
  std::vector<Diagnostic> warnings;
  bool known = false;  ///< the same file was submitted before: nothing was added
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
  Submissions(std::shared_ptr<const Site> site, store::Database& db, Report report = {});

  /// Checks a whole results file and queues it. A repeated file of the same team, phase and method
  /// is one submission, so that a client may repeat a request without a response. It is not checked
  /// again, and the receipt has no warnings.
  /// \throws InvalidInput with the faults of the file (up to 1000), which then counts as a refused
  /// one
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
  /// \pre the goals are secret
  Leakage leakage(const Phase& phase) const;
  /// How many of the phase's submissions are near-copies.
  std::int64_t count_near_copies(const Phase& phase) const;

 private:
  void work(const std::stop_token& stop);
  void wait_until_asked(const std::stop_token& stop);
  void wait_after_failure(const std::stop_token& stop);
  bool score_next();
  Judgement score(const Phase* phase, const std::string& results) const;
  void store_score(std::int64_t id, const Phase& phase, const Judgement& judged);
  std::int64_t find_same(const Delivery& delivery, const std::string& digest) const;
  void check_open(const Phase& phase, std::int64_t team) const;

  std::shared_ptr<const Site> site_;
  store::Database& db_;
  Report report_;
  SharedGoals goals_;
  std::mutex checking_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool asked_ = true;    // something may be queued
  std::jthread worker_;  // last: it uses the others
};

}  // namespace enfilade::service::evaluation
