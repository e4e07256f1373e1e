/// \file  Scans as the viewer and the API show them.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "enfilade/service/site.h"

namespace enfilade::service::browsing {

/// All scans, with their numbers of viewpoints and edges.
nlohmann::ordered_json scan_list_json(const Site& site);
/// Storeys, viewpoints with their neighbours, and which pictures there are of each.
nlohmann::ordered_json scan_json(const Site& site, ScanIndex scan);

}  // namespace enfilade::service::browsing
