/// \file  Ids and names of files that come from foreign data, and texts of foreign data in
/// messages. The rule for ids is in docs/conventions.md.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace enfilade {

/// Longest id in bytes. Two ids and an ending of 42 bytes are still a file's name (255
/// bytes), with the 12 that OutputFolder puts behind it.
inline constexpr std::size_t kLongestId = 100;
/// An instruction's id is a path's id with `_<k>` behind it.
inline constexpr std::size_t kLongestInstructionId = kLongestId + 10;

/// Whether a text is an id of a scan, viewpoint, path, instruction, object, phase or run. It has 1
/// to `most` bytes of `A-Z a-z 0-9 _ - .`, and the first is neither `-` nor `.`.
bool is_id(std::string_view text, std::size_t most = kLongestId) noexcept;
/// What is wrong with an id, for messages: "\"../x\" is not an id: 1 to 100 of the characters ...".
/// Empty for an id.
std::string fault_of_id(std::string_view text, std::size_t most = kLongestId);

/// The place of the underscore between two ids, as in "<scan>_<viewpoint>": the last one that
/// leaves two ids, else the last one; npos without any.
std::size_t underscore_between_ids(std::string_view text) noexcept;

/// Whether a text names a file or folder within its folder. It has 1 to 255 bytes, no `/`, no `\`,
/// no control character, and no dot at the beginning. Blanks and other scripts are allowed.
bool is_file_name(std::string_view text) noexcept;

/// A foreign text for messages: in quotes, escaped, at most its first `most` bytes. A longer one
/// has its length behind it: "\"aaaa\"... (5000 bytes)". Bytes that are not UTF-8 are escaped.
std::string quote(std::string_view text, std::size_t most = 40);

/// A message for terminals. Control characters are escaped as `\x1b`, except line breaks and tabs.
/// So are characters that change the direction of writing (Unicode UAX 9), as `\u{202e}`, and bytes
/// that are not UTF-8. Other texts stay as they are.
std::string printable(std::string_view text);

}  // namespace enfilade
