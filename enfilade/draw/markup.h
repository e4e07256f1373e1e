/// \file  Escaping of text for SVG and HTML.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::draw {

/// Escapes a text for use between tags and in attributes of XML and HTML. Bytes that are not UTF-8
/// and characters that XML forbids become U+FFFD. Any thread.
std::string escape(std::string_view text);

}  // namespace enfilade::draw
