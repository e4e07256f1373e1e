/// \file  Questions to workers: a screening before the first task, and attention checks between
/// tasks. Which answers are right never leaves the server.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/service/store/database.h"

namespace enfilade::service::collecting {

enum class Stage : std::uint8_t {
  kScreening,  ///< before anything else: a wrong answer means no task
  kCheck,      ///< between tasks: wrong answers are counted, and shown to reviewers
};
constexpr std::array<std::string_view, 2> names_of(Stage /*enum*/) {
  return {"screening", "check"};
}

struct Question {
  std::int64_t id = 0;
  Stage stage = Stage::kScreening;
  std::string text;
  std::vector<std::string> choices;
  std::vector<std::string> accepted;  ///< the right ones of them

  auto columns() { return std::tie(id, stage, text, choices, accepted); }
};

void add_questions(store::Database& db, std::int64_t collection,
                   const std::vector<Question>& questions);
/// By id: in the order in which they were written.
std::vector<Question> questions_of(store::Database& db, std::int64_t collection);

/// Questions for a worker before the next task: all of the screening, or the next attention check.
/// The first check comes before task number `every`, the second before 2 * every, ...
/// \param done tasks that the worker submitted in all visits, without practice
std::vector<Question> pending_questions(store::Database& db, std::int64_t collection,
                                        std::int64_t worker, std::int64_t done, int every);

/// Stores an answer; a second one to the same question changes nothing.
/// \throws Refusal kNotFound for a question of another collection, kInvalidInput for a choice that
/// it does not have
void answer(store::Database& db, std::int64_t collection, std::int64_t worker,
            std::int64_t question, const std::string& choice);
/// Whether an answer to the screening was wrong.
bool is_screened_out(store::Database& db, std::int64_t worker);

}  // namespace enfilade::service::collecting
