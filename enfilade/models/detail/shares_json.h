/// \file  Reading numbers from 0 to 1: weights of words, probabilities.
#pragma once
#include <cstddef>
#include <vector>

#include "enfilade/core/detail/json.h"

namespace enfilade::models::detail {

/// A number from 0 to 1; 0 after a fault. \param code of a fault: "bad-weight"
double read_share(json::Element element, const json::Path& path, const char* code,
                  json::Faults& faults);

/// A list of such numbers, one per word.
std::vector<double> read_attention(json::Element element, std::size_t words, const json::Path& path,
                                   const char* code, json::Faults& faults);

}  // namespace enfilade::models::detail
