#include "enfilade/service/evaluation/submissions.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/gzip.h"
#include "enfilade/net/hosts.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/leakage.h"
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
      "coalesce(near_copy_of, 0), coalesce(differing, 0), paper, code, weights, walks_public "
      "FROM submission JOIN team ON team.id = submission.team WHERE {}",
      condition);
}

void check_link(std::string_view name, const std::string& link) {
  if (link.empty() || detail::is_https_address(link)) return;
  throw Refusal(Reason::kInvalidInput,
                fmt::format("{}: {:?}, not an address that begins with https://", name,
                            link.substr(0, detail::kQuoted)));
}

void check_text(std::string_view name, const std::string& text) {
  if (text.empty() || detail::is_prose(text, MethodDescription::kLongest)) return;
  throw Refusal(Reason::kInvalidInput, fmt::format("{}: not 0 to {} printable characters", name,
                                                   MethodDescription::kLongest));
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

// How often a team and an address may submit to a phase: rows of the table `attempt`, one for each
// file that was checked, with the submission that it became. Without one it was refused.

// Files with faults that a team may send to a phase in 24 hours. They give away nothing of goals,
// so they are not submissions; but a check takes time and memory.
constexpr int kRefusedPerDay = 20;
// Likewise by all teams of an address.
constexpr int kRefusedPerAddressDay = 100;

// The sender of a file.
struct Sender {
  std::int64_t team = 0;
  std::string address;  ///< as stored: see stored_address()
};

constexpr std::int64_t kDay = 24L * 3600;
constexpr const char* kAddressKey = "address-key";

/// \param most none: no limit  \param what "submissions of a team in all"
/// \param rows those that count: a table and a condition on the values
template <class... Values>
void refuse_if_full(store::Database& db, const Phase& phase, std::optional<int> most,
                    std::string_view what, const std::string& rows, const Values&... values) {
  if (!most || db.find_number("SELECT count(*) FROM " + rows, values...) < *most) return;
  throw Refusal(Reason::kRateLimited,
                fmt::format("phase {} takes at most {} {}", phase.name, *most, what));
}

// The bound on a phase's leakage holds for Phase::teams teams.
void check_place(store::Database& db, const Phase& phase, std::int64_t team) {
  if (!phase.goals_secret()) return;
  const std::int64_t others =
      db.find_number("SELECT count(DISTINCT team) FROM submission WHERE phase = ? AND team <> ?",
                     phase.name, team);
  if (others < phase.teams) return;
  throw Refusal(
      Reason::kForbidden,
      fmt::format("phase {} takes submissions of {} teams, and has them", phase.name, phase.teams));
}

// The stored form of a client's address: a hash with a key of this database. So addresses of two
// databases cannot be compared, nor read without the file. One for a whole /64 of IPv6.
std::string stored_address(store::Database& db, std::string_view address) {
  const std::string key = db.transact([&db] {
    const std::string find = "SELECT value FROM secret WHERE name = ?";
    if (const auto found = db.find<std::string>(find, kAddressKey)) return *found;
    db.run("INSERT INTO secret (name, value) VALUES (?, ?)", kAddressKey, detail::new_secret(""));
    return db.get<std::string>(find, kAddressKey);
  });
  return detail::keyed_hash(key, net::address_group(address));
}

// \throws Refusal kRateLimited naming the limit that another submission would exceed; kForbidden
// if the phase has secret goals and all the teams that it takes
void check_limits(store::Database& db, const Phase& phase, const Sender& sender) {
  check_place(db, phase, sender.team);
  const std::int64_t since = db.now() - kDay;
  // Submissions of databases that are older than the table `attempt` count too.
  const std::string of_team = "submission WHERE team = ? AND phase = ?";
  refuse_if_full(db, phase, phase.per_day, "submissions of a team in 24 hours",
                 of_team + " AND created > ?", sender.team, phase.name, since);
  refuse_if_full(db, phase, phase.per_team, "submissions of a team in all", of_team, sender.team,
                 phase.name);
  const std::string of_address =
      "attempt WHERE address = ? AND phase = ? AND submission IS NOT NULL";
  refuse_if_full(db, phase, phase.per_address_day, "submissions from an address in 24 hours",
                 of_address + " AND created > ?", sender.address, phase.name, since);
  refuse_if_full(db, phase, phase.per_address, "submissions from an address in all", of_address,
                 sender.address, phase.name);
}

// check_limits(), and counts the file as a refused one until accept_attempt(). Many files that
// come at once are so counted before the first of them is checked. \returns the attempt's number
std::int64_t begin_attempt(store::Database& db, const Phase& phase, const Sender& sender) {
  return db.transact([&] {
    check_limits(db, phase, sender);
    const std::string refused =
        "attempt WHERE phase = ? AND submission IS NULL AND created > ? AND ";
    const std::int64_t since = db.now() - kDay;
    refuse_if_full(db, phase, kRefusedPerDay, "files with faults of a team in 24 hours",
                   refused + "team = ?", phase.name, since, sender.team);
    refuse_if_full(db, phase, kRefusedPerAddressDay,
                   "files with faults from an address in 24 hours", refused + "address = ?",
                   phase.name, since, sender.address);
    // Addresses of refused files are not kept for longer than they count.
    db.run("DELETE FROM attempt WHERE submission IS NULL AND created <= ?", since);
    return db.insert("INSERT INTO attempt (team, phase, address, created) VALUES (?, ?, ?, ?)",
                     sender.team, phase.name, sender.address, db.now());
  });
}

void accept_attempt(store::Database& db, std::int64_t attempt, std::int64_t submission) {
  db.run("UPDATE attempt SET submission = ? WHERE id = ?", submission, attempt);
}

/// Names of the phases with secret goals of which a file has the same episodes.
std::vector<std::string> with_same_episodes(const Site& site, const Phase& phase) {
  std::vector<std::string> names;
  for (const Phase& one : site.phases()) {
    const bool same = one.split == phase.split && share_paths(*one.benchmark, *phase.benchmark);
    if (same && one.goals_secret()) names.push_back(one.name);
  }
  return names;
}

std::map<std::string, std::atomic<bool>> flags_of(const Site& site) {
  std::map<std::string, std::atomic<bool>> flags;
  for (const Phase& phase : site.phases()) flags.try_emplace(phase.name, false);
  return flags;
}

}  // namespace

OtherSplit::OtherSplit(const Phase& sent, const Phase& right)
    : InvalidInput({{Severity::kError, "submission", "$", "other-split",
                     fmt::format("this is a file of {}, and phase {} is of {}; phase {} takes it",
                                 right.split, sent.name, sent.split, right.name)}}),
      phase_(right.name) {}

Submissions::Submissions(std::shared_ptr<const Site> site, store::Database& db, Report report,
                         Leaks leaks)
    : site_(std::move(site)),
      db_(db),
      report_(std::move(report)),
      ledger_(*site_, db, leaks),
      final_(flags_of(*site_)),
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
    try {
      receipt.warnings = check_results(site_->secret_episodes(*phase), results);
    } catch (const InvalidInput& faults) {
      if (std::ranges::none_of(faults.diagnostics(), is_unknown_episode)) throw;
      const Phase* right = find_right_phase(*phase, results);
      if (right == nullptr) throw;
      throw OtherSplit(*phase, *right);
    }
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

/// The first open phase of the same benchmark and another split that has the episodes of a file;
/// null: there is none.
const Phase* Submissions::find_right_phase(const Phase& sent, const std::string& results) const {
  for (const Phase& one : site_->phases()) {
    if (one.benchmark != sent.benchmark || one.split == sent.split || has_ended(one)) continue;
    if (names_episodes_of(site_->secret_episodes(one).split, results)) return &one;
  }
  return nullptr;
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

MethodDescription Submissions::description(std::int64_t id) const {
  return db_.get<MethodDescription>(
      "SELECT description, bibtex, paper, code, weights, walks_public FROM submission WHERE id = ?",
      id);
}

void Submissions::describe(const Submission& submission, const MethodDescription& description) {
  check_text("description", description.text);
  check_text("bibtex", description.bibtex);
  check_link("paper", description.links.paper);
  check_link("code", description.links.code);
  const Phase* phase = site_->find_phase(submission.phase);
  if (description.walks_public && (phase == nullptr || phase->goals_secret())) {
    throw Refusal(Reason::kConflict,
                  "walks_public: trajectories are shown where goals are open, and not here");
  }
  db_.run(
      "UPDATE submission SET description = ?, bibtex = ?, paper = ?, code = ?, weights = ?, "
      "walks_public = ? WHERE id = ?",
      description.text, description.bibtex, description.links.paper, description.links.code,
      description.weights, description.walks_public, submission.id);
}

std::string Submissions::results(std::int64_t id) const {
  return gunzip(db_.get<std::string>("SELECT content FROM submission WHERE id = ?", id),
                kMostBytes);
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
  if (!phase.goals_secret() || phase.scores == Scores::kHidden) return false;
  std::atomic<bool>& known = final_.at(phase.name);
  if (known) return true;  // without a transaction, for which all others would wait
  if (!has_ended(phase)) return false;
  known = db_.transact([&] {
    if (db_.find_number("SELECT count(*) FROM phase_end WHERE phase = ?", phase.name) == 0) {
      // Rows that change while the last files are scored would tell the scores of several of them.
      if (!has_ended(phase) ||
          db_.find_number("SELECT count(*) FROM submission WHERE phase = ? AND "
                          "state = 'queued'",
                          phase.name) != 0) {
        return false;
      }
      db_.run("INSERT INTO phase_end (phase, at) VALUES (?, ?)", phase.name, db_.now());
    }
    ledger_.show_rows(phase);
    return true;
  });
  return known;
}

std::map<std::string, Leakage> Submissions::leakage() const {
  for (const Phase& phase : site_->phases()) is_final(phase);  // whoever asks now sees rows
  return ledger_.leakage();
}

std::int64_t Submissions::count_near_copies(const Phase& phase) const {
  return db_.find_number(
      "SELECT count(*) FROM submission WHERE phase = ? AND near_copy_of IS NOT NULL", phase.name);
}

void Submissions::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kLookAgain, [this] { return asked_; });
      asked_ = false;
    }
    try {
      while (!stop.stop_requested() && score_next()) {
      }
    } catch (const std::exception& error) {
      // The disk may be full, or another program may hold the file for long. Submissions stay
      // queued, and an exception that left the thread would end the process.
      if (report_) report_(error.what());
      // Waits whatever is received meanwhile; not if it is to stop.
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kRetry, [] { return false; });
      asked_ = true;
    }
  }
}

// Scores the oldest queued submission; false if there is none. A file that cannot be scored is
// marked as failed in its row, and not tried again. Throws only what the database throws.
bool Submissions::score_next() {
  const auto next = db_.find<std::tuple<std::int64_t, std::string, std::string>>(
      "SELECT id, phase, content FROM submission WHERE state = 'queued' ORDER BY id LIMIT 1");
  if (!next) return false;
  const auto& [id, phase, content] = *next;
  const Phase* of = site_->find_phase(phase);
  std::optional<ScoredSubmission> judged;
  try {
    if (of != nullptr) {
      judged = score_results(*of, site_->secret_episodes(*of), gunzip(content, kMostBytes));
      // The worst where an episode has no value: it beats nothing on a ladder.
      if (!std::isfinite(judged->primary)) judged->primary = -HUGE_VAL;
    }
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
void Submissions::store_score(std::int64_t id, const Phase& phase, const ScoredSubmission& judged) {
  std::optional<NearCopy> near;
  if (phase.goals_secret()) {
    near = find_near_copy(db_, with_same_episodes(*site_, phase), id, judged.ends);
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
      db_.run("UPDATE submission SET ends = ?, rule = ? WHERE id = ?", store::Blob{judged.ends},
              ledger_.rule_of(phase), id);
    }
  });
}

}  // namespace enfilade::service::evaluation
