#include "tests/conformance/synthetic.h"

#include <fmt/format.h>
#include <algorithm>

namespace enfilade::tests {
namespace {

constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15U;

float value_of(std::uint64_t hash, std::uint64_t i) noexcept {
  std::uint64_t z = hash + kStep * (i + 1);
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  z ^= z >> 31U;
  return static_cast<float>(static_cast<double>(z >> 40U) / 8388608.0 - 1.0);
}

void fill(const std::string& name, std::uint64_t first, std::span<float> out) {
  const std::uint64_t hash = name_hash(name);
  for (std::size_t c = 0; c < out.size(); ++c) out[c] = value_of(hash, first + c);
}

}  // namespace

std::uint64_t name_hash(std::string_view bytes) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

float synthetic_value(std::string_view name, std::uint64_t i) noexcept {
  return value_of(name_hash(name), i);
}

void synthetic_view(std::string_view scan, std::string_view viewpoint, std::uint32_t view,
                    std::span<float> out) {
  constexpr std::uint64_t kColumns = 65536;
  fill(fmt::format("{}_{}", scan, viewpoint), kColumns * view, out);
}

void synthetic_object(std::string_view scan, std::string_view viewpoint, std::string_view object,
                      std::span<float> out) {
  fill(fmt::format("{}_{}_{}", scan, viewpoint, object), 0, out);
}

std::vector<std::int64_t> synthetic_words(std::string_view text, std::size_t most) {
  constexpr std::string_view kBlanks = " \t\n\r\f\v";
  constexpr std::int64_t kFirst = 1, kLast = 2, kSpecial = 3;
  constexpr std::uint64_t kWords = 297;
  std::vector<std::int64_t> ids{kFirst};
  for (std::size_t at = text.find_first_not_of(kBlanks); at != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    ids.push_back(kSpecial +
                  static_cast<std::int64_t>(name_hash(text.substr(at, end - at)) % kWords));
    at = text.find_first_not_of(kBlanks, end);
  }
  ids.push_back(kLast);
  if (ids.size() > most) ids.resize(most);
  return ids;
}

}  // namespace enfilade::tests
