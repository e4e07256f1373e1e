/// \file  The rooms and walls of a building, for the viewer's map and doll's house.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "enfilade/service/site.h"

namespace enfilade::service::browsing {

/// A scan's rooms, walls and furniture: of a synthetic home from `homes.json`, of a scanned mesh
/// from its `.house` file; else empty lists. World frame, metres.
/// \throws FileError, InvalidInput for a broken file
nlohmann::ordered_json plan_json(const Site& site, ScanIndex scan);

}  // namespace enfilade::service::browsing
