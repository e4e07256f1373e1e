#include "enfilade/arena/prompt.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <kainjow/mustache.hpp>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/arena/detail/prompt_files.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using kainjow::mustache::data;
using kainjow::mustache::mustache;

constexpr std::uint32_t kMostKept = 100;

struct BuiltIn {
  std::string_view name, text;
};
std::array<BuiltIn, 4> built_in() {
  return {{{"text", detail::kTextPrompt},
           {"marks", detail::kMarksPrompt},
           {"navgpt", detail::kNavgptPrompt},
           {"mapgpt", detail::kMapgptPrompt}}};
}

[[noreturn]] void refuse(const std::string& file, std::size_t line, const char* code,
                         std::string text) {
  throw InvalidInput(
      {{Severity::kError, file, fmt::format("line {}", line), code, std::move(text)}});
}

template <class Enum>
Enum read_name(std::string_view value, const std::string& file, std::size_t line) {
  const auto found = find_enum<Enum>(value);
  if (!found) {
    refuse(
        file, line, "bad-value",
        fmt::format("{:?}, not one of {}", value.substr(0, 40), fmt::join(names_of(Enum()), ", ")));
  }
  return *found;
}

void read_head(std::string_view line, const std::string& file, std::size_t number,
               PromptParts& parts) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) {
    refuse(file, number, "bad-head", R"(not "name: value", nor "---")");
  }
  const std::string_view name = trimmed(line.substr(0, colon));
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (name == "pictures") {
    parts.pictures = read_name<PictureKind>(value, file, number);
  } else if (name == "answers") {
    parts.answers = read_name<Answers>(value, file, number);
  } else if (name == "memory") {
    parts.memory = read_name<PromptMemory>(value, file, number);
  } else if (name == "kept_pictures") {
    const auto kept = parse_number<std::uint32_t>(value);
    if (!kept || *kept > kMostKept) {
      refuse(file, number, "bad-value",
             fmt::format("{:?}, not a whole number from 0 to {}", value.substr(0, 40), kMostKept));
    }
    parts.kept_pictures = *kept;
  } else {
    refuse(file, number, "unknown-name",
           fmt::format("{:?}, not pictures, answers, memory or kept_pictures", name.substr(0, 40)));
  }
}

/// Of the values that step_data() has.
constexpr std::array<std::string_view, 28> kTags{
    "answer_rule", "call",      "category", "direction",   "distance", "elevation_words",
    "heading",     "here",      "history",  "instruction", "is_here",  "leads_to",
    "map",         "moving",    "name",     "number",      "places",   "seen_before",
    "step",        "steps",     "things",   "thought",     "told",     "turn",
    "turn_words",  "unvisited", "visited",  "what"};

/// Mustache renders nothing for a tag that it does not have a value for, nor for a partial.
void check_tags(std::string_view text, const std::string& file, std::size_t line) {
  std::size_t at = 0;
  for (std::size_t open = 0; (open = text.find("{{", at)) != std::string_view::npos;) {
    line += static_cast<std::size_t>(std::ranges::count(text.substr(at, open - at), '\n'));
    at = std::min(text.find("}}", open), text.size());
    std::string_view tag = text.substr(open + 2, at - open - 2);
    // As the library reads it: blanks may stand before the sign, but not before the third brace.
    const bool is_plain = tag.starts_with('{');
    if (is_plain) tag.remove_prefix(1);
    tag = trimmed(tag);
    if (!is_plain && tag.starts_with('!')) continue;  // a comment
    if (tag.starts_with('=') || tag.starts_with('>')) {
      refuse(file, line, "bad-tag",
             fmt::format("{}: partials and other delimiters are not supported", quote(tag)));
    }
    const bool has_sign = !is_plain && tag.find_first_of("&#^/") == 0;
    const std::string_view name = has_sign ? trimmed(tag.substr(1)) : tag;
    if (std::ranges::find(kTags, name) == kTags.end()) {
      refuse(file, line, "unknown-tag",
             fmt::format("{}, not one of {}", quote(name), fmt::join(kTags, ", ")));
    }
  }
}

PromptParts read_parts(std::string_view text, const std::string& file) {
  PromptParts parts;
  std::array<std::size_t, 2> begins{};  // lines
  std::size_t number = 0, section = 0;
  for (const std::string_view line : all_lines(text)) {
    ++number;
    if (trimmed(line) == "---") {
      if (++section > 2) refuse(file, number, "third-text", "a third text; there are two");
      begins.at(section - 1) = number + 1;
    } else if (section > 0) {
      std::string& part = section == 1 ? parts.start : parts.step;
      part += line;
      part += '\n';
    } else if (!trimmed(line).empty()) {
      read_head(line, file, number, parts);
    }
  }
  if (section < 2) {
    refuse(file, number, "missing-text",
           "the texts of the start and of a step are expected, each after a line \"---\"");
  }
  for (const std::size_t k : {0U, 1U}) {
    mustache compiled(k == 0 ? parts.start : parts.step);
    if (!compiled.is_valid()) refuse(file, begins[k], "bad-tag", compiled.error_message());
    check_tags(k == 0 ? parts.start : parts.step, file, begins[k]);
  }
  return parts;
}

/// "ahead on the right"
std::string direction_of(Radians turn) {
  constexpr std::array<std::string_view, 8> kDirections{
      "Ahead",  "Ahead on the right", "Right", "Behind on the right",
      "Behind", "Behind on the left", "Left",  "Ahead on the left"};
  const auto eighth = static_cast<int>(std::lround(to_degrees(turn) / 45));
  return std::string(kDirections[static_cast<std::size_t>((eighth + 8) % 8)]);
}

/// ", upstairs" where the way goes up or down enough to be seen.
std::string elevation_words(Radians elevation) {
  constexpr double kNoticed = 10;  // degrees
  const double degrees = to_degrees(elevation);
  if (std::abs(degrees) < kNoticed) return "";
  return fmt::format(", {:.0f} degrees {}", std::abs(degrees), degrees > 0 ? "up" : "down");
}

std::string text_of_list(const std::vector<std::string>& list) {
  return fmt::format("{}", fmt::join(list, ", "));
}

std::string answer_rule(Answers answers) {
  constexpr std::array kRules{
      "Each of your answers calls one tool.",
      R"(Answer with JSON alone: {"thought": what you think, "tool": one of the tools, "argument": its value, or null if it has none}.)",
      "End each answer with a line of this form: \"Action: \", the tool, a blank, and its value if "
      "it has one."};
  return kRules[static_cast<std::size_t>(answers)];
}

/// The tools in words, for models that get no tools from the protocol.
std::string tools_text(const SessionObservation& seen) {
  std::string text;
  for (const ToolUse& use : seen.tools) {
    text += std::string(name_of(use.tool));
    if (!use.argument.empty()) {
      text += fmt::format(
          " <{}: {}{}>", use.argument,
          use.list ? fmt::format("one to {}, with commas between, of ", kMostMoves) : "",
          text_of_list(use.allowed));
    }
    text += "\n";
  }
  return text;
}

data places_data(const SessionObservation& seen) {
  data places(data::type::list);
  for (const Neighbour& one : seen.places) {
    data place;
    place["name"] = one.name;
    place["turn"] = fmt::format("{:.0f}", to_degrees(one.turn));
    place["turn_words"] = turn_words(one.turn);
    place["direction"] = direction_of(one.turn);
    place["elevation_words"] = elevation_words(one.elevation);
    place["distance"] = fmt::format("{:.1f}", one.distance);
    place["visited"] = one.visited;
    place["seen_before"] = one.seen_before;
    place["what"] = one.what.empty() ? data(false) : data(one.what);
    places.push_back(place);
  }
  return places;
}

data things_data(const SessionObservation& seen) {
  data things(data::type::list);
  for (const VisibleObject& one : seen.things) {
    data thing;
    thing["name"] = one.name;
    thing["category"] = one.category;
    thing["turn_words"] = turn_words(one.turn);
    things.push_back(thing);
  }
  return things;
}

void add_map(const SessionObservation& seen, data& all) {
  data map(data::type::list);
  std::set<std::string> visited;
  std::vector<std::string> open;
  for (const MappedPlace& one : seen.map) visited.insert(one.name);
  for (const MappedPlace& one : seen.map) {
    data place;
    place["name"] = one.name;
    place["leads_to"] = text_of_list(one.leads_to);
    place["is_here"] = one.name == seen.here;
    map.push_back(place);
    for (const std::string& next : one.leads_to) {
      if (!visited.contains(next) && std::ranges::find(open, next) == open.end()) {
        open.push_back(next);
      }
    }
  }
  std::ranges::sort(open, {},
                    [](const std::string& name) { return detail::number_of_letters(name); });
  all["map"] = std::move(map);
  all["unvisited"] = open.empty() ? data(false) : data(text_of_list(open));
}

data step_data(const SessionObservation& seen, Answers answers, const SessionLimits& limits,
               std::span<const PastStep> past) {
  data all;
  all["instruction"] = seen.instruction;
  all["answer_rule"] = answer_rule(answers);
  all["step"] = std::to_string(seen.step + 1);
  all["steps"] = std::to_string(limits.steps);
  all["heading"] = fmt::format("{:.0f}", to_degrees(seen.heading));
  all["what"] = seen.what.empty() ? data(false) : data(seen.what);
  all["here"] = seen.here;
  all["moving"] = seen.here.empty();
  all["told"] = seen.told.empty() ? data(false) : data(seen.told);
  all["places"] = places_data(seen);
  all["things"] = things_data(seen);
  add_map(seen, all);
  data history(data::type::list);
  for (std::size_t k = 0; k < past.size(); ++k) {
    data one;
    one["number"] = std::to_string(k + 1);
    one["thought"] = past[k].thought.empty() ? data(false) : data(past[k].thought);
    one["call"] = past[k].call.empty() ? "none" : past[k].call;
    one["told"] = past[k].told;
    history.push_back(one);
  }
  all["history"] = std::move(history);
  return all;
}

std::string fill(const std::string& text, const data& values) {
  mustache compiled(text);
  compiled.set_custom_escape([](const std::string& value) { return value; });  // it is no HTML
  return std::string(trimmed(compiled.render(values)));
}

}  // namespace

Prompt Prompt::parse(std::string_view text, const std::string& file, std::string name) {
  return {std::move(name), std::string(text), read_parts(text, file)};
}

Prompt Prompt::load(const std::filesystem::path& file) {
  return parse(read_plain_text(file), file.string(), file.stem().string());
}

PastStep past_step(const Reading& reading, std::string told) {
  PastStep step{.thought = reading.thought, .call = {}, .told = std::move(told)};
  if (reading.call) {
    step.call = reading.call->tool;
    if (!reading.call->argument.empty()) step.call += " " + reading.call->argument;
  }
  return step;
}

Prompt Prompt::open(const std::string& name_or_file) {
  return std::filesystem::path(name_or_file).has_extension() ? load(name_or_file)
                                                             : named(name_or_file);
}

Prompt Prompt::named(std::string_view name) {
  const auto known = built_in();
  const auto found = std::ranges::find(known, name, &BuiltIn::name);
  if (found == known.end()) {
    throw LookupError(
        fmt::format("no prompt {:?}; there are {}", name, fmt::join(Prompt::names(), ", ")));
  }
  return parse(found->text, fmt::format("prompt {}", name), std::string(name));
}

std::vector<std::string> Prompt::names() {
  std::vector<std::string> names;
  for (const BuiltIn& one : built_in()) names.emplace_back(one.name);
  return names;
}

std::string Prompt::start(const SessionObservation& seen, Answers answers,
                          const SessionLimits& limits) const {
  return fill(parts_.start, step_data(seen, answers, limits, {}));
}

std::string Prompt::step(const SessionObservation& seen, Answers answers,
                         const SessionLimits& limits, std::span<const PastStep> past) const {
  std::string text = fill(parts_.step, step_data(seen, answers, limits, past));
  if (answers != Answers::kTools) text += "\n\nTools:\n" + tools_text(seen);
  return text;
}

std::string turn_words(Radians turn) {
  constexpr double kStraight = 10, kBehind = 170;  // degrees
  const double right = to_degrees(turn);
  if (std::abs(right) < kStraight) return "straight on";
  if (std::abs(right) > kBehind) return "behind you";
  return fmt::format("{:.0f} degrees to the {}", std::abs(right), right > 0 ? "right" : "left");
}

}  // namespace enfilade::arena
