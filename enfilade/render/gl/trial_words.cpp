#include "enfilade/render/gl/trial_words.h"

namespace enfilade::render::gl {
namespace {

constexpr std::string_view kPrefix = "enfilade-gl";

}  // namespace

std::string line_of(const std::vector<std::string_view>& words) {
  std::string line = "\n";  // what a driver printed need not have ended its line
  line += kPrefix;
  for (const std::string_view word : words) {
    line += '\t';
    for (const char c : word) {
      switch (c) {
        case '\\':
          line += "\\\\";
          break;
        case '\n':
          line += "\\n";
          break;
        case '\t':
          line += "\\t";
          break;
        default:
          line += c;
      }
    }
  }
  return line + '\n';
}

std::vector<std::string> words_of(std::string_view line) {
  if (!line.starts_with(kPrefix)) return {};
  line.remove_prefix(kPrefix.size());
  std::vector<std::string> words;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\t') {
      words.emplace_back();
    } else if (words.empty()) {
      return {};
    } else if (line[i] != '\\' || i + 1 == line.size()) {
      words.back() += line[i];
    } else {
      const char c = line[++i];
      words.back() += c == 'n' ? '\n' : c == 't' ? '\t' : c;
    }
  }
  return words;
}

}  // namespace enfilade::render::gl
