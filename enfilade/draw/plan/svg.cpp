#include "enfilade/draw/plan/svg.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace enfilade::draw::plan {
std::string number(double value) {
  const double tenths = std::round(value * 10) / 10;
  return fmt::format("{}", tenths == 0 ? 0.0 : tenths);  // no "-0"
}

std::string pair(Point p) { return number(p.x) + "," + number(p.y); }

double text_width(std::string_view text, double size) {
  std::size_t characters = 0;
  for (const char c : text) characters += (static_cast<unsigned char>(c) & 0xc0U) != 0x80 ? 1 : 0;
  return 0.58 * size * static_cast<double>(characters);
}

std::vector<std::string> wrap(std::string_view text, double size, double width) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<std::string> lines;
  for (std::size_t at = text.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    const std::string word(text.substr(at, end - at));
    if (lines.empty() || text_width(lines.back() + " " + word, size) > width) {
      lines.push_back(word);
    } else {
      lines.back() += " " + word;
    }
    at = text.find_first_not_of(kBlanks, end);
  }
  return lines;
}

}  // namespace enfilade::draw::plan
