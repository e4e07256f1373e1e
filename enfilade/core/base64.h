/// \file  Base64 (RFC 4648, section 4: with "+", "/" and padding, without line breaks).
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace enfilade {

/// Appends the encoded bytes to `text`.
void append_base64(std::span<const std::byte> bytes, std::string& text);

/// Number of bytes that the text decodes to; nothing if its length is not a multiple of 4.
std::optional<std::size_t> base64_bytes(std::string_view text) noexcept;
/// Decodes into `out`. \returns position of the first invalid character; npos if all are valid
/// \pre out.size() == base64_bytes(text)
std::size_t decode_base64(std::string_view text, std::span<std::byte> out) noexcept;

}  // namespace enfilade
