/// \file  Submissions: checked when they come, kept, scored in the background.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/accounts/tokens.h"
#include "enfilade/service/detail/clock.h"
#include "enfilade/service/phases.h"
#include "enfilade/service/site.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::evaluation {

/// A submission without its content.
struct Submission {
  std::int64_t id = 0;
  std::int64_t team = 0;
  std::string team_name, phase, method;
  std::string state;  ///< "queued", "scored", "failed", "withdrawn"
  std::int64_t created = 0;
  std::string score;  ///< r2r::to_json(Score) without episodes; empty unless scored
};

/// What handing in came to.
struct Receipt {
  Submission submission;
  std::vector<Diagnostic> warnings;
  bool seen_before = false;  ///< this very file was there: nothing was added
};

/// All functions may be called from any thread. What receive() acknowledged is on the disk; what is
/// queued there is scored after a restart.
class Evaluation {
 public:
  /// Starts the thread that scores.
  Evaluation(std::shared_ptr<const Site> site, std::shared_ptr<store::Database> database,
             detail::Clock clock);
  /// Waits for the submission that is being scored; the others stay queued.
  ~Evaluation();
  Evaluation(const Evaluation&) = delete;
  Evaluation& operator=(const Evaluation&) = delete;

  /// Checks a results file whole and queues it. The same file of the same team for the same phase
  /// and method is taken once, so that a client may repeat what got no answer.
  /// \throws InvalidInput with every fault of the file; HttpError 404 for an unknown phase, 422 for
  /// a bad name of the method, 429 past the phase's limit
  Receipt receive(const accounts::Principal& team, std::string_view phase,
                  const std::string& method, const std::string& results);
  /// A team's, or with team 0 everybody's, newest first: the first 500 whose id is below `before`.
  std::vector<Submission> list(std::int64_t team, std::int64_t before) const;
  std::optional<Submission> find(std::int64_t id) const;
  /// From the leaderboard, for good; its place in the day's limit stays taken.
  /// \throws HttpError 404 if it isn't the team's, 409 if it is withdrawn already
  void withdraw(std::int64_t team, std::int64_t id);
  /// Scored submissions of a phase, in the order of their coming.
  std::vector<Submission> scored(const Phase& phase) const;
  std::int64_t queued() const;

 private:
  std::vector<Submission> select(const std::string& condition, std::int64_t a,
                                 const std::string& b) const;
  void work();
  bool score_next();
  std::string score(const Phase& phase, const std::string& results) const;

  std::shared_ptr<const Site> site_;
  std::shared_ptr<store::Database> database_;
  detail::Clock clock_;
  std::mutex checking_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  bool asked_ = true;  // something may be queued
  std::thread worker_;
};

}  // namespace enfilade::service::evaluation
