/// \file  gzip of texts in memory.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::service::detail {

/// gzip as in RFC 1952. \param level 1 (fast) to 9 (small)
std::string gzip(std::string_view text, int level);
/// Its inverse. \throws Error for bytes that gzip() did not write
std::string gunzip(std::string_view packed);

}  // namespace enfilade::service::detail
