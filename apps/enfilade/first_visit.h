/// \file  What `enfilade serve` shows on a machine that has no data set: model homes, with two
/// agents on their leaderboard.
#pragma once
#include <filesystem>

#include "enfilade/service/server.h"
#include "enfilade/service/site.h"

namespace enfilade::apps {

/// A folder of SYNTHETIC model homes below the current one: those of `enfilade demo` if they are
/// there, else two that are made now, with pictures of 512 texels and instructions. Says so on
/// stdout, and shows progress on a terminal. What a killed run has made is kept.
/// \throws as homes::write_homes(), homes::write_home_paths()
std::filesystem::path make_first_homes();

/// Submits, for each phase, what two agents that learn nothing did: the shortest path, which knows
/// the goals, and Room-to-Room's random walk. As teams do, over HTTP, so that the leaderboard is a
/// real one; returns when they are scored. Done again, it changes nothing.
/// \param data  of `site`  \param server "http://127.0.0.1:8080"
/// \throws Error if the server refuses them; errors of the data set's files
void submit_first_agents(const std::filesystem::path& data, const service::Site& site,
                         const std::string& database, const std::string& server);

}  // namespace enfilade::apps
