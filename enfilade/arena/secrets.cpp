#include "enfilade/arena/detail/secrets.h"

#include <algorithm>
#include <cctype>
#include <span>
#include <utility>

#include "enfilade/core/base64.h"

namespace enfilade::arena::detail {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kShown = "(key)";
constexpr std::size_t kMostBackslashes = 64;  // JSON in JSON in JSON in JSON, and so on

bool is_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool is_hex_of(std::string_view digits, char c) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  const auto code = static_cast<unsigned char>(c);
  const auto is = [](char digit, unsigned value) {
    return std::tolower(static_cast<unsigned char>(digit)) == kDigits[value];
  };
  return digits.size() == 2 && is(digits[0], code / 16U) && is(digits[1], code % 16U);
}

/// Bytes at the beginning of a text that stand for a character; 0: they do not.
std::size_t spelled(std::string_view text, char c) {
  if (text.starts_with('%') && is_hex_of(text.substr(1, 2), c)) return 3;
  if (text.starts_with('\\')) {
    const std::size_t found = text.substr(0, kMostBackslashes).find_first_not_of('\\');
    const std::size_t run = std::min(found, text.size());
    const std::string_view after = text.substr(run);
    if (after.starts_with("u00") && is_hex_of(after.substr(3, 2), c)) return run + 5;
    if (c == '\\') return std::min(run, kMostBackslashes);
    return (c == '"' || c == '/' || c == '\'') && after.starts_with(c) ? run + 1 : 0;
  }
  return text.starts_with(c) ? 1 : 0;
}

std::string base64_of(std::string_view text) {
  std::string encoded;
  append_base64(std::as_bytes(std::span(text)), encoded);
  while (encoded.ends_with('=')) encoded.pop_back();
  return encoded;
}

}  // namespace

Secrets::Secrets(const std::vector<std::string>& secrets) {
  for (const std::string& one : secrets) {
    if (!one.empty()) add(one);
  }
}

void Secrets::add(const std::string& secret) {
  const bool word = secret.size() < kLeastPart;
  const auto add_pattern = [&](std::string text) { patterns_.push_back({std::move(text), word}); };
  add_pattern(secret);
  // In a longer text it begins at any of three places within the groups of four characters. Those
  // that its neighbours decide, too, are left out.
  constexpr std::size_t kOfNeighbours[] = {0, 2, 3};
  for (std::size_t before = 0; before < (word ? 1U : 3U); ++before) {
    std::string encoded = base64_of(std::string(before, ' ') + secret);
    if (!word) encoded.resize((before + secret.size()) * 8 / 6);
    encoded.erase(0, kOfNeighbours[before]);
    std::string of_addresses = encoded;
    std::ranges::replace(of_addresses, '+', '-');
    std::ranges::replace(of_addresses, '/', '_');
    if (of_addresses != encoded) add_pattern(std::move(of_addresses));
    add_pattern(std::move(encoded));
  }
}

std::size_t Secrets::end_at(std::string_view text, std::size_t at) const {
  std::size_t end = at;
  // Within a run of backslashes nothing begins that did not begin before it.
  if (at > 0 && text[at] == '\\' && text[at - 1] == '\\') return end;
  for (const Pattern& one : patterns_) {
    if (one.word && at > 0 && is_of_word(text[at - 1])) continue;
    std::size_t past = at;
    const bool whole = std::ranges::all_of(one.text, [&](char c) {
      // A run of backslashes stands for any number of them.
      const bool in_run = c == '\\' && past > at && text[past - 1] == '\\';
      const std::size_t bytes = spelled(text.substr(past), c);
      past += bytes;
      return bytes > 0 || in_run;
    });
    if (!whole || (one.word && past < text.size() && is_of_word(text[past]))) continue;
    end = std::max(end, past);
  }
  return end;
}

std::string Secrets::hide(std::string_view text) const {
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = end_at(text, at);
    if (end > at) {
      shown += kShown;
      at = end;
    } else {
      shown += text[at++];
    }
  }
  return shown;
}

// NOLINTNEXTLINE(misc-no-recursion): the levels have a limit
bool Secrets::hide_in(Json& value, std::string_view name) const {
  bool found = false;
  if (value.is_object()) {
    Json shown = Json::object();
    for (const auto& [key, one] : value.items()) {
      std::string shown_key = hide(key);
      found |= shown_key != key;
      found |= hide_in(one, key);
      shown[std::move(shown_key)] = std::move(one);
    }
    value = std::move(shown);
  } else if (value.is_array()) {
    std::string texts;
    for (Json& one : value) {
      found |= hide_in(one, {});
      const Json* const text =
          one.is_object() && one.contains("text") ? &one["text"] : &std::as_const(one);
      if (text->is_string()) texts += text->get_ref<const std::string&>();
    }
    // Readers of a content join its texts.
    std::string joined = name == "content" ? hide(texts) : texts;
    if (joined == texts) return found;
    value = std::move(joined);
    found = true;
  } else if (value.is_string() || value.is_number()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    std::string shown = hide(text);
    found = shown != text;
    if (found) value = std::move(shown);
  }
  return found;
}

std::string Secrets::hide_in_body(std::string body) const {
  if (patterns_.empty()) return body;
  Json value = Json::parse(body, nullptr, false);
  if (!value.is_structured()) return hide(body);
  // Where a name repeats, the value has the last one alone: the others are in the body.
  const bool found = hide_in(value, {}) || hide(body) != body;
  return found ? value.dump(-1, ' ', false, Json::error_handler_t::replace) : body;
}

}  // namespace enfilade::arena::detail
