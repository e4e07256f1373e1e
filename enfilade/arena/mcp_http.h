/// \file  The Model Context Protocol over HTTP, for assistants that reach tools by an address.
#pragma once
#include <memory>
#include <string>

#include "enfilade/arena/mcp.h"

namespace enfilade::arena {

/// Where it listens.
struct McpHttpConfig {
  std::string host = "127.0.0.1";  ///< a local interface
  int port = 8001;                 ///< 0: any that is free
};

/// `POST /mcp`, "Streamable HTTP" of the revisions from 2025-03-26 on. A response is JSON, or, with
/// a notification, a stream of events. One assistant at a time: `initialize` gives it a session,
/// which ends earlier ones (404); the revision of 2026-07-28 has none. Pages of other sites are
/// refused (403), by `Origin` and by `Host`. It is for local use: any program that reaches the port
/// can step the episode. Only in builds with EN_WITH_WEB.
class McpHttp {
 public:
  /// Listens when this returns. \param server outlives it; no other caller uses it meanwhile
  /// \throws ArgumentError if the port is taken or the host is not an interface
  McpHttp(McpServer& server, const McpHttpConfig& config);
  ~McpHttp();  ///< stops
  McpHttp(const McpHttp&) = delete;
  McpHttp& operator=(const McpHttp&) = delete;

  std::string url() const;  ///< "http://127.0.0.1:8001/mcp"

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena
