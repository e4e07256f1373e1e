/// \file  The form of requests that a server accepts, found from what it refuses.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/prompt.h"

namespace enfilade::arena {

/// The field that limits the tokens of a response.
enum class LimitField : std::uint8_t { kMaxTokens, kMaxCompletionTokens, kNone };
constexpr std::array<std::string_view, 3> names_of(LimitField /*enum*/) {
  return {"max_tokens", "max_completion_tokens", "none"};
}
/// The value of `tool_choice`.
enum class ToolChoice : std::uint8_t { kRequired, kAuto, kNone };
constexpr std::array<std::string_view, 3> names_of(ToolChoice /*enum*/) {
  return {"required", "auto", "none"};
}
/// The type of `response_format`; llama-cpp-python takes a schema beside the second.
enum class JsonForm : std::uint8_t { kSchema, kObjectOfSchema, kObject, kNone };
constexpr std::array<std::string_view, 4> names_of(JsonForm /*enum*/) {
  return {"json_schema", "json_object with schema", "json_object", "none"};
}

/// What is sent, and how. `kNone` and false: the field is left out.
struct Dialect {
  Answers answers = Answers::kTools;
  bool temperature = true;
  bool seed = true;
  LimitField limit = LimitField::kMaxTokens;
  ToolChoice tool_choice = ToolChoice::kRequired;
  JsonForm json = JsonForm::kSchema;
  bool system = true;        ///< false: the first message of the user has the start's text
  bool stream = false;       ///< responses in parts
  bool stream_usage = true;  ///< with them, `stream_options` asks for the count of tokens
  friend bool operator==(const Dialect&, const Dialect&) = default;
};

/// What the user has set, so that no remedy changes it.
struct SetByHand {
  bool answers = false;
  bool limit = false;
};

/// What a refusal is about.
enum class RefusalKind : std::uint8_t {
  kTooLong,  ///< the conversation does not fit into the model's context
  kFilter,   ///< a content filter
  kOther,    ///< a parameter, or anything else
};
constexpr std::array<std::string_view, 3> names_of(RefusalKind /*enum*/) {
  return {"context-too-long", "filter", "other"};
}
RefusalKind kind_of(const Refusal& refusal);

/// The server's own words in the body of a refusal, at most 300 bytes, without control characters.
std::string words_in(std::string_view body);

/// Whether the body of an answer of status 500 says that the request was invalid, or has an error
/// without a text. What kind_of() tells apart is no part of it.
bool says_invalid(std::string_view body);

/// Whether a refusal names a field: in `error.param`, in `detail[].loc`, or as a word of its text.
bool refusal_names(const Refusal& refusal, std::string_view field);

/// The dialect without what a refusal names, one step on: `temperature` and `seed` are left out,
/// `max_tokens` becomes `max_completion_tokens`, then nothing, and so on (docs/arena.md). An error
/// without a text is taken for one of `tool_choice: required`.
/// \param request  that was refused, JSON; what it does not have is not changed
/// \returns no value if the refusal names nothing that can be changed
std::optional<Dialect> remedy_for(const Refusal& refusal, std::string_view request,
                                  const Dialect& dialect, const SetByHand& by_hand);

/// The differences to requests as they are usually sent, a phrase each: "temperature is left out".
std::vector<std::string> differences(const Dialect& dialect);

/// A refusal as the cache keeps it, in place of a response.
std::string kept_refusal(const Refusal& refusal);
/// Its inverse; no value for a response.
std::optional<Refusal> find_refusal(std::string_view answer);

}  // namespace enfilade::arena
