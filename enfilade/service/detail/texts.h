/// \file  Rules for texts that users send, and formats of texts that they get.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace enfilade::service::detail {

/// UTF-8, 1 to `most` characters, no blank at either end; no control characters, none that change
/// the direction of the text, none that are invisible, and no blanks but the space.
bool is_label(std::string_view text, std::size_t most);

/// As is_label(), but with line breaks, tabs and blanks of all kinds anywhere, and with the
/// invisible characters that some scripts need.
bool is_prose(std::string_view text, std::size_t most);

/// 1 to 40 of a-z, 0-9, - and _: a part of URLs.
bool is_name(std::string_view text);

/// An id of a platform: 1 to 100 of A-Z, a-z, 0-9, - and _.
bool is_external_id(std::string_view text);

/// Of seconds since 1970: "2026-11-21T16:15:09Z"
std::string iso_time(std::int64_t seconds);

/// For CSV: quoted, and never beginning like a formula, which spreadsheets would run.
std::string sheet_text(const std::string& text);

}  // namespace enfilade::service::detail
