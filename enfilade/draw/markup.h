/// \file  Text in SVG and HTML.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::draw {

/// Text that is safe between tags and in attributes of XML and HTML. Bytes that are no UTF-8 and
/// characters that XML forbids become U+FFFD. Any thread.
std::string escape(std::string_view text);

}  // namespace enfilade::draw
