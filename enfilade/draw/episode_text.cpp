#include "enfilade/draw/episode_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cctype>

namespace enfilade::draw {
namespace {

constexpr std::string_view kTarget = "<TAR>";

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin));
}

std::string line_of(const tasks::DialogueTurn& turn) {
  std::string role = turn.role.empty() ? "somebody" : turn.role;
  role[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(role[0])));
  const std::string when = turn.nav_step == 0 ? ""
                                              : fmt::format(", after {} step{}", turn.nav_step,
                                                            turn.nav_step == 1 ? "" : "s");
  return fmt::format("{}{}: {}", role, when, trimmed(turn.message));
}

std::string line_of(const tasks::SubInstruction& part, std::size_t number) {
  std::string line = fmt::format("{}. {}", number, fmt::join(part.words, " "));
  if (!part.places) return line;
  const auto [first, last] = *part.places;
  return line + (first == last ? fmt::format(" (viewpoint {})", first + 1)
                               : fmt::format(" (viewpoints {} to {})", first + 1, last + 1));
}

}  // namespace

std::string target_of(std::string_view text) {
  const std::size_t at = text.rfind(kTarget);
  return at == std::string_view::npos ? "" : trimmed(text.substr(at + kTarget.size()));
}

std::vector<std::string> episode_lines(const tasks::Episode& episode) {
  std::vector<std::string> lines;
  const tasks::InstructionDetails& details = episode.details;
  if (!details.language.empty()) lines.push_back("Language: " + details.language);
  for (const tasks::DialogueTurn& turn : details.turns) lines.push_back(line_of(turn));
  const std::string target = target_of(episode.text), text = trimmed(episode.text);
  if (!target.empty()) {
    lines.push_back("Looking for: " + target);
  } else if (!text.empty() && details.turns.empty()) {
    lines.push_back("\u201c" + text + "\u201d");
  }
  std::size_t number = 0;
  for (const tasks::SubInstruction& part : details.parts) lines.push_back(line_of(part, ++number));
  for (const auto& [name, value] : details.fields) {
    if (!value.empty()) lines.push_back(fmt::format("{}: {}", name, value));
  }
  return lines;
}

}  // namespace enfilade::draw
