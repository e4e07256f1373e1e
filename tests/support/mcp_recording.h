/// \file  Conversations of real clients with `enfilade mcp`, as tests/arena/mcp/record.py wrote
/// them.
#pragma once
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/mcp.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/file.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::arena::testing {

/// The folder of clients, recordings and the data set that they were recorded with.
inline std::filesystem::path mcp_folder() {
  return std::filesystem::path(EN_SOURCE_DIR) / "tests/arena/mcp";
}

/// Files whose names begin with "stdio" or "http".
inline std::vector<std::filesystem::path> mcp_recordings(std::string_view transport) {
  std::vector<std::filesystem::path> files;
  for (const auto& one : std::filesystem::directory_iterator(mcp_folder() / "recordings")) {
    if (one.path().filename().string().starts_with(transport)) files.push_back(one.path());
  }
  std::ranges::sort(files);
  return files;
}

/// The lines of a recording, the first of which names the client.
inline std::vector<nlohmann::json> read_mcp_recording(const std::filesystem::path& file) {
  std::vector<nlohmann::json> lines;
  std::istringstream text(read_file(file));
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

/// A server of the recordings' data set: 9 viewpoints, 6 episodes. SYNTHETIC.
inline std::unique_ptr<McpServer> recorded_mcp_server() {
  const dataset::Dataset data(mcp_folder() / "grid");
  return std::make_unique<McpServer>(
      std::make_unique<GraphWorld>(
          std::make_shared<const tasks::EpisodeSet>(data.episodes("val_unseen"))),
      ViewSources(), McpConfig{.episodes = {0, 1, 2, 3, 4, 5}});
}

/// A message without what may change while clients understand it: sentences and versions.
inline nlohmann::json shape_of(nlohmann::json value) {
  constexpr std::array<std::string_view, 5> kChanging{"description", "instructions", "message",
                                                      "text", "version"};
  for (auto& [name, part] : value.items()) {
    if (part.is_string()) {
      if (std::ranges::find(kChanging, name) != kChanging.end()) part = "";
    } else if (part.is_structured()) {
      part = shape_of(part);
    }
  }
  return value;
}

}  // namespace enfilade::arena::testing
