/// \file  Observations, tools and calls in JSON: the one form that HTTP, MCP, Python, prompts and
/// transcripts have. Angles are degrees here, rounded to a hundredth; lengths metres, to a
/// millimetre.
#pragma once
#include <optional>
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
std::string to_json(const Observation& seen);

/// A tool's effect, in a sentence for a model.
std::string_view purpose_of(Tool tool) noexcept;
/// The tools with their current values: [{"name", "description", "parameters"}]. The last is a JSON
/// Schema of an object with at most one property, whose values are enumerated.
std::string functions_json(const Observation& seen);
/// A JSON Schema for an answer without tools: an object of "thought", "tool" and "argument" (null
/// if the tool has none), of currently possible values. For servers that take `response_format`.
/// Some pairs of the last two are impossible: servers support no stricter schema.
std::string answer_schema(const Observation& seen);

/// A call parsed from an answer, or the reason why there is none.
struct Reading {
  std::optional<Call> call;
  std::string thought;  ///< text beside the call
  std::string fault;    ///< a sentence without a full stop; empty if there is a call
};
/// \param arguments  JSON: an object with the tool's argument, {"place": "B"}; other fields
/// are ignored. Empty: none
Reading read_call(std::string_view tool, std::string_view arguments);
/// An answer by answer_schema(), also within ``` marks.
Reading read_answer_json(std::string_view text);
/// An answer in plain text: the last line "Action: go_to B" counts, whatever stands before it.
Reading read_answer_text(std::string_view text);

}  // namespace enfilade::arena
