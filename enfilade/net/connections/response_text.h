/// \file  Responses as they are sent.
#pragma once
#include <string>

#include "enfilade/net/messages.h"

namespace enfilade::net::connections {

/// Whether the connection takes a further request after the response.
enum class After { kStays, kCloses };

/// The head of a response. A header with a line break is left out.
std::string head_text(const Response& response, After after);

/// Whether a response of that status has a body.
inline bool may_have_content(int status) { return status != 204 && status != 304; }

}  // namespace enfilade::net::connections
