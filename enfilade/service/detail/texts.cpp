#include "enfilade/service/detail/texts.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <algorithm>
#include <array>
#include <ctime>
#include <span>

#include "enfilade/core/check.h"
#include "enfilade/core/utf8.h"

namespace enfilade::service::detail {
namespace {

constexpr std::size_t kLongestName = 40;
constexpr std::size_t kLongestExternalId = 100;
constexpr std::string_view kNameCharacters = "abcdefghijklmnopqrstuvwxyz0123456789-_";
constexpr std::string_view kIdCharacters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

bool is_made_of(std::string_view text, std::string_view characters, std::size_t most) {
  return !text.empty() && text.size() <= most &&
         text.find_first_not_of(characters) == std::string_view::npos;
}

/// \pre c is one well-formed character of UTF-8
char32_t code_point(std::string_view c) {
  constexpr std::array<unsigned, 5> kFirstBits{0, 0x7F, 0x1F, 0x0F, 0x07};  // by the length
  char32_t code = static_cast<unsigned char>(c.front()) & kFirstBits[c.size()];
  for (const char next : c.substr(1))
    code = (code << 6U) | (static_cast<unsigned char>(next) & 0x3FU);
  return code;
}

struct Range {
  char32_t first, last;
};

bool is_in(char32_t code, std::span<const Range> ranges) {
  return std::ranges::any_of(
      ranges, [code](const Range& range) { return code >= range.first && code <= range.last; });
}

// Control characters, and marks that change the direction of the text.
constexpr Range kUnprintable[] = {{0x00, 0x1F}, {0x7F, 0x9F}, {0x202A, 0x202E}, {0x2066, 0x2069}};
// Invisible characters (Unicode 15, Default_Ignorable_Code_Point), and blanks other than the space:
// two different names must not look the same. Some scripts need them within sentences.
constexpr Range kUnseen[] = {
    {0xA0, 0xA0},     {0xAD, 0xAD},     {0x34F, 0x34F},    {0x61C, 0x61C},   {0x115F, 0x1160},
    {0x1680, 0x1680}, {0x17B4, 0x17B5}, {0x180B, 0x180F},  {0x2000, 0x200F}, {0x2028, 0x202F},
    {0x205F, 0x206F}, {0x2800, 0x2800}, {0x3000, 0x3000},  {0x3164, 0x3164}, {0xFE00, 0xFE0F},
    {0xFEFF, 0xFEFF}, {0xFFA0, 0xFFA0}, {0xE0000, 0xE0FFF}};

enum class TextKind { kLabel, kProse };

bool is_text(std::string_view text, std::size_t most, TextKind kind) {
  std::size_t characters = 0;
  for (; !text.empty(); ++characters) {
    const std::size_t size = utf8_length(text);
    if (size == 0) return false;
    const char32_t code = code_point(text.substr(0, size));
    const bool is_break = kind == TextKind::kProse && (code == '\n' || code == '\t');
    if (!is_break && is_in(code, kUnprintable)) return false;
    if (kind == TextKind::kLabel && is_in(code, kUnseen)) return false;
    text.remove_prefix(size);
  }
  return characters > 0 && characters <= most;
}

}  // namespace

bool is_label(std::string_view text, std::size_t most) {
  return is_text(text, most, TextKind::kLabel) && text.front() != ' ' && text.back() != ' ';
}

bool is_prose(std::string_view text, std::size_t most) {
  return is_text(text, most, TextKind::kProse);
}

bool is_name(std::string_view text) { return is_made_of(text, kNameCharacters, kLongestName); }

bool is_https_address(std::string_view text) {
  constexpr std::string_view kScheme = "https://";
  constexpr std::size_t kLongest = 300;
  if (!text.starts_with(kScheme) || text.size() > kLongest) return false;
  const std::string_view rest = text.substr(kScheme.size());
  if (rest.empty() || rest.front() == '/' || rest.front() == '?' || rest.front() == '#')
    return false;
  return std::ranges::all_of(rest, [](char c) {
    return c > ' ' && c <= '~' && std::string_view("\"'<>\\`").find(c) == std::string_view::npos;
  });
}

bool is_external_id(std::string_view text) {
  return is_made_of(text, kIdCharacters, kLongestExternalId);
}

std::string iso_time(std::int64_t seconds) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::optional<std::int64_t> parse_time(std::string_view text) {
  std::tm at{};
  if (::strptime(std::string(text).c_str(), "%Y-%m-%dT%H:%M:%SZ", &at) == nullptr) return {};
  const std::int64_t seconds = ::timegm(&at);
  // A day or a time of day that does not exist comes out as another one.
  return iso_time(seconds) == text ? std::optional(seconds) : std::nullopt;
}

std::string sheet_text(const std::string& text) {
  std::string out = "\"";
  if (!text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos) {
    out += '\'';
  }
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + '"';
}

std::string new_secret(std::string_view prefix) {
  std::array<unsigned char, 32> bytes{};
  EN_CHECK_EQ(RAND_bytes(bytes.data(), static_cast<int>(bytes.size())), 1);
  return fmt::format("{}{:02x}", prefix, fmt::join(bytes, ""));
}

std::string sha256(std::string_view text) {
  std::array<unsigned char, 32> digest{};
  unsigned length = 0;
  EN_CHECK_EQ(EVP_Digest(text.data(), text.size(), digest.data(), &length, EVP_sha256(), nullptr),
              1);
  EN_CHECK_EQ(length, digest.size());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string keyed_hash(std::string_view key, std::string_view text) {
  std::array<unsigned char, 32> digest{};
  unsigned length = 0;
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  EN_CHECK(HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), bytes, text.size(),
                digest.data(), &length) != nullptr);
  EN_CHECK_EQ(length, digest.size());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

}  // namespace enfilade::service::detail
