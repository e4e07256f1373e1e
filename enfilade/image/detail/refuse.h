/// \file  How the readers of pictures say that a file cannot be used.
#pragma once
#include <cstdint>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::image {

/// \throws InvalidInput with this one fault
[[noreturn]] inline void refuse(const std::string& file, std::string where, std::string code,
                                std::string message) {
  throw InvalidInput(
      {{Severity::kError, file, std::move(where), std::move(code), std::move(message)}});
}

/// Refuses sizes beyond kLongestEdge and kMostPixels, and none. \throws InvalidInput
void check_size(std::uint64_t width, std::uint64_t height, const std::string& file);

}  // namespace enfilade::image
