#include "enfilade/arena/wire.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/arena/detail/limits.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/names.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value, double parts) { return std::round(value * parts) / parts + 0.0; }
double degrees_of(Radians angle) { return rounded(to_degrees(angle), 100); }
double metres_of(double length) { return rounded(length, 1000); }

/// Discarded: no JSON, or none within limits.
Json parse_within_limits(std::string_view text) {
  const bool within = json::excess(text, detail::kAnswerLimits).empty();
  return within ? Json::parse(text, nullptr, false) : Json(Json::value_t::discarded);
}

/// What is between the first { and the last }, which models put into ``` marks or sentences.
std::string_view object_in(std::string_view text) {
  const std::size_t first = text.find('{'), last = text.rfind('}');
  if (first == std::string_view::npos || last == std::string_view::npos || last < first) return {};
  return text.substr(first, last - first + 1);
}

/// Where the object that begins at `begin` ends, past its brace; npos: it is not complete.
std::size_t end_of_object(std::string_view text, std::size_t begin) {
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t k = begin; k < text.size(); ++k) {
    const char c = text[k];
    if (in_string) {
      if (c == '\\') {
        ++k;
      } else if (c == '"') {
        in_string = false;
      }
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{') {
      ++depth;
    } else if (c == '}' && --depth == 0) {
      return k + 1;
    }
  }
  return std::string_view::npos;
}

/// The last complete object with a "tool", else the last one; discarded without any.
Json last_object_in(std::string_view text) {
  // Braces without an object behind them; fewer in long texts, which are read for each.
  constexpr std::size_t kMostTries = 1000, kMostTried = 32U << 20U;
  const std::size_t most_tries = std::min(kMostTries, 1 + kMostTried / (text.size() + 1));
  Json last(Json::value_t::discarded);
  bool has_tool = false;
  std::size_t at = text.find('{');
  for (std::size_t tries = 0; at != std::string_view::npos && tries < most_tries;) {
    const std::size_t end = end_of_object(text, at);
    Json object = end == std::string_view::npos ? Json(Json::value_t::discarded)
                                                : parse_within_limits(text.substr(at, end - at));
    if (!object.is_object()) {
      ++tries;
      at = text.find('{', at + 1);
      continue;
    }
    const bool names_tool = object.contains("tool");
    if (names_tool || !has_tool) last = std::move(object);
    has_tool = has_tool || names_tool;
    at = text.find('{', end);
  }
  return last;
}

Reading fault(std::string text) { return {std::nullopt, {}, std::move(text)}; }

/// The text of a value: of a list, also one that was sent as a text, its parts with commas between.
/// None for others.
std::optional<std::string> value_text(const Json& value) {
  if (value.is_null()) return "";
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    const Json list = parse_within_limits(text);
    return list.is_array() ? value_text(list) : text;
  }
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (!value.is_array()) return std::nullopt;
  std::string list;
  for (const Json& part : value) {
    const auto text = part.is_array() ? std::nullopt : value_text(part);
    if (!text) return std::nullopt;
    list += (list.empty() ? "" : ",") + *text;
  }
  return list;
}

constexpr std::array<std::string_view, 4> kArguments{"place", "direction", "actions", "object"};

/// What a tool does, in a sentence for a model; by Tool.
constexpr std::array kPurposes{
    "Walk to one of the places that are listed now.",
    "Walk back to a place where you have been, along the ways that you know.",
    "Turn where you stand, and look in that direction.",
    "Do one to four actions, one after another.",
    "Say that you are at the end of the way there, and that the way back begins here.",
    "Say which of the listed objects is meant, and stop. Nothing can be done after it.",
    "Stop for good: you are where the instruction ends. Nothing can be done after it."};

/// The JSON Schema of a tool's arguments.
Json schema_of(const ToolUse& use) {
  Json schema{{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
  if (use.argument.empty()) return schema;
  const std::string argument(use.argument);
  Json value{{"type", "string"}, {"enum", use.allowed}};
  if (use.list) {
    value = {{"type", "array"}, {"items", value}, {"minItems", 1}, {"maxItems", kMostMoves}};
  }
  schema["properties"][argument] = std::move(value);
  schema["required"] = Json::array({argument});
  return schema;
}

/// What the value of an argument is, for a caller that gets no enumeration.
std::string argument_text(const ToolUse& use) {
  if (use.allowed.empty()) {
    return fmt::format("One of the values that the last result lists for {}.", name_of(use.tool));
  }
  const std::string values = fmt::format("{}", fmt::join(use.allowed, ", "));
  if (!use.list) return fmt::format("One of {}.", values);
  return fmt::format("One to {} of {}, with commas between them.", kMostMoves, values);
}

Json plain_schema_of(const ToolUse& use) {
  Json schema{{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
  if (use.argument.empty()) return schema;
  const std::string argument(use.argument);
  schema["properties"][argument] = {{"type", "string"}, {"description", argument_text(use)}};
  schema["required"] = Json::array({argument});
  return schema;
}

Json function_of(const ToolUse& use, Json parameters) {
  return {{"name", name_of(use.tool)},
          {"description", kPurposes[static_cast<std::size_t>(use.tool)]},
          {"parameters", std::move(parameters)}};
}

Reading read_arguments(std::string_view name, const Json& arguments) {
  if (name.empty()) return fault("no tool is named");
  if (!arguments.is_object()) {
    return fault(fmt::format("the arguments of {} are no JSON object", quote(name)));
  }
  Call call{std::string(name), {}};
  for (const std::string_view argument : kArguments) {
    const auto found = arguments.find(argument);
    if (found == arguments.end()) continue;
    const auto text = value_text(*found);
    if (!text) {
      return fault(
          fmt::format("{} of {} is neither a text nor a list of them", argument, quote(name)));
    }
    call.argument = *text;
  }
  return {std::move(call), {}, {}};
}

/// What stands after "Action:" in a line, without the marks of Markdown; none in other lines.
std::optional<std::string> action_in(std::string_view line) {
  constexpr std::string_view kMark = "action:";
  line.remove_prefix(std::min(line.find_first_not_of("*# \t"), line.size()));
  if (!detail::is_same(line.substr(0, kMark.size()), kMark)) return std::nullopt;
  std::string said(line.substr(kMark.size()));
  std::ranges::replace_if(
      said, [](char c) { return c == '*' || c == '`' || c == '.' || c == '"'; }, ' ');
  return std::string(trimmed(said));
}

/// "go_to B", also "go_to(B)" and "go_to: B".
Reading read_action(std::string_view said) {
  if (said.empty()) return fault("nothing stands after \"Action:\"");
  const std::size_t end = std::min(said.find_first_of(" (:"), said.size());
  std::string_view argument = trimmed(said.substr(std::min(end + 1, said.size())));
  while (argument.ends_with(')') || argument.ends_with(' ')) argument.remove_suffix(1);
  return {Call{std::string(said.substr(0, end)), std::string(argument)}, {}, {}};
}

/// The reasoning before an answer, without its tags.
std::string reasoning_in(std::string_view text) {
  std::string_view before = text.substr(0, text.size() - after_reasoning(text).size());
  for (const std::string_view tag : {"</think>", "</thinking>", "[/THINK]"}) {
    if (before.ends_with(tag)) before.remove_suffix(tag.size());
  }
  before = trimmed(before);
  for (const std::string_view tag : {"<think>", "<thinking>", "[THINK]"}) {
    if (before.starts_with(tag)) before.remove_prefix(tag.size());
  }
  return std::string(trimmed(before));
}

}  // namespace

std::string to_json(const SessionObservation& seen) {
  Json out{{"instruction", seen.instruction},
           {"step", seen.step},
           {"heading", degrees_of(seen.heading)},
           {"elevation", degrees_of(seen.elevation)}};
  if (!seen.what.empty()) out["what"] = seen.what;
  if (!seen.here.empty()) {
    out["here"] = seen.here;
    Json& places = out["places"] = Json::array();
    for (const Neighbour& one : seen.places) {
      places.push_back({{"name", one.name},
                        {"turn", degrees_of(one.turn)},
                        {"elevation", degrees_of(one.elevation)},
                        {"distance", metres_of(one.distance)},
                        {"visited", one.visited},
                        {"seen_before", one.seen_before}});
      if (!one.what.empty()) places.back()["what"] = one.what;
    }
    Json& map = out["map"] = Json::array();
    for (const MappedPlace& one : seen.map) {
      map.push_back({{"name", one.name}, {"leads_to", one.leads_to}});
    }
  }
  if (!seen.things.empty()) {
    Json& things = out["things"] = Json::array();
    for (const VisibleObject& one : seen.things) {
      things.push_back({{"name", one.name},
                        {"category", one.category},
                        {"turn", degrees_of(one.turn)},
                        {"elevation", degrees_of(one.elevation)}});
    }
  }
  out["told"] = seen.told;
  Json& tools = out["tools"] = Json::array();
  for (const ToolUse& use : seen.tools) {
    Json& one = tools.emplace_back(Json{{"tool", name_of(use.tool)}});
    if (use.argument.empty()) continue;
    one["argument"] = use.argument;
    one["allowed"] = use.allowed;
    if (use.list) one["list"] = true;
  }
  return out.dump();
}

std::string functions_json(const SessionObservation& seen) {
  Json functions = Json::array();
  for (const ToolUse& use : seen.tools) functions.push_back(function_of(use, schema_of(use)));
  return functions.dump();
}

std::string plain_functions_json(std::span<const ToolUse> tools) {
  Json functions = Json::array();
  for (const ToolUse& use : tools) functions.push_back(function_of(use, plain_schema_of(use)));
  return functions.dump();
}

std::string answer_schema(const SessionObservation& seen) {
  Json tools = Json::array(), values = Json::array(), choices = Json::array();
  for (const ToolUse& use : seen.tools) {
    tools.push_back(name_of(use.tool));
    if (use.list) {
      choices.push_back(schema_of(use)["properties"][std::string(use.argument)]);
      continue;
    }
    for (const std::string& value : use.allowed) {
      if (std::ranges::find(values, Json(value)) == values.end()) values.push_back(value);
    }
  }
  if (!values.empty()) choices.push_back({{"type", "string"}, {"enum", std::move(values)}});
  choices.push_back({{"type", "null"}});
  return Json{{"type", "object"},
              {"properties",
               {{"thought", {{"type", "string"}}},
                {"tool", {{"type", "string"}, {"enum", std::move(tools)}}},
                {"argument", {{"anyOf", std::move(choices)}}}}},
              {"required", Json::array({"thought", "tool", "argument"})},
              {"additionalProperties", false}}
      .dump();
}

Reading read_call(std::string_view tool, std::string_view arguments) {
  const std::string_view text = trimmed(arguments);
  Json parsed = text.empty() ? Json::object() : parse_within_limits(text);
  if (parsed.is_string()) {  // JSON in a text of JSON
    Json inner = parse_within_limits(parsed.get<std::string>());
    if (inner.is_object()) parsed = std::move(inner);
  }
  if (parsed.is_null()) parsed = Json::object();
  if (parsed.is_discarded()) {
    return fault(fmt::format("the arguments of {} are no JSON", quote(trimmed(tool))));
  }
  return read_arguments(trimmed(tool), parsed);
}

std::string_view after_reasoning(std::string_view text) {
  constexpr std::array<std::string_view, 4> kEnds{"</think>", "</thinking>", "[/THINK]",
                                                  "<|channel|>final<|message|>"};
  constexpr std::array<std::string_view, 4> kBegins{"<think>", "<thinking>", "[THINK]",
                                                    "<|channel|>analysis"};
  std::size_t after = 0;
  for (const std::string_view end : kEnds) {
    const std::size_t at = text.rfind(end);
    if (at != std::string_view::npos) after = std::max(after, at + end.size());
  }
  const std::string_view rest = text.substr(after);
  const bool cut_off = std::ranges::any_of(
      kBegins, [rest](std::string_view begin) { return trimmed(rest).starts_with(begin); });
  return cut_off ? std::string_view() : rest;
}

Reading read_answer_json(std::string_view text) {
  const std::string_view said = after_reasoning(text);
  Json answer = parse_within_limits(object_in(said));
  if (!answer.is_object()) answer = last_object_in(said);
  if (!answer.is_object()) return fault("the answer is no JSON object");
  const auto tool = answer.find("tool"), argument = answer.find("argument"),
             thought = answer.find("thought");
  if (tool == answer.end() || !tool->is_string()) return fault("the answer has no text \"tool\"");
  const std::string name(trimmed(tool->get<std::string>()));
  Reading reading;
  if (argument != answer.end() && argument->is_object()) {  // {"place": "B"}
    reading = read_arguments(name, *argument);
    if (!reading.call) return reading;
  } else {
    const auto value =
        argument == answer.end() ? std::optional<std::string>("") : value_text(*argument);
    if (!value) return fault("\"argument\" is neither a text nor a list of them");
    reading.call = Call{name, *value};
  }
  if (thought != answer.end() && thought->is_string()) {
    reading.thought = thought->get<std::string>();
  }
  if (reading.thought.empty()) reading.thought = reasoning_in(text);
  return reading;
}

Reading read_answer_text(std::string_view whole) {
  const std::string_view text = after_reasoning(whole);
  for (std::size_t end = text.size(); end > 0;) {
    const std::size_t before = text.rfind('\n', end - 1);
    const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
    if (const auto said = action_in(text.substr(begin, end - begin))) {
      Reading reading = read_action(*said);
      if (reading.call) reading.thought = trimmed(text.substr(0, begin));
      if (reading.call && reading.thought.empty()) reading.thought = reasoning_in(whole);
      return reading;
    }
    end = begin == 0 ? 0 : begin - 1;
  }
  return fault("no line begins with \"Action:\"");
}

}  // namespace enfilade::arena
