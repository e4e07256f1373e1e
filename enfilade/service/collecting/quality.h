/// \file  How well a collection's work goes: how far workers agree, how they answered the questions
/// with known answers, and how much was done each day.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/service/collecting/collections.h"

namespace enfilade::service::collecting {

/// F1 of the tokens that two texts share, each as often as both have it. In [0, 1]:
/// 2 * shared / (number in a + number in b). Tokens are those of tasks::tokenize() with a letter, a
/// digit or _. Symmetric; 0 if one of the texts has no token.
double token_f1(std::string_view a, std::string_view b);

/// How far the workers of one item agree.
struct ItemAgreement {
  std::int64_t path_id = 0;
  std::size_t number = 0;  ///< as WorkItem has it
  std::int64_t tasks = 0;  ///< of different workers; 2 at least
  double value = 0;        ///< mean over all pairs of tasks, [0, 1]; see Agreement
};

/// How far different workers of the same item agree, by what is submitted or accepted; practice and
/// rejected work aside. Where one writes or guides, a pair's value is token_f1() of its texts.
/// Where one looks for a goal, it is 1 if both or neither reached it, else 0; of a dialogue, the
/// navigators' tasks count.
struct Agreement {
  bool of_texts = true;        ///< false: of outcomes
  std::int64_t items = 0;      ///< with two tasks or more
  std::int64_t pairs = 0;      ///< of tasks, in all items
  std::optional<double> mean;  ///< over items; none: there is no item
  /// Texts: mean of token_f1() of texts of two different paths, to compare with. None: there are
  /// not two paths.
  std::optional<double> others;
  /// kWalk, kDialogue: mean difference between the distances of two ends from the goal, metres.
  std::optional<double> metres;
  std::optional<double> success;     ///< share of those tasks that reached the goal; not of texts
  std::vector<ItemAgreement> least;  ///< by rising agreement, 20 at most
};
/// \param secrets whether outcomes of secret goals count; without them their items are left out
Agreement agreement_of(store::Database& db, const Collection& collection, bool secrets);
nlohmann::ordered_json agreement_json(const Agreement& agreement);

/// How the workers answered a question.
struct QuestionResult {
  Question question;
  std::vector<std::int64_t> chosen;  ///< beside each of its choices: how often
  std::int64_t answered = 0, right = 0;
};
/// By id.
std::vector<QuestionResult> question_results(store::Database& db, std::int64_t collection);
/// \param answers whether its reader may see which answers are right
nlohmann::ordered_json question_result_json(const QuestionResult& result, bool answers);

/// What was done on a day of UTC, without practice.
struct Day {
  std::int64_t number = 0;     ///< of days since 1970-01-01
  std::int64_t submitted = 0;  ///< tasks
  std::int64_t reviewed = 0;   ///< verdicts; one that was changed counts again
};
/// The last `most` days on which something was done, by rising number.
std::vector<Day> days_of(store::Database& db, std::int64_t collection, std::size_t most);
/// {"day": "2026-11-30", "submitted", "reviewed"}
nlohmann::ordered_json day_json(const Day& day);

}  // namespace enfilade::service::collecting
