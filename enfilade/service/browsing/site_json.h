/// \file  Scans, splits and episodes as the viewer and the API show them to everybody.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "enfilade/service/site.h"

namespace enfilade::service::browsing {

/// All scans, with their numbers of viewpoints, edges, storeys, instructions and rooms.
nlohmann::ordered_json scan_list_json(const Site& site);
/// Storeys, viewpoints with their neighbours, and which pictures there are of each.
nlohmann::ordered_json scan_json(const Site& site, ScanIndex scan);

/// Which episodes of a split. An empty text matches all.
struct EpisodeFilter {
  std::string scan;
  std::string words;  ///< part of the instruction, in any case
  std::string id;     ///< of the instruction: "12_0"
  std::int64_t offset = 0, limit = 50;
};

/// Those of a benchmark; without one, of all.
nlohmann::ordered_json split_list_json(const Site& site, std::optional<tasks::Task> task);
/// A page of the episodes that match, and how many there are. With an id: all that is known of it
/// (episode_json.h). \pre the split is one of the site's
nlohmann::ordered_json episodes_json(const Site& site, const PublicSplit& split,
                                     const EpisodeFilter& filter);

}  // namespace enfilade::service::browsing
