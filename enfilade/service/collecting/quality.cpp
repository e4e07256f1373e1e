#include "enfilade/service/collecting/quality.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostLeast = 20;
constexpr std::size_t kItemsAtOnce = 500;
constexpr std::int64_t kDaySeconds = 86'400;

/// How often a text has each of its words, and how many they are.
struct CountedWords {
  std::map<std::string, std::int64_t> counts;
  std::int64_t all = 0;
};

CountedWords counted_words(std::string_view text) {
  const auto is_word = [](unsigned char c) {
    return c > 127 || c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z');
  };
  CountedWords words;
  for (const std::string& token : tasks::tokenize(text)) {
    if (std::ranges::none_of(token, is_word)) continue;  // punctuation
    ++words.counts[token];
    ++words.all;
  }
  return words;
}

double f1(const CountedWords& a, const CountedWords& b) {
  if (a.all == 0 || b.all == 0) return 0;
  std::int64_t shared = 0;
  for (const auto& [word, count] : a.counts) {
    const auto other = b.counts.find(word);
    if (other != b.counts.end()) shared += std::min(count, other->second);
  }
  return 2.0 * static_cast<double>(shared) / static_cast<double>(a.all + b.all);
}

/// A task as it is compared with others of its item.
struct Done {
  std::int64_t item = 0, path_id = 0;
  std::size_t number = 0;
  std::string content;
  std::optional<double> error;

  auto columns() { return std::tie(item, path_id, number, content, error); }
};

/// A mean that grows.
struct Mean {
  double sum = 0;
  std::int64_t count = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
  std::optional<double> value() const {
    return count > 0 ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
  }
};

/// Compares the tasks of item after item.
class Comparison {
 public:
  explicit Comparison(WorkKind kind) : kind_(kind) { agreement_.of_texts = shows_path(kind); }

  /// \param done tasks of one item, two at least
  void add(const std::vector<Done>& done) {
    const Mean pairs = agreement_.of_texts ? compare_texts(done) : compare_outcomes(done);
    const double value = pairs.value().value_or(0);
    mean_.add(value);
    agreement_.pairs += pairs.count;
    least_.push_back(
        {done[0].path_id, done[0].number, static_cast<std::int64_t>(done.size()), value});
  }

  Agreement result() {
    std::ranges::stable_sort(least_, {}, &ItemAgreement::value);
    if (least_.size() > kMostLeast) least_.resize(kMostLeast);
    agreement_.least = std::move(least_);
    agreement_.items = mean_.count;
    agreement_.mean = mean_.value();
    agreement_.others = others_.value();
    agreement_.metres = metres_.value();
    agreement_.success = success_.value();
    return std::move(agreement_);
  }

 private:
  std::string text_of(const Done& task) const {
    if (kind_ != WorkKind::kGuide) return task.content;
    return ordered_json::parse(task.content).at("instruction").get<std::string>();
  }

  Mean compare_texts(const std::vector<Done>& done) {
    std::vector<CountedWords> texts;
    for (const Done& task : done) texts.push_back(counted_words(text_of(task)));
    if (before_ && before_->first != done[0].path_id) others_.add(f1(before_->second, texts[0]));
    before_ = {done[0].path_id, texts[0]};
    Mean pairs;
    for (std::size_t a = 0; a < texts.size(); ++a) {
      for (std::size_t b = a + 1; b < texts.size(); ++b) pairs.add(f1(texts[a], texts[b]));
    }
    return pairs;
  }

  Mean compare_outcomes(const std::vector<Done>& done) {
    const auto reached = [](const Done& task) {
      return task.error && *task.error < tasks::MetricOptions{}.success_distance;
    };
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Mean pairs;
    for (std::size_t a = 0; a < done.size(); ++a) {
      success_.add(reached(done[a]) ? 1 : 0);
      for (std::size_t b = a + 1; b < done.size(); ++b) {
        pairs.add(reached(done[a]) == reached(done[b]) ? 1 : 0);
        const double metres = std::abs(done[a].error.value_or(kFar) - done[b].error.value_or(kFar));
        if (kind_ != WorkKind::kFind && std::isfinite(metres)) metres_.add(metres);
      }
    }
    return pairs;
  }

  WorkKind kind_;
  Agreement agreement_;
  Mean mean_, others_, metres_, success_;
  std::optional<std::pair<std::int64_t, CountedWords>>
      before_;  ///< path and first text of the last item
  std::vector<ItemAgreement> least_;
};

/// Tasks that are compared. ?2: whether those of secret goals are
constexpr std::string_view kCompared =
    "FROM task JOIN item ON item.id = task.item WHERE collection = ?1 AND practice = 0 AND "
    "task.state IN ('submitted', 'accepted') AND role <> 'oracle' AND (secret = 0 OR ?2 = 1)";

struct Choice {
  std::string text;
  std::int64_t count = 0;
  bool accepted = false;

  auto columns() { return std::tie(text, count, accepted); }
};

struct DayCount {
  std::int64_t day = 0, count = 0;

  auto columns() { return std::tie(day, count); }
};

ordered_json or_null(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json();
}

}  // namespace

double token_f1(std::string_view a, std::string_view b) {
  return f1(counted_words(a), counted_words(b));
}

Agreement agreement_of(store::Database& db, const Collection& collection, bool secrets) {
  const bool all = secrets || shows_path(collection.kind);
  // Without hold(): to compare all texts takes long, and other requests use the database meanwhile.
  const auto items = db.select<std::int64_t>(
      fmt::format("SELECT item.id {} GROUP BY item.id HAVING count(*) > 1 ORDER BY item.id",
                  kCompared),
      collection.id, all);
  Comparison comparison(collection.kind);
  for (std::size_t k = 0; k < items.size(); k += kItemsAtOnce) {
    const std::size_t last = std::min(k + kItemsAtOnce, items.size()) - 1;
    const auto done = db.select<Done>(
        fmt::format("SELECT item.id, path_id, number, content, error {} AND item.id BETWEEN ?3 "
                    "AND ?4 ORDER BY item.id, task.id",
                    kCompared),
        collection.id, all, items[k], items[last]);
    for (auto begin = done.begin(); begin != done.end();) {
      const auto end = std::find_if(
          begin, done.end(), [&begin](const Done& task) { return task.item != begin->item; });
      if (end - begin > 1) comparison.add(std::vector<Done>(begin, end));
      begin = end;
    }
  }
  return comparison.result();
}

ordered_json agreement_json(const Agreement& agreement) {
  ordered_json out{{"measure", agreement.of_texts ? "token-f1" : "same-outcome"},
                   {"items", agreement.items},
                   {"pairs", agreement.pairs},
                   {"mean", or_null(agreement.mean)}};
  if (agreement.of_texts) {
    out["others"] = or_null(agreement.others);
  } else {
    out["success"] = or_null(agreement.success);
    out["metres"] = or_null(agreement.metres);
  }
  out["least"] = detail::json_list(agreement.least, [](const ItemAgreement& one) {
    return ordered_json{{"path_id", one.path_id},
                        {"number", one.number},
                        {"tasks", one.tasks},
                        {"value", one.value}};
  });
  return out;
}

std::vector<QuestionResult> question_results(store::Database& db, std::int64_t collection) {
  const auto held = db.hold();
  std::vector<QuestionResult> results;
  for (Question& question : questions_of(db, collection)) {
    QuestionResult result{std::move(question), {}};
    result.chosen.resize(result.question.choices.size());
    const auto given = db.select<Choice>(
        "SELECT choice, count(*), max(accepted) FROM answer WHERE question = ? GROUP BY choice",
        result.question.id);
    for (const Choice& one : given) {
      result.answered += one.count;
      if (one.accepted) result.right += one.count;
      const auto found = std::ranges::find(result.question.choices, one.text);
      if (found == result.question.choices.end()) continue;
      result.chosen[static_cast<std::size_t>(found - result.question.choices.begin())] = one.count;
    }
    results.push_back(std::move(result));
  }
  return results;
}

ordered_json question_result_json(const QuestionResult& result, bool answers) {
  const Question& question = result.question;
  ordered_json out{{"question", question.id},
                   {"stage", enum_name(question.stage)},
                   {"text", question.text},
                   {"answered", result.answered},
                   {"right", result.right}};
  if (!answers) return out;
  auto& choices = out["choices"] = ordered_json::array();
  for (std::size_t k = 0; k < question.choices.size(); ++k) {
    const std::string& text = question.choices[k];
    choices.push_back({{"choice", text},
                       {"chosen", result.chosen[k]},
                       {"right", std::ranges::count(question.accepted, text) > 0}});
  }
  return out;
}

std::vector<Day> days_of(store::Database& db, std::int64_t collection, std::size_t most) {
  const auto held = db.hold();
  const auto limit = static_cast<std::int64_t>(most);
  std::map<std::int64_t, Day> days;
  const auto count = [&](const char* sql, std::int64_t Day::*what) {
    for (const DayCount& one : db.select<DayCount>(sql, collection, limit)) {
      days[one.day].number = one.day;
      days[one.day].*what = one.count;
    }
  };
  count(
      "SELECT submitted / 86400 AS day, count(*) FROM task JOIN item ON item.id = task.item WHERE "
      "collection = ?1 AND practice = 0 AND submitted > 0 GROUP BY submitted / 86400 ORDER BY "
      "submitted / 86400 DESC LIMIT ?2",
      &Day::submitted);
  count(
      "SELECT event.at / 86400 AS day, count(*) FROM event JOIN task ON task.id = event.task JOIN "
      "item ON item.id = task.item WHERE collection = ?1 AND practice = 0 AND what IN ('accepted', "
      "'rejected') GROUP BY event.at / 86400 ORDER BY event.at / 86400 DESC LIMIT ?2",
      &Day::reviewed);
  std::vector<Day> found;
  for (const auto& [number, day] : days) found.push_back(day);
  if (found.size() > most) found.erase(found.begin(), found.end() - limit);
  return found;
}

ordered_json day_json(const Day& day) {
  return {{"day", detail::iso_time(day.number * kDaySeconds).substr(0, 10)},
          {"submitted", day.submitted},
          {"reviewed", day.reviewed}};
}

}  // namespace enfilade::service::collecting
