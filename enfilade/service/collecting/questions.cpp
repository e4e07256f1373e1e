#include "enfilade/service/collecting/questions.h"

#include <algorithm>

#include "enfilade/service/detail/refusal.h"

namespace enfilade::service::collecting {
namespace {

using detail::Reason;
using detail::Refusal;

std::vector<Question> unanswered(store::Database& db, std::int64_t collection, std::int64_t worker,
                                 Stage stage) {
  return db.select<Question>(
      "SELECT id, stage, text, choices, accepted FROM question WHERE collection = ? AND stage = ? "
      "AND NOT EXISTS (SELECT 1 FROM answer WHERE question = question.id AND worker = ?) "
      "ORDER BY id",
      collection, stage, worker);
}

}  // namespace

void add_questions(store::Database& db, std::int64_t collection,
                   const std::vector<Question>& questions) {
  for (const Question& one : questions) {
    db.run(
        "INSERT INTO question (collection, stage, text, choices, accepted) VALUES (?, ?, ?, ?, ?)",
        collection, one.stage, one.text, one.choices, one.accepted);
  }
}

std::vector<Question> questions_of(store::Database& db, std::int64_t collection) {
  return db.select<Question>(
      "SELECT id, stage, text, choices, accepted FROM question WHERE collection = ? ORDER BY id",
      collection);
}

std::vector<Question> pending_questions(store::Database& db, std::int64_t collection,
                                        std::int64_t worker, std::int64_t done, int every) {
  std::vector<Question> pending = unanswered(db, collection, worker, Stage::kScreening);
  if (!pending.empty()) return pending;
  const std::int64_t answered = db.find_number(
      "SELECT count(*) FROM answer JOIN question ON question.id = question WHERE worker = ? AND "
      "stage = ?",
      worker, Stage::kCheck);
  if (done + 1 < (answered + 1) * every) return {};
  pending = unanswered(db, collection, worker, Stage::kCheck);
  if (pending.size() > 1) pending.resize(1);
  return pending;
}

void answer(store::Database& db, std::int64_t collection, std::int64_t worker,
            std::int64_t question, const std::string& choice) {
  const auto found = db.find<Question>(
      "SELECT id, stage, text, choices, accepted FROM question WHERE id = ? AND collection = ?",
      question, collection);
  if (!found) throw Refusal(Reason::kNotFound, "no such question in this collection");
  if (std::ranges::find(found->choices, choice) == found->choices.end()) {
    throw Refusal(Reason::kInvalidInput, "choice: not one of the question's");
  }
  const bool accepted = std::ranges::find(found->accepted, choice) != found->accepted.end();
  db.run(
      "INSERT INTO answer (question, worker, choice, accepted, at) VALUES (?, ?, ?, ?, ?) "
      "ON CONFLICT DO NOTHING",
      question, worker, choice, accepted, db.now());
}

bool is_screened_out(store::Database& db, std::int64_t worker) {
  return db.find_number(
             "SELECT 1 FROM answer JOIN question ON question.id = question WHERE worker = ? AND "
             "stage = ? AND answer.accepted = 0 LIMIT 1",
             worker, Stage::kScreening) != 0;
}

}  // namespace enfilade::service::collecting
