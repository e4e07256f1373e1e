#include "enfilade/tasks/formats/records.h"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::tasks::formats {
namespace {

enum OfTurn : std::size_t { kRole, kMessage, kTurnStep, kTurnFields };
constexpr std::array<json::Field, kTurnFields> kOfTurn{{{"role"}, {"message"}, {"nav_idx"}}};

enum OfWord : std::size_t { kWord, kStart, kEnd, kWordFields };
constexpr std::array<json::Field, kWordFields> kOfWord{
    {{"word"}, {"start_time", false}, {"end_time", false}}};

TimedWord read_word(json::Element element, const json::Path& path, json::Faults& faults) {
  TimedWord word;
  std::array<std::optional<json::Element>, kWordFields> found;
  if (!json::fields(element, kOfWord, found, path, faults)) return word;
  word.word = json::string(*found[kWord], json::Path(path, "word"), faults).value_or("");
  if (found[kStart]) {
    word.start = json::number(*found[kStart], json::Path(path, "start_time"), faults);
  }
  if (found[kEnd]) word.end = json::number(*found[kEnd], json::Path(path, "end_time"), faults);
  return word;
}

DialogueTurn read_turn(json::Element element, const json::Path& path, json::Faults& faults) {
  DialogueTurn turn;
  std::array<std::optional<json::Element>, kTurnFields> found;
  if (!json::fields(element, kOfTurn, found, path, faults)) return turn;
  const json::Path role(path, "role");
  if (const auto text = json::string(*found[kRole], role, faults)) {
    turn.role = *text;
    if (turn.role != "navigator" && turn.role != "oracle") {
      faults.error(role, "unknown-role",
                   fmt::format("{:?}, neither \"navigator\" nor \"oracle\"", turn.role));
    }
  }
  turn.message = json::string(*found[kMessage], json::Path(path, "message"), faults).value_or("");
  const json::Path step(path, "nav_idx");
  turn.nav_step = json::integer(*found[kTurnStep], step, faults).value_or(0);
  if (turn.nav_step < 0) {
    faults.error(step, "bad-step",
                 fmt::format("{} is no number of steps; 0 and more are", turn.nav_step));
  }
  return turn;
}

}  // namespace

std::vector<std::string> read_path(json::Element element, const json::Path& path,
                                   json::Faults& faults) {
  const std::size_t errors = faults.errors();
  std::vector<std::string> viewpoints = json::strings(element, path, faults);
  if (viewpoints.empty() && faults.errors() == errors) {
    faults.error(path, "empty-path", "no viewpoint; the start at least is expected");
  }
  return viewpoints;
}

Radians read_angle(json::Element element, const json::Path& path, json::Faults& faults) {
  return Radians(json::number(element, path, faults).value_or(0));
}

std::vector<std::int32_t> read_tokens(json::Element element, const json::Path& path,
                                      json::Faults& faults) {
  std::vector<std::int32_t> tokens;
  const auto list = json::array(element, path, faults);
  if (!list) return tokens;
  tokens.reserve(list->size());
  std::size_t k = 0;
  for (const json::Element one : *list) {
    const json::Path place(path, k++);
    const auto token = json::integer(one, place, faults);
    if (!token) continue;
    if (*token < 0 || *token > std::numeric_limits<std::int32_t>::max()) {
      faults.error(place, "bad-token",
                   fmt::format("{} is no token id; 0 to 2147483647 are", *token));
      continue;
    }
    tokens.push_back(static_cast<std::int32_t>(*token));
  }
  return tokens;
}

std::vector<DialogueTurn> read_turns(json::Element element, const json::Path& path,
                                     json::Faults& faults) {
  std::vector<DialogueTurn> turns;
  const auto list = json::array(element, path, faults);
  if (!list) return turns;
  for (const json::Element one : *list)
    turns.push_back(read_turn(one, json::Path(path, turns.size()), faults));
  return turns;
}

void refuse_large(std::size_t bytes, const json::Path& path, json::Faults& faults,
                  std::size_t most) {
  faults.error(path, "too-large", fmt::format("{} bytes; {} are allowed", bytes, most));
}

std::vector<TimedWord> read_timed_words(json::Element element, const json::Path& path,
                                        json::Faults& faults) {
  std::vector<TimedWord> words;
  const auto list = json::array(element, path, faults);
  if (!list) return words;
  words.reserve(list->size());
  for (const json::Element one : *list)
    words.push_back(read_word(one, json::Path(path, words.size()), faults));
  return words;
}

nlohmann::ordered_json timed_words_json(std::span<const TimedWord> words, std::string_view where) {
  auto list = nlohmann::ordered_json::array();
  const auto add = [&](nlohmann::ordered_json& one, const char* field,
                       const std::optional<double>& time) {
    if (!time) return;
    if (!std::isfinite(*time)) {
      throw ArgumentError(fmt::format("{}: {} {}, not a finite number", where, field, *time));
    }
    one[field] = *time;
  };
  for (const TimedWord& word : words) {
    nlohmann::ordered_json one;
    add(one, "start_time", word.start);
    one["word"] = word.word;
    add(one, "end_time", word.end);
    list.push_back(std::move(one));
  }
  return list;
}

void Once::check(const std::string& id, std::size_t record, const json::Path& path,
                 json::Faults& faults) {
  const auto [first, fresh] = places_.emplace(id, record);
  if (fresh) return;
  faults.error(path, code_, fmt::format("{:?} stands at $[{}] already", id, first->second));
}

}  // namespace enfilade::tasks::formats
