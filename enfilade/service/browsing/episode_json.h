/// \file  One episode with all that is known of it: turns, timed words, the goal and its outlines.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "enfilade/service/site.h"

namespace enfilade::service::browsing {

/// An instruction as lists of episodes have it: id, path, text, language.
nlohmann::ordered_json brief_episode_json(const tasks::PathAnnotation& path, std::size_t k);

/// The same with the dialogue's turns, timed words, pieces and named parts, as far as there are
/// any, and with `trace` and `goal`. `trace` has a guide's views in time (RxR), if its file is in
/// the folder pose_traces/ beside the annotations (`trace_problem` if that cannot be read). Trace
/// and goal are absent if goals are hidden.
///
/// A goal is {"kind": "end" | "turning_point" | "object" | "region" | "boxes", "name",
/// "viewpoints", "outlines"}. An outline is {"viewpoint", "label", "rim"}: headings and elevations
/// alternating, radians, of a closed line around the goal's object.
/// \pre path is one of the split's, which is one of the site's
nlohmann::ordered_json whole_episode_json(const Site& site, const PublicSplit& split,
                                          const tasks::PathAnnotation& path, std::size_t k);

}  // namespace enfilade::service::browsing
