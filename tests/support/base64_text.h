/// \file  Texts in base64.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "enfilade/core/base64.h"

namespace enfilade::tests {

inline std::string base64(std::string_view text) {
  std::string encoded;
  append_base64(std::as_bytes(std::span(text)), encoded);
  return encoded;
}

}  // namespace enfilade::tests
