#include "enfilade/arena/dialect.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/texts.h"
#include "enfilade/core/utf8.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kQuotedBytes = 300;    // bytes of a server's words in a message
constexpr std::size_t kRefusalBytes = 4096;  // bytes of a refusal in the cache
constexpr int kDeepest = 16;                 // levels of a refusal that are read
constexpr const char* kRefused = "refused";

/// Where a word or phrase stands by itself in a text of lower case; npos: nowhere.
std::size_t find_word(std::string_view text, std::string_view word) {
  const auto joins = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (std::size_t at = text.find(word); at != std::string_view::npos;
       at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !joins(text[at - 1])) && (end == text.size() || !joins(text[end]))) return at;
  }
  return std::string_view::npos;
}

bool has_any(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(
      words, [text](std::string_view one) { return text.find(one) != std::string_view::npos; });
}

/// What a refusal says.
struct Told {
  std::vector<std::string> fields;  // `param` and `loc`
  std::string text;                 // all its texts, in lower case
};

void collect(const Json& value, int depth, Told& told) {
  if (depth > kDeepest) return;
  if (value.is_string()) told.text += lower_case(value.get<std::string>()) + "\n";
  if (value.is_array()) {
    for (const Json& one : value) collect(one, depth + 1, told);
  }
  if (!value.is_object()) return;
  for (const auto& [name, one] : value.items()) {
    if (name == "input" || name == "body") continue;  // the request is repeated there
    if (name == "param" && one.is_string()) {
      const std::string field = lower_case(one.get<std::string>());
      if (!field.empty()) told.fields.push_back(field.substr(0, field.find_first_of(".[")));
    } else if (name == "loc" && one.is_array()) {
      for (const Json& part : one) {
        if (part.is_string()) told.fields.push_back(lower_case(part.get<std::string>()));
      }
    } else {
      collect(one, depth + 1, told);
    }
  }
}

Told read_refusal(std::string_view body) {
  Told told;
  const Json parsed = Json::parse(body, nullptr, false);
  if (parsed.is_structured()) {
    collect(parsed, 0, told);
  } else {
    told.text = lower_case(body);
  }
  return told;
}

/// Whether an error has no text, as a failed check of llama-cpp-python.
bool is_silent(std::string_view body) {
  const Json parsed = Json::parse(body, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("error")) return false;
  const Json& error = parsed["error"];
  return error.is_object() && error.contains("message") && error["message"].is_string() &&
         error["message"].get<std::string>().empty();
}

/// Where one of the words is told; 0 for a field by its name; npos: nowhere.
std::size_t place_of(const Told& told, const std::vector<std::string_view>& words) {
  std::size_t first = std::string_view::npos;
  for (const std::string_view word : words) {
    if (!told.fields.empty()) {
      if (std::ranges::find(told.fields, word) != told.fields.end()) return 0;
    } else {
      first = std::min(first, find_word(told.text, word));
    }
  }
  return first;
}

/// A field that may be refused, and what is done about it.
struct Remedy {
  std::vector<std::string_view> words;  // that name it
  bool (*is_sent)(const Json& request);
  bool (*apply)(Dialect& dialect, const SetByHand& by_hand);  // false: nothing is left to do
};

template <class Enum>
bool advance(Enum& value, Enum last) {
  if (value == last) return false;
  value = static_cast<Enum>(static_cast<int>(value) + 1);
  return true;
}

const std::vector<Remedy>& remedies() {
  static const std::vector<Remedy> kRemedies{
      {{"temperature"},
       [](const Json& request) { return request.contains("temperature"); },
       [](Dialect& dialect, const SetByHand&) {
         return std::exchange(dialect.temperature, false);
       }},
      {{"seed", "random_seed"},
       [](const Json& request) { return request.contains("seed"); },
       [](Dialect& dialect, const SetByHand&) { return std::exchange(dialect.seed, false); }},
      {{"max_tokens", "max_completion_tokens"},
       [](const Json& request) {
         return request.contains("max_tokens") || request.contains("max_completion_tokens");
       },
       [](Dialect& dialect, const SetByHand& by_hand) {
         return !by_hand.limit && advance(dialect.limit, LimitField::kNone);
       }},
      {{"tool_choice", "tool choice"},
       [](const Json& request) { return request.contains("tool_choice"); },
       [](Dialect& dialect, const SetByHand&) {
         return advance(dialect.tool_choice, ToolChoice::kNone);
       }},
      {{"tools", "tool use", "tool calls", "tool calling", "tool_calls", "function calling",
        "functions", "tool_choice", "tool choice", "tool-choice", "tool-call-parser"},
       [](const Json& request) { return request.contains("tools"); },
       [](Dialect& dialect, const SetByHand& by_hand) {
         if (by_hand.answers || dialect.answers != Answers::kTools) return false;
         dialect.answers = Answers::kJson;
         return true;
       }},
      {{"response_format", "json_schema", "json_object", "guided_json", "structured output",
        "structured outputs", "grammar", "schema"},
       [](const Json& request) { return request.contains("response_format"); },
       [](Dialect& dialect, const SetByHand& by_hand) {
         if (dialect.json == JsonForm::kObject && !by_hand.answers)
           dialect.answers = Answers::kText;
         return advance(dialect.json, JsonForm::kNone);
       }},
      {{"stream_options", "include_usage"},
       [](const Json& request) { return request.contains("stream_options"); },
       [](Dialect& dialect, const SetByHand&) {
         return std::exchange(dialect.stream_usage, false);
       }},
      {{"stream", "streaming"},
       [](const Json& request) { return !request.contains("stream"); },
       [](Dialect& dialect, const SetByHand&) { return !std::exchange(dialect.stream, true); }},
      {{"system role", "system message", "system messages", "roles must alternate",
        "only user and assistant roles"},
       [](const Json& request) {
         return request.contains("messages") && request["messages"].is_array() &&
                !request["messages"].empty() && request["messages"][0].is_object() &&
                request["messages"][0].value("role", "") == "system";
       },
       [](Dialect& dialect, const SetByHand&) { return std::exchange(dialect.system, false); }},
  };
  return kRemedies;
}

/// The first text under one of these names, however deep; empty: none.
std::string text_under(const Json& value, std::initializer_list<const char*> names, int depth) {
  if (depth > kDeepest || !value.is_structured()) return {};
  if (value.is_object()) {
    for (const char* name : names) {
      const auto found = value.find(name);
      if (found != value.end() && found->is_string() && !found->get<std::string>().empty()) {
        return found->get<std::string>();
      }
    }
  }
  for (const auto& [name, one] : value.items()) {
    if (std::string text = text_under(one, names, depth + 1); !text.empty()) return text;
  }
  return {};
}

}  // namespace

RefusalKind kind_of(const Refusal& refusal) {
  // Of the key, the account or the address, whatever the words.
  if (refusal.status == 401 || refusal.status == 402 || refusal.status == 404) {
    return RefusalKind::kOther;
  }
  const std::string text = lower_case(refusal.body);
  if (refusal.status == 413 ||
      has_any(text,
              {"context_length", "context length", "context size", "context_size", "context window",
               "context_window", "maximum context", "max_model_len", "maximum model length",
               "prompt is too long", "prompt too long", "input is too long", "input length",
               "too many tokens", "model token limit", "context limit", "reduce the length",
               "string_above_max_length", "input token count", "input token length",
               "maximum prompt length", "`inputs` tokens",
               // llama-cpp-python, where the beginning of a conversation is in its cache
               "could not broadcast input array from shape"})) {
    return RefusalKind::kTooLong;
  }
  if (has_any(text,
              {"content_filter", "content filter", "content_policy", "content policy",
               "content management policy", "responsibleaipolicy", "data_inspection",
               "inappropriate content", "moderation", "input was flagged", "prompt was flagged",
               "content was flagged", "safety system", "prohibited_content"})) {
    return RefusalKind::kFilter;
  }
  return RefusalKind::kOther;
}

std::string words_in(std::string_view body) {
  const Json parsed = Json::parse(body, nullptr, false);
  // OpenRouter: the provider's own refusal, often JSON too.
  const std::string raw = text_under(parsed, {"raw"}, 0);
  if (!raw.empty()) return words_in(raw);
  std::string text = text_under(parsed, {"message", "msg", "detail", "error"}, 0);
  if (text.empty()) text = body;
  // Of FastAPI's list, the message alone does not say which field is meant.
  const Told told = read_refusal(body);
  if (!told.fields.empty() &&
      find_word(lower_case(text), told.fields.back()) == std::string::npos) {
    text += " (" + told.fields.back() + ")";
  }
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' ' || c == 127; }, ' ');  // it goes to terminals
  return std::string(utf8_prefix(text, kQuotedBytes));
}

bool says_invalid(std::string_view body) {
  return is_silent(body) ||
         has_any(lower_case(body),
                 {"invalid_request", "invalid request", "validation error", "badrequest",
                  "bad request", "_error', 'loc'", "literal_error", "extra_forbidden",
                  "'loc':", "\"loc\":", "not supported", "unsupported", "not permitted",
                  "not allowed", "must alternate"});
}

bool refusal_names(const Refusal& refusal, std::string_view field) {
  const Told told = read_refusal(refusal.body);
  return std::ranges::find(told.fields, field) != told.fields.end() ||
         find_word(told.text, field) != std::string::npos;
}

std::optional<Dialect> remedy_for(const Refusal& refusal, std::string_view request,
                                  const Dialect& dialect, const SetByHand& by_hand) {
  const Json sent = Json::parse(request, nullptr, false);
  if (!sent.is_object()) return std::nullopt;
  const Told told = read_refusal(refusal.body);
  std::optional<Dialect> best;
  std::size_t first = std::string_view::npos;
  for (const Remedy& one : remedies()) {
    if (!one.is_sent(sent)) continue;
    const std::size_t place = place_of(told, one.words);
    if (place >= first) continue;  // nowhere, or after another
    Dialect changed = dialect;
    if (!one.apply(changed, by_hand)) continue;
    best = changed;
    first = place;
  }
  const auto choice = sent.find("tool_choice");
  if (!best && is_silent(refusal.body) && choice != sent.end() &&
      *choice == Json(enum_name(ToolChoice::kRequired))) {
    best = dialect;
    best->tool_choice = ToolChoice::kAuto;
  }
  return best;
}

std::vector<std::string> differences(const Dialect& dialect) {
  std::vector<std::string> list;
  const auto add = [&list](bool differs, std::string text) {
    if (differs) list.push_back(std::move(text));
  };
  add(!dialect.temperature, "temperature is left out");
  add(!dialect.seed, "seed is left out");
  add(dialect.limit == LimitField::kMaxCompletionTokens,
      "max_completion_tokens takes the place of max_tokens");
  add(dialect.limit == LimitField::kNone, "max_tokens is left out");
  if (dialect.answers == Answers::kTools) {
    add(dialect.tool_choice == ToolChoice::kAuto, "tool_choice is auto");
    add(dialect.tool_choice == ToolChoice::kNone, "tool_choice is left out");
  }
  if (dialect.answers == Answers::kJson) {
    add(dialect.json == JsonForm::kObjectOfSchema, "response_format is json_object with schema");
    add(dialect.json == JsonForm::kObject, "response_format is json_object");
    add(dialect.json == JsonForm::kNone, "response_format is left out");
  }
  add(!dialect.system, "the system's text is in the user's first message");
  add(dialect.stream, "responses are streamed");
  return list;
}

std::string kept_refusal(const Refusal& refusal) {
  return Json{
      {kRefused, {{"status", refusal.status}, {"body", refusal.body.substr(0, kRefusalBytes)}}}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<Refusal> find_refusal(std::string_view answer) {
  if (!answer.starts_with("{\"refused\"")) return std::nullopt;
  const Json parsed = Json::parse(answer, nullptr, false);
  if (!parsed.is_object() || !parsed.contains(kRefused) || !parsed[kRefused].is_object()) {
    return std::nullopt;
  }
  const Json& kept = parsed[kRefused];
  if (!kept.contains("status") || !kept["status"].is_number_integer() || !kept.contains("body") ||
      !kept["body"].is_string()) {
    return std::nullopt;
  }
  return Refusal{kept["status"].get<int>(), kept["body"].get<std::string>()};
}

}  // namespace enfilade::arena
