#include "enfilade/service/evaluation/evaluation.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/r2r/results.h"
#include "enfilade/r2r/score.h"
#include "enfilade/service/detail/clock.h"
#include "enfilade/service/detail/gzip.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/http.h"
#include "enfilade/service/store/sql.h"

namespace enfilade::service::evaluation {
namespace {

constexpr std::size_t kLongestMethod = 80;
constexpr std::int64_t kDay = 24L * 3600;
// Bytes of a file that is quoted in messages have this for their name.
constexpr const char* kFileName = "submission";

Submission read_row(SQLite::Statement& row) {
  return {row.getColumn(0).getInt64(),  row.getColumn(1).getInt64(),  row.getColumn(2).getString(),
          row.getColumn(3).getString(), row.getColumn(4).getString(), row.getColumn(5).getString(),
          row.getColumn(6).getInt64(),  row.getColumn(7).getString()};
}

constexpr const char* kSubmissions =
    "SELECT submission.id, submission.team, team.name, phase, method, state, submission.created, "
    "coalesce(score, '') FROM submission JOIN team ON team.id = submission.team WHERE ";

/// Its id; 0 if there is none.
std::int64_t find_same(SQLite::Database& db, const Submission& submission,
                       const std::string& digest) {
  return store::find_number(db,
                            "SELECT id FROM submission WHERE team = ? AND phase = ? AND method = ? "
                            "AND digest = ? AND state <> 'withdrawn'",
                            submission.team, submission.phase, submission.method, digest);
}

void check_limit(SQLite::Database& db, std::int64_t team, const Phase& phase, std::int64_t now) {
  const std::int64_t taken = store::find_number(
      db, "SELECT count(*) FROM submission WHERE team = ? AND phase = ? AND created > ?", team,
      phase.name, now - kDay);
  if (taken >= phase.per_day) {
    throw http::HttpError(429, "daily-limit",
                          fmt::format("phase {} takes {} submissions of a team in 24 hours",
                                      phase.name, phase.per_day));
  }
}

std::int64_t insert_submission(SQLite::Database& db, const Submission& submission,
                               const std::string& digest, const std::string& content) {
  SQLite::Statement insert(
      db,
      "INSERT INTO submission (team, phase, method, created, state, digest, content) "
      "VALUES (?, ?, ?, ?, 'queued', ?, ?)");
  insert.bind(1, submission.team);
  insert.bind(2, submission.phase);
  insert.bind(3, submission.method);
  insert.bind(4, submission.created);
  insert.bind(5, digest);
  insert.bind(6, content.data(), static_cast<int>(content.size()));
  insert.exec();
  return db.getLastInsertRowid();
}

}  // namespace

Evaluation::Evaluation(std::shared_ptr<const Site> site, std::shared_ptr<store::Database> database,
                       detail::Clock clock)
    : site_(std::move(site)),
      database_(std::move(database)),
      clock_(std::move(clock)),
      worker_([this] { work(); }) {}

Evaluation::~Evaluation() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  worker_.join();
}

Receipt Evaluation::receive(const accounts::Principal& team, std::string_view phase_name,
                            const std::string& method, const std::string& results) {
  const Phase* phase = site_->find_phase(phase_name);
  if (phase == nullptr) throw http::HttpError(404, "unknown-phase", "no phase of this name");
  if (!detail::is_label(method, kLongestMethod)) {
    throw http::HttpError(422, "bad-method",
                          fmt::format("method: not 1 to {} printable characters", kLongestMethod));
  }
  Receipt receipt;
  {
    // One at a time: it takes several times the file's size, and teams come all at once on the
    // last day.
    const std::scoped_lock lock(checking_);
    receipt.warnings =
        r2r::parse_results(results, kFileName, site_->secret_episodes(*phase)).warnings;
  }
  const std::string digest = detail::sha256(results);
  Submission& submission = receipt.submission;
  submission = {0, team.team, team.name, phase->name, method, "queued", clock_(), ""};
  submission.id = database_->transact([&](SQLite::Database& db) {
    const std::int64_t same = find_same(db, submission, digest);
    receipt.seen_before = same != 0;
    if (receipt.seen_before) return same;
    check_limit(db, team.team, *phase, submission.created);
    return insert_submission(db, submission, digest, detail::gzip(results, 1));
  });
  if (receipt.seen_before) submission = find(submission.id).value_or(submission);
  const std::scoped_lock lock(mutex_);
  asked_ = true;
  wake_.notify_all();
  return receipt;
}

std::vector<Submission> Evaluation::select(const std::string& condition, std::int64_t a,
                                           const std::string& b) const {
  return database_->with([&](SQLite::Database& db) {
    SQLite::Statement rows(db, kSubmissions + condition);
    rows.bind(1, a);
    if (!b.empty()) rows.bind(2, b);
    std::vector<Submission> found;
    while (rows.executeStep()) found.push_back(read_row(rows));
    return found;
  });
}

std::vector<Submission> Evaluation::list(std::int64_t team, std::int64_t before) const {
  return select(fmt::format("(?1 = 0 OR submission.team = ?1) AND submission.id < {} "
                            "ORDER BY submission.id DESC LIMIT 500",
                            before),
                team, "");
}

std::optional<Submission> Evaluation::find(std::int64_t id) const {
  std::vector<Submission> found = select("submission.id = ?1", id, "");
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

std::vector<Submission> Evaluation::scored(const Phase& phase) const {
  return select("submission.id > ?1 AND state = 'scored' AND phase = ?2 ORDER BY submission.id", 0,
                phase.name);
}

void Evaluation::withdraw(std::int64_t team, std::int64_t id) {
  const std::optional<Submission> found = find(id);
  if (!found || found->team != team) {
    throw http::HttpError(404, "unknown-submission", "no such submission");
  }
  if (found->state == "withdrawn")
    throw http::HttpError(409, "withdrawn", "it is withdrawn already");
  database_->transact([&](SQLite::Database& db) {
    store::run(db, "UPDATE submission SET state = 'withdrawn' WHERE id = ?", id);
  });
}

std::int64_t Evaluation::queued() const {
  return database_->with([](SQLite::Database& db) {
    return db.execAndGet("SELECT count(*) FROM submission WHERE state = 'queued'").getInt64();
  });
}

void Evaluation::work() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stopping_ || asked_; });
      if (stopping_) return;
      asked_ = false;
    }
    while (score_next()) {
      const std::scoped_lock lock(mutex_);
      if (stopping_) return;
    }
  }
}

std::string Evaluation::score(const Phase& phase, const std::string& results) const {
  const r2r::EpisodeSet& episodes = site_->secret_episodes(phase);
  const r2r::Results checked = r2r::parse_results(results, kFileName, episodes);
  return r2r::to_json(r2r::compute_score(checked.trajectories, episodes));
}

// The oldest that waits. A failure is kept as such: it must neither stop the thread nor come again.
bool Evaluation::score_next() {
  std::int64_t id = 0;
  std::string phase_name;
  std::string content;
  database_->with([&](SQLite::Database& db) {
    SQLite::Statement next(db,
                           "SELECT id, phase, content FROM submission WHERE state = 'queued' "
                           "ORDER BY id LIMIT 1");
    if (!next.executeStep()) return;
    id = next.getColumn(0).getInt64();
    phase_name = next.getColumn(1).getString();
    content = next.getColumn(2).getString();
  });
  if (id == 0) return false;
  std::string result;
  try {
    const Phase* phase = site_->find_phase(phase_name);
    if (phase == nullptr) throw LookupError("the phase is gone");
    result = score(*phase, detail::gunzip(content));
  } catch (const std::exception&) {
    result.clear();  // the phase, its annotations or the graphs were changed since it came
  }
  database_->transact([&](SQLite::Database& db) {
    SQLite::Statement update(db,
                             "UPDATE submission SET state = ?, score = ?, finished = ? "
                             "WHERE id = ? AND state = 'queued'");
    update.bind(1, result.empty() ? "failed" : "scored");
    if (!result.empty()) update.bind(2, result);
    update.bind(3, clock_());
    update.bind(4, id);
    update.exec();
  });
  return true;
}

}  // namespace enfilade::service::evaluation
