#include "enfilade/arena/chat.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/core/base64.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kScheme = "enfilade-picture:";
constexpr std::string_view kOneCall = "Nothing was done: one call at a time.";

Json text_part(std::string text) { return {{"type", "text"}, {"text", std::move(text)}}; }

Json image_part(std::string_view key) {
  return {{"type", "image_url"}, {"image_url", {{"url", std::string(kScheme).append(key)}}}};
}

Json request_of(const ChatConfig& config, Json messages) {
  Json request{{"model", config.model},
               {"messages", std::move(messages)},
               {"temperature", config.temperature}};
  if (config.seed) request["seed"] = *config.seed;
  if (config.most_tokens) request["max_tokens"] = *config.most_tokens;
  return request;
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
  const auto count = usage->find(name);
  return count != usage->end() && count->is_number_integer() ? count->get<std::int64_t>() : 0;
}

std::string text_in(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The message of a chat completion.
Json message_of(const Json& completion) {
  if (!completion.is_object()) refuse("$", "no JSON object");
  const auto choices = completion.find("choices");
  if (choices == completion.end() || !choices->is_array() || choices->empty()) {
    refuse("$.choices", "no list with an answer in it");
  }
  const Json& first = choices->front();
  if (!first.is_object() || !first.contains("message") || !first["message"].is_object()) {
    refuse("$.choices[0].message", "no object");
  }
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
  Answers answers;
  Limits limits;
  Json system = {};
  Json past = Json::array();  // messages
  std::vector<PastStep> steps = {};
  Json user = {};  // the present step's
  bool told_by_tool = false;
  std::vector<PictureOrder> pictures = {};
  std::vector<std::string> keys = {};
  std::vector<std::pair<std::string, PictureOrder>> seen = {};  // all so far that may be sent again

  Json user_message(const Observation& observation) {
    Observation shown = observation;
    if (told_by_tool) shown.told.clear();
    std::string text = prompt.step(shown, answers, limits, steps);
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

  Json messages() const {
    Json all = Json::array({system});
    if (prompt.memory() == Memory::kAll) {
      std::size_t observations = 0;
      for (const Json& one : past) observations += one["role"] == "user" ? 1 : 0;
      for (const Json& one : past) {
        const bool is_user = one["role"] == "user";
        const bool kept = !is_user || observations <= prompt.kept_pictures();
        all.push_back(kept ? one : without_pictures(one));
        if (is_user) --observations;
      }
    }
    all.push_back(user);
    return all;
  }
};

Chat::Chat(const Prompt& prompt, ChatConfig config, Answers answers, Limits limits)
    : impl_(new Impl{prompt, std::move(config), answers, limits}) {
  if (impl_->config.model.empty()) throw ArgumentError("model: empty; the server's name for one");
  if (!(impl_->config.temperature >= 0 && impl_->config.temperature <= 2)) {
    throw ArgumentError(fmt::format("temperature: {}, 0 to 2", impl_->config.temperature));
  }
}
Chat::~Chat() = default;

std::string Chat::ask(const Observation& seen, const std::vector<PictureOrder>& pictures,
                      const std::vector<std::string>& keys) {
  Impl& chat = *impl_;
  chat.pictures = pictures;
  chat.keys = keys;
  for (std::size_t k = 0; k < keys.size(); ++k) chat.seen.emplace_back(keys[k], pictures[k]);
  if (chat.system.is_null()) {
    chat.system = {{"role", "system"},
                   {"content", chat.prompt.start(seen, chat.answers, chat.limits)}};
  }
  chat.user = chat.user_message(seen);
  Json request = request_of(chat.config, chat.messages());
  if (chat.answers == Answers::kTools) {
    Json& tools = request["tools"] = Json::array();
    for (const Json& one : Json::parse(functions_json(seen))) {
      tools.push_back({{"type", "function"}, {"function", one}});
    }
    request["tool_choice"] = "required";
  } else if (chat.answers == Answers::kJson) {
    request["response_format"] = {
        {"type", "json_schema"},
        {"json_schema",
         {{"name", "action"}, {"strict", true}, {"schema", Json::parse(answer_schema(seen))}}}};
  }
  return request.dump();
}

ChatAnswer read_completion(std::string_view body) {
  const Json completion = Json::parse(body, nullptr, false);
  ChatAnswer answer;
  answer.text = text_in(message_of(completion), "content");
  answer.prompt_tokens = count_in(completion, "prompt_tokens");
  answer.answer_tokens = count_in(completion, "completion_tokens");
  return answer;
}

ChatAnswer Chat::read(std::string_view body) const {
  ChatAnswer answer = read_completion(body);
  const Json message = message_of(Json::parse(body));
  switch (impl_->answers) {
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
  return answer;
}

void Chat::close(std::string_view body, const ChatAnswer& answer, const Observation& after) {
  Impl& chat = *impl_;
  chat.steps.push_back(past_step(answer.reading, after.told));
  const Json calls = chat.answers == Answers::kTools ? calls_of(message_of(Json::parse(body)))
                                                     : Json(Json::array());
  chat.told_by_tool = !calls.empty() && chat.prompt.memory() == Memory::kAll;
  if (chat.prompt.memory() == Memory::kLast) return;
  chat.past.push_back(chat.user);
  Json said{{"role", "assistant"}, {"content", answer.text}};
  if (!calls.empty()) said["tool_calls"] = calls;
  chat.past.push_back(std::move(said));
  for (std::size_t k = 0; k < calls.size(); ++k) {
    chat.past.push_back({{"role", "tool"},
                         {"tool_call_id", text_in(calls[k], "id")},
                         {"content", k == 0 ? after.told : std::string(kOneCall)}});
  }
}

const PictureOrder* Chat::find_picture(std::string_view key) const {
  const auto found = std::ranges::find(impl_->seen, key,
                                       [](const auto& one) { return std::string_view(one.first); });
  return found == impl_->seen.end() ? nullptr : &found->second;
}

std::string picture_request(const ChatConfig& config, std::string question, std::string_view key) {
  Json content = Json::array({text_part(std::move(question)), image_part(key)});
  Json user{{"role", "user"}, {"content", std::move(content)}};
  return request_of(config, Json::array({std::move(user)})).dump();
}

std::string with_pictures(std::string_view request,
                          const std::function<std::string(std::string_view key)>& picture) {
  Json filled = Json::parse(request);
  for (Json& message : filled["messages"]) {
    if (!message["content"].is_array()) continue;
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
