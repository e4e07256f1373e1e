/// \file  Two sets of paths side by side: how near drawn paths come to R2R's own.
#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/statistics.h"

namespace enfilade::tasks {

/// Properties of a set's paths with known goals, and signs of the rule by which they were drawn.
struct PathFacts {
  std::size_t paths = 0;
  std::size_t buildings = 0;
  std::size_t most_in_a_building = 0;
  std::size_t buildings_with_most = 0;
  Summary length;                             ///< metres along the path
  std::map<std::size_t, std::size_t> edges;   ///< number of edges -> paths
  std::map<std::size_t, std::size_t> metres;  ///< k -> paths of length [2 k, 2 k + 2) m
  std::size_t not_shortest = 0;  ///< longer than the shortest path by more than a millimetre

  std::size_t between_rooms = 0;  ///< start and goal in different regions of the map
  std::size_t in_one_room = 0;
  std::size_t outside_map = 0;     ///< start or goal in no region of the map
  std::size_t repeated_pairs = 0;  ///< of between_rooms: the ordered pair of rooms came before
  std::size_t to_nearest = 0;      ///< of between_rooms: no viewpoint of the goal's room is nearer
};

/// How far apart two sets of paths are.
struct PathDistance {
  TwoSample length;
  TwoSample edges;
};

/// Two sets of paths side by side, and how far apart their distributions are.
struct PathComparison {
  PathFacts drawn;
  PathFacts drawn_there;  ///< the drawn paths in the buildings that the reference has
  PathFacts reference;
  PathDistance all;                           ///< drawn against the reference
  PathDistance there;                         ///< drawn_there against it
  std::optional<PathDistance> between_rooms;  ///< likewise, those between different rooms only
};

/// \throws ArgumentError if the two sets have no building in common; as look_up_paths()
PathComparison compare_paths(const Annotations& drawn, std::span<const Annotations> reference,
                             const graph::GraphSet& graphs, const scan::RegionMap& regions);

/// Facts a line, the three sets in columns, then histograms and the distances between them.
std::string to_table(const PathComparison& comparison);

}  // namespace enfilade::tasks
