/// \file  What a call says that is expected to throw.
#pragma once
#include <exception>
#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::tests {

/// The message of an `Expected`; "another type: ..." of anything else; "accepted" if the call
/// returns.
template <class Expected = Error, class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Expected& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("another type: ") + error.what();
  }
  return "accepted";
}

}  // namespace enfilade::tests
