/// \file  Responses of this module's servers.
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "enfilade/net/messages.h"

namespace enfilade::arena::detail {

/// \param body JSON
inline net::Response json_response(std::string body) {
  net::Response response;
  response.body = std::make_shared<const std::string>(std::move(body));
  return response;
}

}  // namespace enfilade::arena::detail
