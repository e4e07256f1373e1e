/// \file  The Model Context Protocol: an assistant steps through episodes with the tools of its
/// program.
#pragma once
#include <cstddef>
#include <filesystem>
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
  Limits limits = {};
  Pictures pictures = Pictures::kNone;
  std::uint32_t picture_size = 512;
  std::string version = {};           ///< version of the program, sent to the assistant's
  std::filesystem::path folder = {};  ///< transcripts/ and results.json, as ask() writes them
};

/// The protocol's server for one assistant, over any transport. Supports the revision of 2026-07-28
/// (`server/discover`, stateless) and those from 2024-11-05 to 2025-11-25 (`initialize`). Tools:
/// `begin` starts the next episode, then those of the session, whose current values are enumerated.
/// One thread at a time.
class McpServer {
 public:
  /// \param sights for pictures; may be empty if there are none
  /// \throws as Play
  McpServer(std::unique_ptr<World> world, Sights sights, McpConfig config);
  ~McpServer();
  McpServer(const McpServer&) = delete;
  McpServer& operator=(const McpServer&) = delete;

  /// Takes a message, JSON-RPC 2.0, and returns the messages to send: a response, then perhaps a
  /// notification that the tools have changed. Empty for notifications. Never throws for the
  /// content of a message; FileError if a transcript cannot be written
  std::vector<std::string> handle(std::string_view message);

  std::size_t done() const noexcept;  ///< episodes with a transcript
  std::size_t size() const noexcept;  ///< episodes in all

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena
