/// \file  Hashes of data, as texts.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::models::detail {

/// 16 hex digits of XXH3, 64 bits: detects accidental changes, not deliberate ones.
std::string hash_of(std::string_view bytes);

}  // namespace enfilade::models::detail
