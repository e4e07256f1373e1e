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
#include "enfilade/service/phases.h"
#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

enum class SubmissionState : std::uint8_t { kQueued, kScored, kFailed, kWithdrawn };
constexpr std::array<std::string_view, 4> names_of(SubmissionState /*enum*/) {
  return {"queued", "scored", "failed", "withdrawn"};
}

/// A submission without its results file.
struct Submission {
  std::int64_t id = 0;
  std::int64_t team = 0;
  std::string team_name, phase, method;
  SubmissionState state = SubmissionState::kQueued;
  std::int64_t created = 0;
  std::string score;  ///< r2r::to_json(Score) without episodes; empty unless scored

  auto columns() { return std::tie(id, team, team_name, phase, method, state, created, score); }
};

/// The answer to a results file.
struct Receipt {
  Submission submission;
  std::vector<Diagnostic> warnings;
  bool known = false;  ///< the same file was submitted before: nothing was added
};

/// All functions may be called from any thread. What receive() acknowledged is on the disk; what is
/// queued there is scored after a restart.
class Submissions {
 public:
  using Report = std::function<void(std::string_view fault)>;

  /// Starts the thread that scores. The destructor waits for the submission that is being scored;
  /// the others stay queued. \pre the database outlives *this
  /// \param report called by that thread when the database fails; it then waits, and tries again.
  /// Must not throw; may be empty
  Submissions(std::shared_ptr<const Site> site, store::Database& db, Report report = {});

  /// Checks a whole results file and queues it. The same file of the same team for the same phase
  /// and method is one submission, so that a client may repeat a request that got no answer.
  /// \throws InvalidInput with every fault of the file; Refusal kNotFound for an unknown
  /// phase, kInvalidInput for a bad name of the method, kRateLimited past the phase's limit
  Receipt receive(const accounts::Principal& team, std::string_view phase,
                  const std::string& method, const std::string& results);
  /// A team's, or with team 0 everybody's, newest first: the first 500 whose id is below `before`.
  std::vector<Submission> list(std::int64_t team, std::int64_t before) const;
  std::optional<Submission> find(std::int64_t id) const;
  /// Takes it off the leaderboard, for good; it still counts for the limit of its day.
  /// \throws Refusal kNotFound if it isn't the team's, kConflict if it was withdrawn before
  void withdraw(std::int64_t team, std::int64_t id);
  /// Scored submissions of a phase, oldest first.
  std::vector<Submission> scored(const Phase& phase) const;
  std::int64_t queued() const;

 private:
  void work(const std::stop_token& stop);
  void wait_until_asked(const std::stop_token& stop);
  void wait_after_failure(const std::stop_token& stop);
  bool score_next();
  std::string score(const std::string& phase, const std::string& results) const;

  std::shared_ptr<const Site> site_;
  store::Database& db_;
  Report report_;
  std::mutex checking_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool asked_ = true;    // something may be queued
  std::jthread worker_;  // last: it uses the others
};

}  // namespace enfilade::service::evaluation
