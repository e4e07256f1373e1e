#include "enfilade/mesh/readers/text.h"

#include <fmt/format.h>
#include <cmath>
#include <utility>

#include "enfilade/core/numbers.h"

namespace enfilade::mesh::readers {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

/// parse_number() takes no plus sign, which other programs write.
std::string_view without_plus(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  return plus ? word.substr(1) : word;
}

}  // namespace

std::optional<std::string_view> Lines::next() {
  if (rest_.empty()) return std::nullopt;
  ++number_;
  const std::size_t end = rest_.find('\n');
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string Lines::where() const { return fmt::format("line {}", number_); }

std::string_view cut_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

std::string_view trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> out;
  for (std::string_view word = cut_word(line); !word.empty(); word = cut_word(line)) {
    out.push_back(word);
  }
  return out;
}

std::optional<double> to_number(std::string_view word) {
  const auto value = parse_number<double>(without_plus(word));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> to_integer(std::string_view word) {
  return parse_number<std::int64_t>(without_plus(word));
}

std::string in_quotes(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string out = fmt::format("{:?}", word.substr(0, kMost));
  if (word.size() > kMost) out += "...";
  return out;
}

void FaultList::error(std::string where, std::string code, std::string message) {
  constexpr std::size_t kMost = 100;
  found_.push_back(
      {Severity::kError, file_, std::move(where), std::move(code), std::move(message)});
  if (found_.size() == kMost) throw_if_any();
}

void FaultList::throw_if_any() {
  if (any()) throw InvalidInput(std::move(found_));
}

}  // namespace enfilade::mesh::readers
