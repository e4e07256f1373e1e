#include "enfilade/arena/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <utility>

#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

constexpr std::size_t kQuoted = 60;  // characters of an answer, in a message to its author

std::vector<std::string_view> parts_of(std::string_view list) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t comma = list.find(',');
    parts.push_back(trimmed(list.substr(0, comma)));
    if (comma == std::string_view::npos) return parts;
    list.remove_prefix(comma + 1);
  }
}

/// The allowed value that a text means. Models write "b" for "B", and "STOP".
const std::string* find_value(const ToolUse& use, std::string_view text) {
  const auto found = std::ranges::find_if(
      use.allowed, [text](const std::string& one) { return detail::is_same(one, text); });
  return found == use.allowed.end() ? nullptr : &*found;
}

std::string quoted(std::string_view text) { return fmt::format("{:?}", text.substr(0, kQuoted)); }

/// Reads the values of a call. \returns what is wrong with it; empty: nothing
std::string read_values(const ToolUse& use, std::string_view argument,
                        std::vector<std::string>& values) {
  const std::string_view tool = name_of(use.tool);
  if (use.argument.empty()) {
    return trimmed(argument).empty() ? "" : fmt::format("{} has no argument", tool);
  }
  const auto parts = use.list ? parts_of(argument) : std::vector{trimmed(argument)};
  if (parts.size() > kMostMoves) {
    return fmt::format("{}: {} {}; 1 to {} are possible", tool, parts.size(), use.argument,
                       kMostMoves);
  }
  for (const std::string_view part : parts) {
    const std::string* value = find_value(use, part);
    if (value == nullptr) {
      return fmt::format("{}: {} {} is not one of {}", tool, use.argument, quoted(part),
                         fmt::join(use.allowed, ", "));
    }
    values.push_back(*value);
  }
  return {};
}

}  // namespace

void validate(const SessionLimits& limits) {
  if (limits.steps == 0) throw ArgumentError("limits.steps: 0, at least 1");
  if (limits.mistakes == 0) throw ArgumentError("limits.mistakes: 0, at least 1");
}

bool Session::call(const Call& call) {
  if (ending_) return false;
  const std::string_view wanted = trimmed(call.tool);
  const auto use = std::ranges::find_if(seen_.tools, [wanted](const ToolUse& one) {
    return detail::is_same(name_of(one.tool), wanted);
  });
  if (use == seen_.tools.end()) {
    std::vector<std::string_view> names;
    for (const ToolUse& one : seen_.tools) names.push_back(name_of(one.tool));
    refuse(fmt::format("there is no {} here, but {}", quoted(wanted), fmt::join(names, ", ")));
    return false;
  }
  std::vector<std::string> values;
  const std::string fault = read_values(*use, call.argument, values);
  if (!fault.empty()) {
    refuse(fault);
    return false;
  }
  last_call_ = {std::string(name_of(use->tool)), fmt::format("{}", fmt::join(values, ","))};
  ++seen_.step;
  in_a_row_ = 0;
  carry_out(use->tool, values);
  if (!ending_ && seen_.step >= limits_.steps) end(Ending::kOutOfSteps);
  if (!ending_) look_around(seen_);
  return true;
}

void Session::misread(std::string_view why) {
  if (!ending_) refuse(why);
}

void Session::break_off() {
  if (!ending_ || ending_ == Ending::kMistakes) end(Ending::kRefused);
}

void Session::refuse(std::string_view why) {
  ++mistakes_;
  tell(fmt::format("Nothing was done: {}.", why));
  if (++in_a_row_ >= limits_.mistakes) end(Ending::kMistakes);
}

void Session::end(Ending ending) {
  ending_ = ending;
  seen_.tools.clear();
  seen_.places.clear();
  seen_.things.clear();
}

}  // namespace enfilade::arena
