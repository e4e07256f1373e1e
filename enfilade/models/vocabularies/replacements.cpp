#include "enfilade/models/vocabularies/replacements.h"

#include <fmt/format.h>

#include "enfilade/core/errors.h"

namespace enfilade::models::vocabularies {
namespace {

std::uint32_t little_endian(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 4; k-- > 0;) {
    value = value << 8U | static_cast<unsigned char>(bytes[at + k]);
  }
  return value;
}

// A unit's parts: where its children begin, relative to it, and which byte leads to it.
std::uint32_t offset_of(std::uint32_t unit) { return (unit >> 10U) << ((unit & 0x200U) >> 6U); }
std::uint32_t label_of(std::uint32_t unit) { return unit & 0x800000ffU; }
bool has_value(std::uint32_t unit) { return (unit & 0x100U) != 0; }
std::uint32_t value_of(std::uint32_t unit) { return unit & 0x7fffffffU; }

}  // namespace

Replacements::Replacements(std::string_view table, const std::string& origin) : origin_(origin) {
  if (table.empty()) return;
  constexpr std::size_t kHead = 4, kUnit = 4;
  const std::size_t size = table.size() < kHead ? 0 : little_endian(table, 0);
  if (size == 0 || size % kUnit != 0 || size > table.size() - kHead) {
    fail(fmt::format("a trie of {} bytes in {}", size, table.size()));
  }
  for (std::size_t at = kHead; at < kHead + size; at += kUnit) {
    units_.push_back(little_endian(table, at));
  }
  texts_ = table.substr(kHead + size);
  if (!texts_.ends_with('\0')) fail("no zero byte at the end of the texts");
}

std::pair<std::string_view, std::size_t> Replacements::longest(std::string_view text) const {
  std::pair<std::string_view, std::size_t> best{{}, 0};
  if (units_.empty()) return best;
  std::size_t at = offset_of(unit(0));
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    if ((at ^ byte) >= units_.size()) break;  // no child
    at ^= byte;
    const std::uint32_t node = units_[at];
    if (label_of(node) != byte) break;
    at ^= offset_of(node);
    if (!has_value(node)) continue;
    const std::uint32_t value = value_of(unit(at));
    if (value >= texts_.size()) fail(fmt::format("text {} of {} bytes", value, texts_.size()));
    best = {std::string_view(texts_.c_str() + value), k + 1};
  }
  return best;
}

std::uint32_t Replacements::unit(std::size_t at) const {
  if (at >= units_.size()) fail(fmt::format("unit {} of {}", at, units_.size()));
  return units_[at];
}

void Replacements::fail(const std::string& what) const {
  refuse(origin_, "$.normalizer_spec.precompiled_charsmap", "bad-table", what);
}

}  // namespace enfilade::models::vocabularies
