/// \file  Observations, tools and calls in JSON: the one form that HTTP, MCP, Python, prompts and
/// transcripts have. Angles are degrees here, rounded to a hundredth; lengths metres, to a
/// millimetre.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/arena/session.h"

namespace enfilade::arena {

/// {"instruction", "step", "heading", "elevation", "what"?, "here"?, "places": [{"name", "turn",
/// "elevation", "distance", "visited", "seen_before", "what"?}], "things": [{"name", "category",
/// "turn", "elevation"}], "map": [{"name", "leads_to"}], "told", "tools": [{"tool", "argument"?,
/// "allowed", "list"?}]}. Lists that a task does not have are left out.
std::string to_json(const Observation& seen);

/// What a tool does, in a sentence for a model.
std::string_view purpose_of(Tool tool) noexcept;
/// The tools as they can be used now: [{"name", "description", "parameters"}], the last a JSON
/// Schema of an object with at most one property, whose values are enumerated.
std::string functions_json(const Observation& seen);
/// A JSON Schema for an answer without tools: an object of "thought", "tool" and "argument" (null
/// where the tool has none), of values that are possible now. For servers that take
/// `response_format`. Not each pair of the last two is possible: servers support no more.
std::string answer_schema(const Observation& seen);

/// A call that was read from what somebody wrote, or why none was.
struct Reading {
  std::optional<Call> call;
  std::string thought;  ///< what was written beside it
  std::string fault;    ///< a sentence without a full stop; empty if there is a call
};
/// \param arguments  JSON: an object with the tool's argument, {"place": "B"}; what it holds beside
/// it is ignored. Empty: none
Reading read_call(std::string_view tool, std::string_view arguments);
/// An answer by answer_schema(), also within ``` marks.
Reading read_answer_json(std::string_view text);
/// An answer in plain text: the last line "Action: go_to B" counts, whatever stands before it.
Reading read_answer_text(std::string_view text);

}  // namespace enfilade::arena
