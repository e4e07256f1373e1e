/// \file  Base64 (RFC 4648, section 4: with "+", "/" and padding, without line breaks).
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace enfilade {

/// Adds what stands for the bytes.
void append_base64(std::span<const std::byte> bytes, std::string& text);

/// How many bytes a text of whole groups stands for; none if its length is no multiple of 4.
std::optional<std::size_t> base64_bytes(std::string_view text) noexcept;
/// Where the first character is that does not belong there; npos if all do. \pre out.size() is what
/// base64_bytes() says
std::size_t decode_base64(std::string_view text, std::span<std::byte> out) noexcept;

}  // namespace enfilade
