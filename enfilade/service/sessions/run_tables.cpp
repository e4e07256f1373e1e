#include "enfilade/service/sessions/run_tables.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/arena/session.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/service/detail/column_json.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::service::sessions {
namespace {

using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

/// An episode of a run, and what is known of it.
struct Row {
  const std::string* episode = nullptr;
  std::shared_ptr<const KnownEpisode> known;
  ShortScore score;
};

Row row_of(const Run& run, const NamedPath& transcript, KnownEpisodes& known) {
  Row row{&transcript.name, known.of(run, transcript), {}};
  row.score = score_of(run, *row.known);
  return row;
}

std::vector<Row> rows_of(const Run& run, KnownEpisodes& known) {
  std::vector<Row> rows;
  rows.reserve(run.transcripts.size());
  for (const NamedPath& one : run.transcripts) rows.push_back(row_of(run, one, known));
  return rows;
}

double tokens_of(const TranscriptSummary& summary) {
  return static_cast<double>(summary.prompt_tokens + summary.answer_tokens);
}

std::optional<double> sort_value(const Row& row, EpisodeSort sort) {
  const TranscriptSummary& summary = row.known->summary;
  const auto of_end = [&](std::uint64_t value) -> std::optional<double> {
    return summary.ending ? std::optional(static_cast<double>(value)) : std::nullopt;
  };
  switch (sort) {
    case EpisodeSort::kEpisode:
      break;
    case EpisodeSort::kSuccess:
      return row.score.success ? std::optional(*row.score.success ? 1.0 : 0.0) : std::nullopt;
    case EpisodeSort::kSpl:
      return row.score.spl;
    case EpisodeSort::kNavError:
      return row.score.nav_error;
    case EpisodeSort::kSteps:
      return of_end(summary.steps);
    case EpisodeSort::kMistakes:
      return of_end(summary.mistakes);
    case EpisodeSort::kUnanswered:
      return of_end(summary.unanswered);
    case EpisodeSort::kTokens:
      return of_end(summary.prompt_tokens + summary.answer_tokens);
  }
  return std::nullopt;
}

bool is_shown(const Row& row, EpisodeShow show) {
  const TranscriptSummary& summary = row.known->summary;
  switch (show) {
    case EpisodeShow::kAll:
      break;
    case EpisodeShow::kFailures:
      return row.score.success == false;
    case EpisodeShow::kSuccesses:
      return row.score.success == true;
    case EpisodeShow::kMistakes:
      return summary.mistakes + summary.unanswered > 0;
    case EpisodeShow::kUnstopped:
      return summary.ending != arena::Ending::kStopped;
  }
  return true;
}

/// Those with a value first, by it; the order is kept otherwise.
void sort_rows(std::vector<Row>& rows, EpisodeSort sort, bool descending) {
  if (sort == EpisodeSort::kEpisode) {
    if (descending) std::ranges::reverse(rows);
    return;
  }
  const auto key = [&](const Row& row) {
    const auto value = sort_value(row, sort);
    return std::pair(!value, (descending ? -1 : 1) * value.value_or(0));
  };
  std::ranges::stable_sort(rows, {}, key);
}

void add_score(const ShortScore& score, ordered_json& entry) {
  if (score.success) entry["success"] = *score.success;
  if (score.spl) entry["spl"] = *score.spl;
  if (score.nav_error) entry["nav_error"] = *score.nav_error;
}

/// How an episode ended, and its score.
void add_end(const Row& row, ordered_json& entry) {
  const TranscriptSummary& summary = row.known->summary;
  if (!summary.ending) {
    entry["problem"] = "the last line is no end of an episode";
    return;
  }
  entry["ending"] = arena::name_of(*summary.ending);
  if (!summary.reason.empty()) entry["reason"] = summary.reason;
  entry["steps"] = summary.steps;
  entry["mistakes"] = summary.mistakes;
  entry["unanswered"] = summary.unanswered;
  entry["prompt_tokens"] = summary.prompt_tokens;
  entry["answer_tokens"] = summary.answer_tokens;
  add_score(row.score, entry);
}

ordered_json entry_of(const Row& row) {
  ordered_json entry{{"episode", *row.episode}};
  const std::string& instruction = row.known->summary.instruction;
  if (!instruction.empty()) entry["instruction"] = instruction;
  add_end(row, entry);
  return entry;
}

/// Seconds and money, which `enfilade ask` writes.
void add_usage(const Run& run, ordered_json& out) {
  const auto usage = read_run_file(run.folder / "usage.json");
  if (!usage || !usage->is_object()) return;
  for (const char* name : {"seconds", "money"}) {
    const auto found = usage->find(name);
    if (found == usage->end() || !found->is_number()) continue;
    const double value = found->get<double>();
    if (std::isfinite(value) && value >= 0) out[name] = value;
  }
}

/// The means of the scored episodes, in the order of the scorer's columns.
ordered_json scores_of(const Run& run, const std::vector<Row>& rows, std::size_t& scored) {
  auto scores = ordered_json::array();
  if (!run.has_outcomes()) return scores;
  const tasks::Scorer& scorer = scorer_of(*run.served);
  std::vector<double> values;
  for (const Row& row : rows) {
    const auto& outcome = row.known->outcome;
    if (!outcome || outcome->values.empty()) continue;
    values.insert(values.end(), outcome->values.begin(), outcome->values.end());
    ++scored;
  }
  if (scored == 0) return scores;
  const std::vector<double> means = tasks::summarise(scorer, values);
  for (const tasks::Measure& measure : scorer.columns) {
    ordered_json column = detail::column_json(measure);
    column["mean"] = means[scorer.place_of(measure.name)] / measure.whole;  // null if not finite
    scores.push_back(std::move(column));
  }
  return scores;
}

/// An episode that two runs have.
struct RowPair {
  Row first, second;
  std::size_t group = 0;  // of the bootstrap
};

/// Numbers of groups, in the order in which they come: instructions of one path, and paths that
/// belong together, are one.
class GroupNumbers {
 public:
  std::size_t of(const Run& run, const std::string& episode) {
    const EpisodePlace* place = run.find(episode);
    std::string name = "episode " + episode;
    if (place != nullptr && place->path->group) {
      name = fmt::format("group {}", *place->path->group);
    } else if (place != nullptr) {
      name = fmt::format("path {}", place->path - place->split->annotations.paths.data());
    }
    return numbers_.try_emplace(std::move(name), numbers_.size()).first->second;
  }

 private:
  std::map<std::string, std::size_t> numbers_;
};

bool differ(const RowPair& pair) {
  const Row &first = pair.first, &second = pair.second;
  if (first.score.success && second.score.success) {
    return first.score.success != second.score.success;
  }
  const auto end_of = [](const Row& row) {
    return row.known->outcome ? row.known->outcome->end : std::string();
  };
  return first.known->summary.ending != second.known->summary.ending ||
         end_of(first) != end_of(second);
}

using Value = std::function<std::optional<double>(const Row&)>;

/// A column of the comparison; null if no episode has it in both runs.
ordered_json compare_column(ordered_json column, const std::vector<RowPair>& pairs,
                            const Value& value) {
  std::vector<double> first, second;
  std::vector<std::size_t> groups;
  for (const RowPair& pair : pairs) {
    const auto one = value(pair.first), other = value(pair.second);
    if (!one || !other) continue;
    first.push_back(*one);
    second.push_back(*other);
    groups.push_back(pair.group);
  }
  if (groups.empty()) return {};
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double one : values) sum += one;
    return sum / static_cast<double>(values.size());
  };
  const tasks::PairedDifference found =
      tasks::paired_bootstrap(first, second, 1, groups, {.threads = 1}).front();
  column["episodes"] = groups.size();
  column["first"] = mean(first);
  column["second"] = mean(second);
  column["difference"] = {{"mean", found.difference.mean},
                          {"low", found.difference.low},
                          {"high", found.difference.high}};
  column["p"] = found.p;
  return column;
}

/// Columns that every run has.
std::vector<std::pair<ordered_json, Value>> plain_columns() {
  const auto column = [](const char* name, const char* title, const char* unit) {
    return ordered_json{
        {"name", name}, {"short", title}, {"title", title}, {"unit", unit}, {"better", "lower"}};
  };
  const auto of_end = [](double (*count)(const TranscriptSummary&)) -> Value {
    return [count](const Row& row) -> std::optional<double> {
      const TranscriptSummary& summary = row.known->summary;
      return summary.ending ? std::optional(count(summary)) : std::nullopt;
    };
  };
  return {{column("steps", "Steps", "count"),
           of_end([](const TranscriptSummary& s) { return static_cast<double>(s.steps); })},
          {column("mistakes", "Mistakes", "count"),
           of_end([](const TranscriptSummary& s) { return static_cast<double>(s.mistakes); })},
          {column("unanswered", "Empty responses", "count"),
           of_end([](const TranscriptSummary& s) { return static_cast<double>(s.unanswered); })},
          {column("tokens", "Tokens", "count"), of_end(tokens_of)}};
}

ordered_json columns_of(const Run& run, const std::vector<RowPair>& pairs) {
  auto columns = ordered_json::array();
  const auto add = [&](ordered_json head, const Value& value) {
    ordered_json column = compare_column(std::move(head), pairs, value);
    if (!column.is_null()) columns.push_back(std::move(column));
  };
  if (run.has_outcomes()) {
    const tasks::Scorer& scorer = scorer_of(*run.served);
    for (const tasks::Measure& measure : scorer.columns) {
      add(detail::column_json(measure),
          [&](const Row& row) { return value_of(*row.known, scorer, measure); });
    }
  }
  for (auto& [head, value] : plain_columns()) add(std::move(head), value);
  return columns;
}

std::string split_text(const Run& run) {
  return fmt::format("{}/{}", run.task.value_or("unknown"), run.split.value_or("unknown"));
}

}  // namespace

ordered_json episode_list(const Run& run, KnownEpisodes& known, const EpisodeQuery& query) {
  const bool by_success =
      query.show == EpisodeShow::kFailures || query.show == EpisodeShow::kSuccesses;
  if (by_success && !run.has_outcomes()) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("show: {}; this server does not have the goals of {}, so success is "
                              "not known",
                              enum_name(query.show), split_text(run)));
  }
  auto list = ordered_json::array();
  const auto add_page = [&](std::size_t size, const auto& entry_at) {
    for (std::size_t k = query.offset; k < size && list.size() < query.limit; ++k) {
      list.push_back(entry_at(k));
    }
  };
  const std::vector<NamedPath>& all = run.transcripts;
  std::size_t matching = all.size();
  if (query.show == EpisodeShow::kAll && query.sort == EpisodeSort::kEpisode) {
    add_page(matching, [&](std::size_t k) {  // only the page is read
      return entry_of(row_of(run, all[query.descending ? matching - 1 - k : k], known));
    });
  } else {
    std::vector<Row> rows = rows_of(run, known);
    std::erase_if(rows, [&query](const Row& row) { return !is_shown(row, query.show); });
    sort_rows(rows, query.sort, query.descending);
    matching = rows.size();
    add_page(matching, [&rows](std::size_t k) { return entry_of(rows[k]); });
  }
  return {{"matching", matching}, {"list", std::move(list)}};
}

ordered_json measures_json(const Run& run, KnownEpisodes& known) {
  const std::vector<Row> rows = rows_of(run, known);
  std::size_t ended = 0, scored = 0;
  std::uint64_t steps = 0, mistakes = 0, unanswered = 0, prompt_tokens = 0, answer_tokens = 0;
  for (const Row& row : rows) {
    const TranscriptSummary& summary = row.known->summary;
    ended += summary.ending ? 1 : 0;
    steps += summary.steps;
    mistakes += summary.mistakes;
    unanswered += summary.unanswered;
    prompt_tokens += summary.prompt_tokens;
    answer_tokens += summary.answer_tokens;
  }
  ordered_json scores = scores_of(run, rows, scored);
  ordered_json out{{"ended", ended},
                   {"steps", steps},
                   {"mistakes", mistakes},
                   {"unanswered", unanswered},
                   {"prompt_tokens", prompt_tokens},
                   {"answer_tokens", answer_tokens}};
  add_usage(run, out);
  out["scored"] = scored;
  out["scores"] = std::move(scores);
  return out;
}

ordered_json compare_json(const Run& first, const Run& second, KnownEpisodes& known,
                          std::size_t offset, std::size_t limit) {
  if (first.task != second.task || first.split != second.split || !first.task || !first.split) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("{} is a run of {}, and {} of {}: two runs of one split can be "
                              "compared",
                              first.name, split_text(first), second.name, split_text(second)));
  }
  std::map<std::string_view, const NamedPath*> others;
  for (const NamedPath& one : second.transcripts) others.emplace(one.name, &one);
  std::vector<RowPair> pairs;
  GroupNumbers groups;
  for (const NamedPath& one : first.transcripts) {
    const auto other = others.find(one.name);
    if (other == others.end()) continue;
    pairs.push_back({row_of(first, one, known), row_of(second, *other->second, known),
                     groups.of(first, one.name)});
  }
  ordered_json out{{"episodes", pairs.size()},
                   {"only_first", first.transcripts.size() - pairs.size()},
                   {"only_second", second.transcripts.size() - pairs.size()},
                   {"outcomes", first.has_outcomes()},
                   {"columns", columns_of(first, pairs)}};
  std::erase_if(pairs, [](const RowPair& pair) { return !differ(pair); });
  out["differing"] = pairs.size();
  ordered_json& list = out["list"] = ordered_json::array();
  for (std::size_t k = offset; k < pairs.size() && list.size() < limit; ++k) {
    const RowPair& pair = pairs[k];
    ordered_json& entry = list.emplace_back(ordered_json{{"episode", *pair.first.episode}});
    const std::string& instruction = pair.first.known->summary.instruction;
    if (!instruction.empty()) entry["instruction"] = instruction;
    add_end(pair.first, entry["first"] = ordered_json::object());
    add_end(pair.second, entry["second"] = ordered_json::object());
  }
  return out;
}

}  // namespace enfilade::service::sessions
