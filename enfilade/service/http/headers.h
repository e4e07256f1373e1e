/// \file  Headers of responses: security, compression, caching.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/service/http/messages.h"
#include "enfilade/service/server.h"

namespace enfilade::service::http {

bool accepts_gzip(const Request& request);
/// Compresses a text that is long enough, for a client that accepts it.
void compress(const Request& request, Response& response);
/// Makes it a 304 if the client's cached copy has the same ETag.
void compare_with_cached(const Request& request, Response& response);

/// Whether the visitor's side of the connection is encrypted, as a trusted proxy reports.
bool is_encrypted(const Request& request, const ServerConfig& config);
/// The name of the session's cookie. A browser sends a host's cookies to all its ports. So the
/// visitor's port is part of the name, or two servers would log each other's visitors out. On
/// encrypted connections it begins with "__Host-", so pages of the domain's other hosts cannot set
/// it.
std::string session_cookie(const Request& request, const ServerConfig& config);

/// A Content-Security-Policy: scripts and styles from the server's own files only, pictures from it
/// and from memory.
std::string content_policy(std::string_view form_action, std::string_view frame_ancestors);

/// Adds the security headers that the response does not have yet.
void add_security_headers(Response& response);

}  // namespace enfilade::service::http
