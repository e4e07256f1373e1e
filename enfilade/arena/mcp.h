/// \file  The Model Context Protocol: an assistant steps through episodes with the tools of its
/// program.
#pragma once
#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/world.h"

namespace enfilade::arena {

/// Episodes and settings of a server.
struct McpConfig {
  std::vector<std::size_t> episodes;  ///< in this order; those with a transcript are left out
  SessionLimits limits = {};
  PictureKind pictures = PictureKind::kNone;
  std::uint32_t picture_size = 512;
  std::string version = {};           ///< version of the program, sent to the assistant's
  std::filesystem::path folder = {};  ///< transcripts/ and results.json, as ask() writes them
};

/// The protocol's server for one assistant, over any transport. Supports the revision of 2026-07-28
/// (`server/discover`, stateless) and those from 2024-11-05 to 2025-11-25 (`initialize`). One
/// thread at a time.
///
/// `begin` starts the next episode or repeats the one in progress. The other tools are those of the
/// task (World::tools()). All are listed from the start, because most assistants list the tools
/// once. The first list after `initialize`, and all of the stateless revision, have plain strings
/// as arguments. Later lists enumerate the values that are possible at this step. Each result has
/// them in words. A call before the first episode begins it, and has no other effect. After an
/// episode's end a call has no effect until `begin`.
class McpServer {
 public:
  /// \param sights for pictures; may be empty if there are none
  /// \throws as Play
  McpServer(std::unique_ptr<World> world, const ViewSources& sights, McpConfig config);
  ~McpServer();
  McpServer(const McpServer&) = delete;
  McpServer& operator=(const McpServer&) = delete;

  /// Largest size of a message.
  static constexpr std::size_t kMostBytes = std::size_t{1} << 20U;

  /// Reads a line, a message of standard input. Of one that is too large its beginning is kept,
  /// kMostBytes + 1 bytes, which handle() refuses. \returns false at the end
  static bool read_message(std::istream& from, std::string& message);

  /// Takes a message, JSON-RPC 2.0, and returns the messages to send: a response, then perhaps a
  /// notification that the tools have changed. Empty for notifications and responses. A batch of at
  /// most 64 messages gets a batch of responses; in revisions after 2025-03-26, an error. Messages
  /// of more than kMostBytes, 10,000 values or 64 levels get an error too. Never throws for the
  /// content of a message. \throws FileError if a transcript cannot be written
  std::vector<std::string> handle(std::string_view message);

  std::size_t done() const noexcept;  ///< episodes with a transcript
  std::size_t size() const noexcept;  ///< episodes in all

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where McpHttp listens.
struct McpHttpConfig {
  std::string host = "127.0.0.1";  ///< a local interface
  int port = 8001;                 ///< 0: any that is free
};

/// The protocol over HTTP, for assistants that reach tools by an address: `POST /mcp` (or `/mcp/`),
/// "Streamable HTTP" of the revisions from 2025-03-26 on. A response is JSON, or, with a
/// notification for a client that accepts one, a stream of events. One assistant at a time:
/// `initialize` gives it a session, which ends earlier ones (404); the revision of 2026-07-28 has
/// none. Pages of this machine may call it, and get the headers that a browser needs for that
/// (CORS). Pages of other sites are refused (403), by `Host` and by `Origin`, before a body is
/// read. The limits are those of net::Server, and 1 MiB for a body, also unpacked. It is for local
/// use: any program that reaches the port can step the episode. Only in builds with EN_WITH_WEB.
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
