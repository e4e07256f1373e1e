#include "enfilade/service/evaluation/submissions.h"

#include <fmt/format.h>
#include <chrono>
#include <utility>

#include "enfilade/r2r/results.h"
#include "enfilade/r2r/score.h"
#include "enfilade/service/detail/gzip.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::evaluation {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kLongestMethod = 80;
constexpr std::int64_t kDay = 24L * 3600;
// From a failure of the database to the next attempt to score.
constexpr std::chrono::seconds kRetry{2};
// The name of a results file in messages.
constexpr const char* kFileName = "submission";

std::string submissions_where(std::string_view condition) {
  return fmt::format(
      "SELECT submission.id, submission.team, team.name, phase, method, state, "
      "submission.created, coalesce(score, '') FROM submission JOIN team ON team.id = "
      "submission.team WHERE {}",
      condition);
}

void check_limit(store::Database& db, std::int64_t team, const Phase& phase) {
  const std::int64_t taken =
      db.find_number("SELECT count(*) FROM submission WHERE team = ? AND phase = ? AND created > ?",
                     team, phase.name, db.now() - kDay);
  if (taken >= phase.per_day) {
    throw Refusal(Reason::kRateLimited,
                  fmt::format("phase {} takes {} submissions of a team in 24 hours", phase.name,
                              phase.per_day));
  }
}

}  // namespace

Submissions::Submissions(std::shared_ptr<const Site> site, store::Database& db, Report report)
    : site_(std::move(site)),
      db_(db),
      report_(std::move(report)),
      worker_([this](const std::stop_token& stop) { work(stop); }) {}

Receipt Submissions::receive(const accounts::Principal& team, std::string_view phase_name,
                             const std::string& method, const std::string& results) {
  const Phase* phase = site_->find_phase(phase_name);
  if (phase == nullptr) throw Refusal(Reason::kNotFound, "no phase of this name");
  if (!detail::is_label(method, kLongestMethod)) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("method: not 1 to {} printable characters", kLongestMethod));
  }
  Receipt receipt;
  {
    // One at a time: a check takes several times the file's size in memory, and many teams submit
    // at once on the last day.
    const std::scoped_lock lock(checking_);
    receipt.warnings =
        r2r::parse_results(results, kFileName, site_->secret_episodes(*phase)).warnings;
  }
  const std::string digest = detail::sha256(results);
  receipt.submission = db_.transact([&] {
    std::int64_t id = db_.find_number(
        "SELECT id FROM submission WHERE team = ? AND phase = ? AND method = ? AND digest = ? "
        "AND state <> 'withdrawn'",
        team.team, phase->name, method, digest);
    receipt.known = id != 0;
    if (!receipt.known) {
      check_limit(db_, team.team, *phase);
      const std::string content = detail::gzip(results, 1);
      id = db_.insert(
          "INSERT INTO submission (team, phase, method, created, state, digest, content) "
          "VALUES (?, ?, ?, ?, ?, ?, ?)",
          team.team, phase->name, method, db_.now(), SubmissionState::kQueued, digest,
          store::Blob{content});
    }
    return find(id).value();
  });
  const std::scoped_lock lock(mutex_);
  asked_ = true;
  wake_.notify_all();
  return receipt;
}

std::vector<Submission> Submissions::list(std::int64_t team, std::int64_t before) const {
  return db_.select<Submission>(
      submissions_where("(?1 = 0 OR submission.team = ?1) AND submission.id < ?2 "
                        "ORDER BY submission.id DESC LIMIT 500"),
      team, before);
}

std::optional<Submission> Submissions::find(std::int64_t id) const {
  return db_.find<Submission>(submissions_where("submission.id = ?"), id);
}

std::vector<Submission> Submissions::scored(const Phase& phase) const {
  return db_.select<Submission>(
      submissions_where("state = 'scored' AND phase = ? ORDER BY submission.id"), phase.name);
}

void Submissions::withdraw(std::int64_t team, std::int64_t id) {
  const std::optional<Submission> found = find(id);
  if (!found || found->team != team) {
    throw Refusal(Reason::kNotFound, "no such submission");
  }
  if (found->state == SubmissionState::kWithdrawn) {
    throw Refusal(Reason::kConflict, "the submission was withdrawn before");
  }
  db_.run("UPDATE submission SET state = 'withdrawn' WHERE id = ?", id);
}

std::int64_t Submissions::queued() const {
  return db_.find_number("SELECT count(*) FROM submission WHERE state = 'queued'");
}

void Submissions::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    wait_until_asked(stop);
    try {
      while (!stop.stop_requested() && score_next()) {
      }
    } catch (const std::exception& error) {
      // The disk may be full, or another program may hold the file for long. Submissions stay
      // queued, and an exception that left the thread would end the process.
      if (report_) report_(error.what());
      wait_after_failure(stop);
    }
  }
}

void Submissions::wait_until_asked(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, stop, [this] { return asked_; });
  asked_ = false;
}

// Waits for kRetry, whatever is received meanwhile; returns at once when asked to stop.
void Submissions::wait_after_failure(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, stop, kRetry, [] { return false; });
  asked_ = true;
}

std::string Submissions::score(const std::string& phase_name, const std::string& results) const {
  const Phase* phase = site_->find_phase(phase_name);
  if (phase == nullptr) throw LookupError("the phase is gone");
  const r2r::EpisodeSet& episodes = site_->secret_episodes(*phase);
  const r2r::Results checked = r2r::parse_results(results, kFileName, episodes);
  return r2r::to_json(r2r::compute_score(checked.trajectories, episodes));
}

// Scores the oldest queued submission; false if there is none. A file that cannot be scored is
// marked as failed in its row, and not tried again. Throws only what the database throws.
bool Submissions::score_next() {
  const auto next = db_.find<std::tuple<std::int64_t, std::string, std::string>>(
      "SELECT id, phase, content FROM submission WHERE state = 'queued' ORDER BY id LIMIT 1");
  if (!next) return false;
  const auto& [id, phase, content] = *next;
  std::optional<std::string> result;
  try {
    result = score(phase, detail::gunzip(content));
  } catch (const std::exception&) {
    result.reset();  // the phase, its annotations or the graphs were changed since it was received
  }
  db_.run(
      "UPDATE submission SET state = ?, score = ?, finished = ? WHERE id = ? AND state = 'queued'",
      result ? SubmissionState::kScored : SubmissionState::kFailed, result, db_.now(), id);
  return true;
}

}  // namespace enfilade::service::evaluation
