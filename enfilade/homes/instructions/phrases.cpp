#include "enfilade/homes/instructions/phrases.h"

#include <algorithm>
#include <cctype>

#include "enfilade/core/check.h"

namespace enfilade::homes::instructions {
namespace {

// The place of the bracket that closes the one at `open`.
std::size_t closing(std::string_view pattern, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < pattern.size(); ++i) {
    if (pattern[i] == '[') ++depth;
    if (pattern[i] == ']' && --depth == 0) return i;
  }
  EN_CHECK(false && "brackets of a pattern do not match");
  return pattern.size();
}

// The choices of "a|3*b", each as many times as its weight says.
std::vector<std::string_view> choices(std::string_view inside) {
  std::vector<std::string_view> found;
  const auto add = [&](std::string_view choice) {
    const bool weighted = choice.size() > 2 && choice[1] == '*';
    const int weight = weighted ? choice[0] - '0' : 1;
    found.insert(found.end(), static_cast<std::size_t>(weight), choice.substr(weighted ? 2 : 0));
  };
  int depth = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    if (inside[i] == '[') ++depth;
    if (inside[i] == ']') --depth;
    if (inside[i] == '|' && depth == 0) {
      add(inside.substr(begin, i - begin));
      begin = i + 1;
    }
  }
  add(inside.substr(begin));
  return found;
}

const std::string& slot(const Slots& slots, std::string_view name) {
  const auto found = std::ranges::find(slots, name, &Slots::value_type::first);
  EN_CHECK(found != slots.end());
  return found->second;
}

bool is_letter(char c) { return c >= 'a' && c <= 'z'; }

// Empty choices leave spaces behind.
std::string tidy(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == ' ' && (out.empty() || out.back() == ' ')) continue;
    if (c == ',' && !out.empty() && out.back() == ' ') out.pop_back();
    out += c;
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

std::string expand_raw(std::string_view pattern, const Slots& slots, Rng& rng) {
  std::string text;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] == '[') {
      const std::size_t end = closing(pattern, i);
      const auto all = choices(pattern.substr(i + 1, end - i - 1));
      text += expand_raw(all[rng.below(all.size())], slots, rng);
      i = end;
    } else if (pattern[i] == '$') {
      std::size_t end = i + 1;
      while (end < pattern.size() && is_letter(pattern[end])) ++end;
      text += slot(slots, pattern.substr(i + 1, end - i - 1));
      i = end - 1;
    } else {
      text += pattern[i];
    }
  }
  return text;
}

}  // namespace

std::string expand(std::string_view pattern, const Slots& slots, Rng& rng) {
  const auto all = choices(pattern);
  return tidy(expand_raw(all[rng.below(all.size())], slots, rng));
}

std::string with_article(const std::string& name) {
  const bool vowel =
      !name.empty() && std::string_view("aeio").find(name[0]) != std::string_view::npos;
  return (vowel || name.starts_with("umbrella") ? "an " : "a ") + name;
}

std::string sentence(std::string text) {
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text + ".";
}

std::string join_clauses(const std::vector<std::string>& clauses, ClauseLinks links, Rng& rng) {
  const bool apart = std::ranges::any_of(clauses, [](const std::string& clause) {
    return clause.find(" and ") != std::string::npos || clause.find(',') != std::string::npos;
  });
  std::string text = clauses.front();
  for (std::size_t i = 1; i < clauses.size(); ++i) {
    const bool last = i + 1 == clauses.size();
    if (!last) {
      text += ", ";
    } else if (links == ClauseLinks::kShort && rng.below(4) != 0) {
      text += apart ? ", " : " and ";
    } else if (apart) {
      text += ", then ";
    } else {
      const std::string_view words[] = {" and ", " and ", ", then ", " and then ", ", and "};
      text += words[rng.below(clauses.size() > 2 ? 5 : 4)];
    }
    text += clauses[i];
  }
  return text;
}

}  // namespace enfilade::homes::instructions
