#include "enfilade/service/evaluation/submissions.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/gzip.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/leakage.h"
#include "enfilade/service/evaluation/limits.h"
#include "enfilade/service/evaluation/scoring.h"
#include "enfilade/service/evaluation/shown_metrics.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::evaluation {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kLongestMethod = 80;
// From a failure of the database to the next attempt to score.
constexpr std::chrono::seconds kRetry{2};
// What another server of the same database received, and did not score before it ended.
constexpr std::chrono::seconds kLookAgain{10};
// Limit of a stored results file, whose size was checked when it came: eight times the server's
// default. A damaged row cannot request more memory.
constexpr std::size_t kMostBytes = std::size_t{256} << 20U;

std::string submissions_where(std::string_view condition) {
  return fmt::format(
      "SELECT submission.id, submission.team, team.name, phase, method, state, "
      "submission.created, coalesce(score, ''), team.approved IS NOT NULL, shown, "
      "coalesce(near_copy_of, 0), coalesce(differing, 0), paper, code "
      "FROM submission JOIN team ON team.id = submission.team WHERE {}",
      condition);
}

void check_link(std::string_view name, const std::string& link) {
  if (link.empty() || detail::is_https_address(link)) return;
  throw Refusal(Reason::kInvalidInput,
                fmt::format("{}: {:?}, not an address that begins with https://", name,
                            link.substr(0, detail::kQuoted)));
}

/// The message of a phase that has ended.
std::string ended_text(const Phase& phase) {
  return phase.ends ? fmt::format("phase {} ended at {}", phase.name, detail::iso_time(*phase.ends))
                    : fmt::format("phase {} has ended", phase.name);
}

/// \returns what the ladder shows of a submission; none if it is no improvement
/// \param best that was shown to the team before  \param primary the exact mean
std::optional<double> ladder_step(const Phase& phase, std::optional<double> best, double primary) {
  // A number that is a step better as people count may be less by the last bit.
  constexpr double kTolerance = 1e-9;
  const Grid grid = grid_of(phase, phase.primary_measure());
  if (best && primary < *best + grid.step - kTolerance) return std::nullopt;
  return grid.round(primary);
}

}  // namespace

Submissions::Submissions(std::shared_ptr<const Site> site, store::Database& db, Report report)
    : site_(std::move(site)),
      db_(db),
      report_(std::move(report)),
      goals_(*site_),
      worker_([this](const std::stop_token& stop) { work(stop); }) {}

Receipt Submissions::receive(const Delivery& delivery, const std::string& results) {
  const Phase* phase = site_->find_phase(delivery.phase);
  if (phase == nullptr) throw Refusal(Reason::kNotFound, "no phase of this name");
  if (!detail::is_label(delivery.method, kLongestMethod)) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("method: not 1 to {} printable characters", kLongestMethod));
  }
  check_link("paper", delivery.links.paper);
  check_link("code", delivery.links.code);
  const std::string digest = detail::sha256(results);
  if (const std::int64_t known = find_same(delivery, digest); known != 0) {
    return {find(known).value(), {}, true};
  }
  check_open(*phase, delivery.team);
  const Sender sender{delivery.team, stored_address(db_, delivery.address)};
  std::int64_t attempt = 0;
  Receipt receipt;
  {
    // One at a time, small files too: each check has tables of all episodes, and many teams submit
    // at once on the last day.
    const std::scoped_lock lock(checking_);
    attempt = begin_attempt(db_, *phase, sender);
    receipt.warnings = check_results(*phase, site_->secret_episodes(*phase), results);
  }
  receipt.submission = db_.transact([&] {
    std::int64_t id = find_same(delivery, digest);  // the same file may have come twice at once
    receipt.known = id != 0;
    if (!receipt.known) {
      check_open(*phase, delivery.team);
      check_limits(db_, *phase, sender);
      const std::string content = gzip(results, 1);
      id = db_.insert(
          "INSERT INTO submission (team, phase, method, created, state, digest, content, paper, "
          "code) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
          delivery.team, phase->name, delivery.method, db_.now(), SubmissionState::kQueued, digest,
          store::Blob{content}, delivery.links.paper, delivery.links.code);
    }
    accept_attempt(db_, attempt, id);
    return find(id).value();
  });
  const std::scoped_lock lock(mutex_);
  asked_ = true;
  wake_.notify_all();
  return receipt;
}

/// The team's submission of the same file for the same phase and method; 0 if there is none.
std::int64_t Submissions::find_same(const Delivery& delivery, const std::string& digest) const {
  return db_.find_number(
      "SELECT id FROM submission WHERE team = ? AND phase = ? AND method = ? AND digest = ? "
      "AND state <> 'withdrawn'",
      delivery.team, delivery.phase, delivery.method, digest);
}

void Submissions::check_open(const Phase& phase, std::int64_t team) const {
  if (phase.goals_secret() && !accounts::is_approved(db_, team)) {
    throw Refusal(Reason::kForbidden,
                  fmt::format("phase {} takes submissions of teams that an organiser has approved; "
                              "ask them to approve yours",
                              phase.name));
  }
  if (has_ended(phase)) throw Refusal(Reason::kConflict, ended_text(phase));
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
  const Phase* phase = site_->find_phase(found->phase);
  db_.transact([&] {
    if (phase != nullptr && phase->goals_secret() && has_ended(*phase)) {
      throw Refusal(Reason::kConflict, ended_text(*phase) + "; its submissions stay");
    }
    db_.run("UPDATE submission SET state = 'withdrawn' WHERE id = ?", id);
  });
}

std::int64_t Submissions::queued() const {
  return db_.find_number("SELECT count(*) FROM submission WHERE state = 'queued'");
}

bool Submissions::has_ended(const Phase& phase) const {
  if (phase.ends && db_.now() >= *phase.ends) return true;
  return phase.goals_secret() &&
         db_.find_number("SELECT count(*) FROM phase_end WHERE phase = ?", phase.name) != 0;
}

bool Submissions::is_final(const Phase& phase) const {
  if (!phase.goals_secret() || phase.scores == Scores::kHidden || !has_ended(phase)) return false;
  return db_.transact([&] {
    if (db_.find_number("SELECT count(*) FROM phase_end WHERE phase = ?", phase.name) != 0) {
      return true;
    }
    // Rows that change while the last files are scored would tell the scores of several of them.
    if (!has_ended(phase) || db_.find_number("SELECT count(*) FROM submission WHERE phase = ? AND "
                                             "state = 'queued'",
                                             phase.name) != 0) {
      return false;
    }
    db_.run("INSERT INTO phase_end (phase, at) VALUES (?, ?)", phase.name, db_.now());
    return true;
  });
}

Leakage Submissions::leakage(const Phase& phase) const {
  const SharedGoals::Group& group = goals_.of(phase);
  Leakage all;
  all.goals = group.goal_bits;
  for (const Phase* one : group.phases) {
    const auto scored = db_.select<std::int64_t>(
        "SELECT count(*) FROM submission WHERE phase = ? AND score IS NOT NULL GROUP BY team",
        one->name);
    const double used = used_bits(*one, scored, is_final(*one));
    all.used += used;
    // More than the limits allow if they were larger once.
    all.most += std::max(most_bits(*one), used);
    all.phases.push_back(one->name);
  }
  return all;
}

std::int64_t Submissions::count_near_copies(const Phase& phase) const {
  return db_.find_number(
      "SELECT count(*) FROM submission WHERE phase = ? AND near_copy_of IS NOT NULL", phase.name);
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
  wake_.wait_for(lock, stop, kLookAgain, [this] { return asked_; });
  asked_ = false;
}

// Waits for kRetry, whatever is received meanwhile; returns at once when asked to stop.
void Submissions::wait_after_failure(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, stop, kRetry, [] { return false; });
  asked_ = true;
}

Judgement Submissions::score(const Phase* phase, const std::string& results) const {
  if (phase == nullptr) throw LookupError("the phase is gone");
  Judgement judged = score_results(*phase, site_->secret_episodes(*phase), results);
  // The worst where an episode has no value: it beats nothing on a ladder.
  if (!std::isfinite(judged.primary)) judged.primary = -HUGE_VAL;
  return judged;
}

// Scores the oldest queued submission; false if there is none. A file that cannot be scored is
// marked as failed in its row, and not tried again. Throws only what the database throws.
bool Submissions::score_next() {
  const auto next = db_.find<std::tuple<std::int64_t, std::string, std::string>>(
      "SELECT id, phase, content FROM submission WHERE state = 'queued' ORDER BY id LIMIT 1");
  if (!next) return false;
  const auto& [id, phase, content] = *next;
  const Phase* of = site_->find_phase(phase);
  std::optional<Judgement> judged;
  try {
    judged = score(of, gunzip(content, kMostBytes));
  } catch (const std::exception&) {
    judged.reset();  // the phase, its annotations or the graphs changed since it was received
  }
  if (judged) {
    store_score(id, *of, *judged);
  } else {
    db_.run(
        "UPDATE submission SET state = 'failed', finished = ? WHERE id = ? AND state = 'queued'",
        db_.now(), id);
  }
  return true;
}

// Submissions are scored one after another, by their numbers: what a ladder showed before is known.
void Submissions::store_score(std::int64_t id, const Phase& phase, const Judgement& judged) {
  std::optional<NearCopy> near;
  if (phase.goals_secret()) {
    std::vector<std::string> names;
    for (const Phase* one : goals_.of(phase).phases) names.push_back(one->name);
    near = find_near_copy(db_, names, id, judged.ends);
  }
  db_.transact([&] {
    std::optional<double> shown;
    if (phase.scores == Scores::kLadder) {
      const auto best = db_.find<std::optional<double>>(
          "SELECT max(shown) FROM submission WHERE phase = ?1 AND team = "
          "(SELECT team FROM submission WHERE id = ?2)",
          phase.name, id);
      shown = ladder_step(phase, best.value_or(std::nullopt), judged.primary);
    }
    db_.run(
        "UPDATE submission SET state = 'scored', score = ?, finished = ?, shown = ?, "
        "near_copy_of = ?, differing = ? WHERE id = ? AND state = 'queued'",
        judged.score, db_.now(), shown, near ? std::optional(near->of) : std::nullopt,
        near ? std::optional(near->differing) : std::nullopt, id);
    if (phase.goals_secret()) {
      db_.run("UPDATE submission SET ends = ? WHERE id = ?", store::Blob{judged.ends}, id);
    }
  });
}

}  // namespace enfilade::service::evaluation
