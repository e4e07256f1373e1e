/// \file  `enfilade serve` without a data set: synthetic homes, with two agents on their
/// leaderboard.
#pragma once
#include <filesystem>

#include "enfilade/service/server.h"
#include "enfilade/service/site.h"

namespace enfilade::apps {

/// A folder of synthetic homes below the current one. Those of `enfilade demo` if they are there,
/// else two that are made now, with pictures of 512 texels and instructions. Reports that on
/// stdout, with progress on a terminal. Files of a killed run are kept.
/// \throws as homes::write_homes(), homes::write_home_paths()
std::filesystem::path make_first_homes();

/// Submits, for each phase, results of two agents that learn nothing: the shortest path, an oracle,
/// and Room-to-Room's random agent. It sends them over HTTP, as teams do, so that the leaderboard
/// is a real one. Returns when they are scored. A repeated call changes nothing.
/// \param data  of `site`
/// \param server "http://127.0.0.1:8080"
/// \throws Error if the server refuses them; errors of the data set's files
void submit_first_agents(const std::filesystem::path& data, const service::Site& site,
                         const std::string& database, const std::string& server);

}  // namespace enfilade::apps
