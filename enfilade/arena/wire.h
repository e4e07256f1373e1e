/// \file  Observations, tools and calls in JSON: the one form that HTTP, MCP, Python, prompts and
/// transcripts have. Angles are degrees here, rounded to a hundredth; lengths metres, to a
/// millimetre.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "enfilade/arena/session.h"

namespace enfilade::arena {

/// The observation as JSON; lists that a task does not have are left out:
/// - "instruction", "step", "heading", "elevation", "what"?, "here"?, "told"
/// - "places": [{"name", "turn", "elevation", "distance", "visited", "seen_before", "what"?}]
/// - "things": [{"name", "category", "turn", "elevation"}]
/// - "map": [{"name", "leads_to"}]
/// - "tools": [{"tool", "argument"?, "allowed", "list"?}]
std::string to_json(const SessionObservation& seen);

/// The tools with their current values: [{"name", "description", "parameters"}]. The last is a JSON
/// Schema of an object with at most one property, whose values are enumerated.
std::string functions_json(const SessionObservation& seen);
/// The same without enumerations, for a caller that lists the tools before it knows any value. Each
/// argument is a string; a list has commas in it. \param tools as World::tools()
std::string plain_functions_json(std::span<const ToolUse> tools);
/// A JSON Schema for an answer without tools: an object of "thought", "tool" and "argument" (null
/// if the tool has none), of currently possible values. For servers that take `response_format`.
/// Some pairs of the last two are impossible: servers support no stricter schema.
std::string answer_schema(const SessionObservation& seen);

/// A call parsed from an answer, or the reason why there is none.
struct Reading {
  std::optional<Call> call;
  std::string thought;  ///< text beside the call
  std::string fault;    ///< a sentence without a full stop; empty if there is a call
};
/// \param arguments  JSON: an object with the tool's argument, {"place": "B"}, or a text with one;
/// other fields are ignored. Empty: none
Reading read_call(std::string_view tool, std::string_view arguments);
/// What stands after a model's reasoning: behind the last `</think>`, with or without its opening
/// tag, or the like of other models. Empty where the reasoning has no end.
std::string_view after_reasoning(std::string_view text);
/// An answer by answer_schema(), after the reasoning, also within ``` marks and among words. Among
/// several complete objects the last one with a "tool" counts. The thought is the object's, or the
/// reasoning.
Reading read_answer_json(std::string_view text);
/// An answer in plain text: the last line "Action: go_to B" counts, whatever stands before it. In
/// reasoning it does not count.
Reading read_answer_text(std::string_view text);

}  // namespace enfilade::arena
