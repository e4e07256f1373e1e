// A chat completion that comes in parts: server-sent events.
#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/arena/detail/limits.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

/// What grows from event to event is looked through for each, so it may not grow for long.
void limit(std::size_t size, std::size_t most, const char* what) {
  if (size <= most) return;
  throw EndpointError(0, fmt::format("a response in parts of more than {} {}", most, what));
}

/// Adds what a part says to what was said: texts and lists grow, other values replace. Calls of
/// tools are joined by their index.
void add_part(Json& whole, const Json& part, std::string_view name) {
  constexpr std::string_view kSaidOnce[] = {"role", "id", "type", "name", "index"};
  if (part.is_null()) return;
  const bool once = std::ranges::find(kSaidOnce, name) != std::end(kSaidOnce);
  if (whole.is_string() && part.is_string() && !once) {
    whole.get_ref<std::string&>() += part.get_ref<const std::string&>();
  } else if (name == "tool_calls" && part.is_array()) {
    if (!whole.is_array()) whole = Json::array();
    for (const Json& one : part) {
      if (!one.is_object()) continue;
      const auto index = one.find("index");
      Json* same = nullptr;
      for (Json& known : whole) {
        if (index != one.end() && known.contains("index") && known["index"] == *index)
          same = &known;
      }
      if (same == nullptr) same = &whole.emplace_back(Json::object());
      limit(whole.size(), detail::kMostCalls, "calls");
      for (const auto& [key, value] : one.items()) add_part((*same)[key], value, key);
    }
  } else if (whole.is_array() && part.is_array()) {
    for (const Json& one : part) whole.push_back(one);
  } else if (whole.is_object() && part.is_object()) {
    for (const auto& [key, value] : part.items()) add_part(whole[key], value, key);
    limit(whole.size(), detail::kAnswerLimits.keys, "keys");
  } else {
    whole = part;
  }
}

/// The data of the next event, and what follows it.
std::string next_event(std::string_view& rest) {
  std::string data;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty() && !data.empty()) return data;
    if (!line.starts_with("data:")) continue;  // comments, ids, names
    data += (data.empty() ? "" : "\n") + std::string(trimmed(line.substr(5)));
  }
  return data;
}

}  // namespace

std::string join_events(std::string_view events) {
  Json completion{{"object", "chat.completion"}};
  Json message = Json::object(), reason, usage;
  bool whole = false;
  while (!events.empty()) {
    std::string data = next_event(events);
    if (data == "[DONE]") {
      whole = true;
      break;
    }
    if (data.empty()) continue;
    if (const std::string found = json::excess(data, detail::kAnswerLimits); !found.empty()) {
      throw EndpointError(0, fmt::format("an event of {}", found));
    }
    const Json part = Json::parse(data, nullptr, false);
    if (!part.is_object()) throw EndpointError(0, "an event is no JSON object");
    if (part.contains("error") && !part["error"].is_null()) return data;
    for (const char* name : {"id", "model"}) {
      if (part.contains(name)) completion[name] = part[name];
    }
    if (part.contains("usage") && part["usage"].is_object()) usage = part["usage"];
    const auto choices = part.find("choices");
    if (choices == part.end() || !choices->is_array() || choices->empty()) continue;
    const Json& first = choices->front();
    if (!first.is_object()) continue;
    for (const char* name : {"delta", "message"}) {
      if (first.contains(name) && first[name].is_object()) add_part(message, first[name], {});
    }
    if (first.contains("finish_reason") && first["finish_reason"].is_string()) {
      reason = first["finish_reason"];
      whole = true;
    }
  }
  if (!whole) throw EndpointError(0, "the response in parts ends too early");
  if (!message.contains("role")) message["role"] = "assistant";
  if (!message.contains("content")) message["content"] = nullptr;
  completion["choices"] =
      Json::array({{{"index", 0}, {"message", std::move(message)}, {"finish_reason", reason}}});
  if (!usage.is_null()) completion["usage"] = std::move(usage);
  return completion.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace enfilade::arena
