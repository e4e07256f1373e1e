/// \file  Hashes as files keep them.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::models::detail {

/// 16 hex digits of XXH3, 64 bits: tells accidents apart, not forgeries.
std::string hash_of(std::string_view bytes);

}  // namespace enfilade::models::detail
