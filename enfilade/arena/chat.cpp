#include "enfilade/arena/chat.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/arena/detail/limits.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/arena/detail/tokens.h"
#include "enfilade/core/base64.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kScheme = "enfilade-picture:";
constexpr std::string_view kNoAnswer = "(no answer)";  // strict servers refuse an empty message
constexpr std::string_view kOneCall = "Nothing was done: one call at a time.";

Json text_part(std::string text) { return {{"type", "text"}, {"text", std::move(text)}}; }

Json image_part(std::string_view key) {
  return {{"type", "image_url"}, {"image_url", {{"url", std::string(kScheme).append(key)}}}};
}

/// The request's fields that any question has, but for those of the answer's form.
Json request_of(const ChatConfig& config, const Dialect& dialect, Json messages) {
  Json request{{"model", config.model}, {"messages", std::move(messages)}};
  if (config.temperature && dialect.temperature) request["temperature"] = *config.temperature;
  if (config.seed && dialect.seed) request["seed"] = *config.seed;
  if (config.most_tokens && dialect.limit != LimitField::kNone) {
    request[std::string(enum_name(dialect.limit))] = *config.most_tokens;
  }
  return request;
}

/// The text of a request: with the fields that come last.
std::string finished(Json request, const ChatConfig& config, const Dialect& dialect) {
  if (dialect.stream) {
    request["stream"] = true;
    if (dialect.stream_usage) request["stream_options"] = {{"include_usage", true}};
  }
  if (config.extra.empty()) return request.dump();
  const Json extra = Json::parse(config.extra);
  for (const auto& [name, value] : extra.items()) {
    if (value.is_null()) {
      request.erase(name);
    } else {
      request[name] = value;
    }
  }
  return request.dump();
}

/// The message without its pictures.
Json without_pictures(const Json& message) {
  if (!message["content"].is_array()) return message;
  Json plain = message;
  plain["content"] = message["content"][0]["text"];
  return plain;
}

[[noreturn]] void refuse(const char* where, std::string text) {
  throw InvalidInput(
      {{Severity::kError, "the model's answer", where, "no-chat-completion", std::move(text)}});
}

std::int64_t count_in(const Json& body, const char* name) {
  const auto usage = body.find("usage");
  if (usage == body.end() || !usage->is_object()) return 0;
  return detail::tokens_in(*usage, name);
}

std::string text_in(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The texts of a message's content: a text, or a list of parts with "text".
std::string content_text(const Json& message) {
  const auto content = message.find("content");
  if (content == message.end() || !content->is_array()) return text_in(message, "content");
  std::string text;
  for (const Json& part : *content) {
    if (part.is_string()) text += part.get<std::string>();
    if (part.is_object()) text += text_in(part, "text");
  }
  return text;
}

/// Whether a field of an assistant's message is the model's reasoning, or a signature of it, which
/// servers expect to be sent back.
bool is_reasoning(std::string_view name) {
  constexpr std::array<std::string_view, 6> kParts{
      "reasoning", "thinking", "thought", "signature", "extra_content", "provider_specific_fields"};
  return std::ranges::any_of(
      kParts, [name](std::string_view part) { return name.find(part) != std::string_view::npos; });
}

/// Why a message without a call has none. \param choice of the completion
AnswerFlaw flaw_of(const Json& choice, const Json& message, std::string_view answer) {
  struct Reason {
    std::string_view name;
    AnswerFlaw flaw;
  };
  constexpr std::array<Reason, 9> kReasons{{{"length", AnswerFlaw::kLength},
                                            {"max_tokens", AnswerFlaw::kLength},
                                            {"content_filter", AnswerFlaw::kFilter},
                                            {"safety", AnswerFlaw::kFilter},
                                            {"recitation", AnswerFlaw::kFilter},
                                            {"prohibited_content", AnswerFlaw::kFilter},
                                            {"blocklist", AnswerFlaw::kFilter},
                                            {"sensitive", AnswerFlaw::kFilter},
                                            {"refusal", AnswerFlaw::kRefusal}}};
  const std::string reason = text_in(choice, "finish_reason");
  const auto known = std::ranges::find_if(
      kReasons, [&reason](const Reason& one) { return detail::is_same(one.name, reason); });
  if (known != kReasons.end()) return known->flaw;
  if (!text_in(message, "refusal").empty()) return AnswerFlaw::kRefusal;
  return trimmed(answer).empty() ? AnswerFlaw::kEmpty : AnswerFlaw::kNone;
}

/// Bytes of all texts and names within a value.
// NOLINTNEXTLINE(misc-no-recursion): the levels have a limit
std::size_t text_bytes(const Json& value) {
  if (value.is_string()) return value.get_ref<const std::string&>().size();
  std::size_t bytes = 0;
  if (!value.is_structured()) return bytes;
  for (const auto& [name, one] : value.items()) {
    bytes += (value.is_object() ? name.size() : 0) + text_bytes(one);
  }
  return bytes;
}

/// \throws InvalidInput for a body over the limits
Json parse_completion(std::string_view body) {
  std::string found = json::excess(body, detail::kAnswerLimits);
  if (body.size() > detail::kMostAnswer) {
    found = fmt::format("more than {} MiB", detail::kMostAnswer >> 20U);
  }
  if (!found.empty()) refuse("$", "an answer of " + found);
  return Json::parse(body, nullptr, false);
}

void check_limits(const Json& choices) {
  const Json& message = choices[0]["message"];
  const auto calls = message.find("tool_calls");
  if (choices.size() > detail::kMostChoices) {
    refuse("$.choices", fmt::format("more than {} of them", detail::kMostChoices));
  }
  if (calls != message.end() && calls->is_array() && calls->size() > detail::kMostCalls) {
    refuse("$.choices[0].message.tool_calls",
           fmt::format("more than {} of them", detail::kMostCalls));
  }
  if (text_bytes(message) > detail::kMostText) {
    refuse("$.choices[0].message",
           fmt::format("texts of more than {} MiB", detail::kMostText >> 20U));
  }
}

/// The message of a chat completion.
Json message_of(const Json& completion) {
  if (!completion.is_object()) refuse("$", "no JSON object");
  const auto choices = completion.find("choices");
  if (choices == completion.end() || !choices->is_array() || choices->empty()) {
    const auto error = completion.find("error");  // some servers say so with status 200
    if (error != completion.end() && !error->is_null())
      refuse("$.error", words_in(completion.dump()));
    refuse("$.choices", "no list with an answer in it");
  }
  const Json& first = choices->front();
  if (!first.is_object() || !first.contains("message") || !first["message"].is_object()) {
    refuse("$.choices[0].message", "no object");
  }
  check_limits(*choices);
  return first["message"];
}

/// Those that the message calls, as far as they have a name.
Json calls_of(const Json& message) {
  Json calls = Json::array();
  const auto found = message.find("tool_calls");
  if (found == message.end() || !found->is_array()) return calls;
  for (const Json& one : *found) {
    if (one.is_object() && one.contains("function") && one["function"].is_object()) {
      calls.push_back(one);
    }
  }
  return calls;
}

Reading read_tools(const Json& message) {
  const Json calls = calls_of(message);
  if (calls.empty()) return {std::nullopt, {}, "no tool was called"};
  const Json& function = calls[0]["function"];
  const auto arguments = function.find("arguments");
  const std::string text = arguments == function.end() ? ""
                           : arguments->is_string()    ? arguments->get<std::string>()
                                                       : arguments->dump();
  return read_call(text_in(function, "name"), text);
}

}  // namespace

struct Chat::Impl {
  const Prompt& prompt;
  ChatConfig config;
  Dialect dialect;
  SessionLimits limits;
  std::string start = {};       // the system's text
  std::vector<Json> past = {};  // messages, a list per step
  std::size_t first = 0;        // of past: what is before is left out
  bool with_reasoning = true;   // of past
  std::vector<PastStep> steps = {};
  SessionObservation present = {};
  bool told_by_tool = false;
  std::vector<PictureOrder> pictures = {};
  std::vector<std::string> keys = {};
  std::vector<std::pair<std::string, PictureOrder>> seen = {};  // all so far that may be sent again

  Json user_message() const {
    SessionObservation shown = present;
    if (told_by_tool && first < past.size()) shown.told.clear();
    std::string text = prompt.step(shown, dialect.answers, limits, steps);
    Json message{{"role", "user"}};
    if (pictures.empty()) {
      message["content"] = std::move(text);
      return message;
    }
    Json& content = message["content"] = Json::array({text_part(std::move(text))});
    for (std::size_t k = 0; k < pictures.size(); ++k) {
      if (!pictures[k].caption.empty()) {
        content.push_back(text_part(fmt::format("Picture {}:", pictures[k].caption)));
      }
      content.push_back(image_part(keys[k]));
    }
    return message;
  }

  /// An assistant's message without the reasoning, if the server refuses that.
  Json sent_back(const Json& message) const {
    if (with_reasoning || message["role"] != "assistant") return message;
    Json plain = Json::object();
    for (const auto& [name, value] : message.items()) {
      if (!is_reasoning(name)) plain[name] = value;
    }
    return plain;
  }

  Json messages() const {
    Json all = Json::array();
    if (dialect.system) all.push_back({{"role", "system"}, {"content", start}});
    std::size_t observations = past.size() - first;
    for (std::size_t k = first; k < past.size(); ++k, --observations) {
      for (const Json& one : past[k]) {
        const bool kept = one["role"] != "user" || observations <= prompt.kept_pictures();
        all.push_back(kept ? sent_back(one) : without_pictures(one));
      }
    }
    all.push_back(user_message());
    if (dialect.system) return all;
    Json& content = all[0]["content"];
    Json& text = content.is_array() ? content[0]["text"] : content;
    text = start + "\n\n" + text.get<std::string>();
    return all;
  }

  Json request() const {
    Json made = request_of(config, dialect, messages());
    if (dialect.answers == Answers::kTools) {
      Json& tools = made["tools"] = Json::array();
      for (const Json& one : Json::parse(functions_json(present))) {
        tools.push_back({{"type", "function"}, {"function", one}});
      }
      if (dialect.tool_choice != ToolChoice::kNone) {
        made["tool_choice"] = enum_name(dialect.tool_choice);
      }
    } else if (dialect.answers == Answers::kJson && dialect.json != JsonForm::kNone) {
      made["response_format"] = response_format();
    }
    return made;
  }

  Json response_format() const {
    if (dialect.json == JsonForm::kObject) return {{"type", "json_object"}};
    Json schema = Json::parse(answer_schema(present));
    if (dialect.json == JsonForm::kObjectOfSchema) {
      return {{"type", "json_object"}, {"schema", std::move(schema)}};
    }
    return {{"type", "json_schema"},
            {"json_schema", {{"name", "action"}, {"strict", true}, {"schema", std::move(schema)}}}};
  }
};

void validate(const ChatConfig& config) {
  if (config.model.empty()) throw ArgumentError("model: empty; the server's name for one");
  if (config.temperature && !(*config.temperature >= 0 && *config.temperature <= 2)) {
    throw ArgumentError(fmt::format("temperature: {}, 0 to 2", *config.temperature));
  }
  if (config.extra.empty()) return;
  const Json extra = Json::parse(config.extra, nullptr, false);
  if (!extra.is_object()) {
    throw ArgumentError(R"(extra: no JSON object like {"reasoning_effort": "low"})");
  }
  for (const char* name : {"model", "messages"}) {
    if (extra.contains(name)) throw ArgumentError(fmt::format("extra: {} is not for it", name));
  }
}

Chat::Chat(const Prompt& prompt, ChatConfig config, const Dialect& dialect, SessionLimits limits)
    : impl_(new Impl{prompt, std::move(config), dialect, limits}) {
  validate(impl_->config);
}
Chat::~Chat() = default;

std::string Chat::ask(const SessionObservation& seen, const std::vector<PictureOrder>& pictures,
                      const std::vector<std::string>& keys) {
  Impl& chat = *impl_;
  chat.pictures = pictures;
  chat.keys = keys;
  for (std::size_t k = 0; k < keys.size(); ++k) chat.seen.emplace_back(keys[k], pictures[k]);
  if (chat.steps.empty()) chat.start = chat.prompt.start(seen, chat.dialect.answers, chat.limits);
  chat.present = seen;
  return request();
}

std::string Chat::request() const {
  return finished(impl_->request(), impl_->config, impl_->dialect);
}

bool Chat::shorten() {
  Impl& chat = *impl_;
  const std::size_t kept = chat.past.size() - chat.first;
  chat.first += (kept + 1) / 2;
  return kept > 0;
}

bool Chat::leave_out_reasoning(const Refusal& refusal) {
  Impl& chat = *impl_;
  if (!chat.with_reasoning) return false;
  for (std::size_t k = chat.first; k < chat.past.size(); ++k) {
    for (const Json& message : chat.past[k]) {
      if (message["role"] != "assistant") continue;
      for (const auto& [name, value] : message.items()) {
        if (!is_reasoning(name) || !refusal_names(refusal, name)) continue;
        chat.with_reasoning = false;
        return true;
      }
    }
  }
  return false;
}

std::size_t Chat::left_out() const { return impl_->first; }

ChatAnswer read_completion(std::string_view body) {
  const Json completion = parse_completion(body);
  ChatAnswer answer;
  answer.text = content_text(message_of(completion));
  answer.prompt_tokens = count_in(completion, "prompt_tokens");
  answer.answer_tokens = count_in(completion, "completion_tokens");
  return answer;
}

ChatAnswer Chat::read(std::string_view body) const {
  ChatAnswer answer = read_completion(body);
  const Json completion = parse_completion(body);
  const Json message = message_of(completion);
  switch (impl_->dialect.answers) {
    case Answers::kTools:
      answer.reading = read_tools(message);
      answer.reading.thought = answer.text;
      break;
    case Answers::kJson:
      answer.reading = read_answer_json(answer.text);
      break;
    case Answers::kText:
      answer.reading = read_answer_text(answer.text);
      break;
  }
  if (answer.reading.call) return answer;
  answer.flaw = flaw_of(completion["choices"][0], message, after_reasoning(answer.text));
  if (answer.flaw == AnswerFlaw::kEmpty && !calls_of(message).empty()) {
    answer.flaw = AnswerFlaw::kNone;  // a call that cannot be read is a mistake
  }
  return answer;
}

void Chat::close(std::string_view body, const ChatAnswer& answer, const SessionObservation& after) {
  Impl& chat = *impl_;
  Json step = Json::array({chat.user_message()});
  chat.steps.push_back(past_step(answer.reading, after.told));
  const Json message = message_of(parse_completion(body));
  const Json calls =
      chat.dialect.answers == Answers::kTools ? calls_of(message) : Json(Json::array());
  chat.told_by_tool = !calls.empty() && chat.prompt.memory() == PromptMemory::kAll;
  if (chat.prompt.memory() == PromptMemory::kLast) return;
  const bool silent = calls.empty() && trimmed(answer.text).empty();
  Json said{{"role", "assistant"}, {"content", silent ? kNoAnswer : answer.text}};
  if (message.contains("content") && message["content"].is_array() && !message["content"].empty()) {
    said["content"] = message["content"];  // parts of thinking have signatures
  }
  if (!calls.empty()) said["tool_calls"] = calls;
  for (const auto& [name, value] : message.items()) {
    if (is_reasoning(name) && !value.is_null()) said[name] = value;
  }
  step.push_back(std::move(said));
  for (std::size_t k = 0; k < calls.size(); ++k) {
    step.push_back({{"role", "tool"},
                    {"tool_call_id", text_in(calls[k], "id")},
                    {"content", k == 0 ? after.told : std::string(kOneCall)}});
  }
  chat.past.push_back(std::move(step));
  if (chat.config.window && chat.past.size() > *chat.config.window) {
    chat.first = std::max(chat.first, chat.past.size() - *chat.config.window);
  }
}

const PictureOrder* Chat::find_picture(std::string_view key) const {
  const auto found = std::ranges::find(impl_->seen, key,
                                       [](const auto& one) { return std::string_view(one.first); });
  return found == impl_->seen.end() ? nullptr : &found->second;
}

std::string picture_request(const ChatConfig& config, const Dialect& dialect, std::string question,
                            std::string_view key) {
  Json content = Json::array({text_part(std::move(question)), image_part(key)});
  Json user{{"role", "user"}, {"content", std::move(content)}};
  return finished(request_of(config, dialect, Json::array({std::move(user)})), config, dialect);
}

std::string with_pictures(std::string_view request,
                          const std::function<std::string(std::string_view key)>& picture) {
  Json filled = Json::parse(request);
  for (Json& message : filled["messages"]) {
    if (message["role"] != "user" || !message["content"].is_array()) continue;
    for (Json& part : message["content"]) {
      if (part["type"] != "image_url") continue;
      const auto url = part["image_url"]["url"].get<std::string>();
      if (!url.starts_with(kScheme)) continue;
      const std::string jpeg = picture(std::string_view(url).substr(kScheme.size()));
      std::string data = "data:image/jpeg;base64,";
      append_base64(std::as_bytes(std::span(jpeg)), data);
      part["image_url"]["url"] = std::move(data);
    }
  }
  return filled.dump();
}

}  // namespace enfilade::arena
