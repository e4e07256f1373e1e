/// \file  Letters and percent-encoding in texts of HTTP. Any thread may call them.
#pragma once
#include <string>
#include <string_view>

namespace enfilade {

/// With a to z for A to Z; names of headers, codings and hosts are the same in any case.
std::string lower_case(std::string_view text);

/// With the byte that each %HH stands for; a % without two digits stays as it is.
std::string decode_percent(std::string_view text);

}  // namespace enfilade
