/// \file  Headers that protect browsers, on every answer.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/service/http/http.h"

namespace enfilade::service::http {

/// A Content-Security-Policy: scripts and styles from the server's own files only, pictures from it
/// and from memory.
std::string content_policy(std::string_view form_action, std::string_view frame_ancestors);

/// Adds those that the response does not have yet.
void add_security_headers(Response& response);

}  // namespace enfilade::service::http
