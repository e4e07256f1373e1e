/// \file  Rules for texts that users send, formats of texts that they get, random secrets and their
/// hashes. All functions may be called from any thread, keep no reference to their arguments, and
/// throw nothing of their own.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/core/texts.h"

namespace enfilade::service::detail {

/// Whether `text` may be a displayed name: of a team, a method, a worker. It is valid UTF-8 of 1 to
/// `most` characters, without a space at either end. It has no control characters, no characters
/// that change the direction of the text, no invisible ones, and no blank except the space. So two
/// different names look different.
bool is_label(std::string_view text, std::size_t most);

/// Whether `text` may be a text of several lines: as is_label(), but line breaks, tabs and blanks
/// of all kinds are allowed anywhere. So are the invisible characters that some scripts need.
bool is_prose(std::string_view text, std::size_t most);

/// Whether `text` may be a part of a URL: 1 to 40 of a-z, 0-9, - and _.
bool is_name(std::string_view text);

/// Whether `text` may be a link on our pages: https:// and a host, 300 characters at most. Only
/// visible ASCII without quotes, <, > and backslashes.
bool is_https_address(std::string_view text);

/// Whether `text` may be a platform's id of a worker, an assignment or a study: 1 to 100 of A-Z,
/// a-z, 0-9, - and _.
bool is_external_id(std::string_view text);

/// A time in UTC as in ISO 8601: "2026-11-21T16:15:09Z". \param seconds since 1970
std::string iso_time(std::int64_t seconds);

/// The inverse of iso_time(). No value for another form ("2026-11-21", an offset instead of Z), or
/// a day or a time of day that does not exist.
std::optional<std::int64_t> parse_time(std::string_view text);

/// `text` as a field of CSV, in quotes. If it begins with =, +, - or @, an apostrophe is put before
/// it: spreadsheets would run it as a formula.
std::string sheet_text(const std::string& text);

/// `prefix` and 256 bits of the system's randomness in hexadecimal digits.
std::string new_secret(std::string_view prefix);

/// SHA-256 in hexadecimal digits. Enough for secrets of 256 random bits, which cannot be guessed
/// however fast the hash is; passwords would need a slow hash.
std::string sha256(std::string_view text);

/// HMAC-SHA-256 in hexadecimal digits. Only holders of the key can compute this hash, so it suits
/// values that are few enough to be tried one by one.
std::string keyed_hash(std::string_view key, std::string_view text);

}  // namespace enfilade::service::detail
