/// \file  `enfilade mcp --port`, in builds with HTTP.
#pragma once
#include <string>

#include "enfilade/arena/mcp.h"

namespace enfilade::apps {

/// Listens until SIGINT or SIGTERM. \param done how far the episodes are, for people
/// \throws UsageError in a build without HTTP; as arena::McpHttp
void serve_mcp_over_http(arena::McpServer& server, int port, const std::string& done);

}  // namespace enfilade::apps
