#include "enfilade/core/base64.h"

#include <array>
#include <cstdint>

namespace enfilade {
namespace {

constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t kNone = 64;

constexpr std::array<std::uint8_t, 256> kValues = [] {
  std::array<std::uint8_t, 256> values{};
  values.fill(kNone);
  for (std::uint8_t i = 0; i < kNone; ++i) values[static_cast<std::uint8_t>(kAlphabet[i])] = i;
  return values;
}();

std::uint32_t value_of(char c) { return kValues[static_cast<std::uint8_t>(c)]; }

std::size_t padding(std::string_view text) {
  if (text.ends_with("==")) return 2;
  return text.ends_with('=') ? 1 : 0;
}

// The bytes of four characters in the low 24 bits; higher bits are set if a character is invalid.
std::uint32_t group(const char* text) {
  const std::uint32_t a = value_of(text[0]), b = value_of(text[1]), c = value_of(text[2]),
                      d = value_of(text[3]);
  const std::uint32_t wrong = (a | b | c | d) & kNone;
  return wrong << 24U | a << 18U | b << 12U | c << 6U | d;
}

}  // namespace

void append_base64(std::span<const std::byte> bytes, std::string& text) {
  const auto at = [&](std::size_t i) {
    return i < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i]) : 0U;
  };
  text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::uint32_t bits = at(i) << 16U | at(i + 1) << 8U | at(i + 2);
    const std::array<char, 4> four{kAlphabet[bits >> 18U], kAlphabet[bits >> 12U & 63U],
                                   i + 1 < bytes.size() ? kAlphabet[bits >> 6U & 63U] : '=',
                                   i + 2 < bytes.size() ? kAlphabet[bits & 63U] : '='};
    text.append(four.data(), four.size());
  }
}

std::optional<std::size_t> base64_bytes(std::string_view text) noexcept {
  if (text.size() % 4 != 0) return std::nullopt;
  return text.size() / 4 * 3 - padding(text);
}

std::size_t decode_base64(std::string_view text, std::span<std::byte> out) noexcept {
  const std::size_t whole = out.size() / 3;
  std::byte* to = out.data();
  for (std::size_t i = 0; i < whole; ++i, to += 3) {
    const std::uint32_t bits = group(text.data() + 4 * i);
    if (bits >> 24U != 0) {
      std::size_t at = 4 * i;
      while (value_of(text[at]) != kNone) ++at;
      return at;
    }
    to[0] = static_cast<std::byte>(bits >> 16U);
    to[1] = static_cast<std::byte>(bits >> 8U & 255U);
    to[2] = static_cast<std::byte>(bits & 255U);
  }
  const std::size_t rest = out.size() % 3;
  if (rest == 0) return std::string_view::npos;
  // One or two bytes more, in two or three characters and padding.
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k <= rest; ++k) {
    const std::size_t at = 4 * whole + k;
    if (value_of(text[at]) == kNone) return at;
    bits |= value_of(text[at]) << (18U - 6U * k);
  }
  for (std::size_t k = 0; k < rest; ++k) {
    to[k] = static_cast<std::byte>(bits >> (16U - 8U * k) & 255U);
  }
  return std::string_view::npos;
}

}  // namespace enfilade
