/// \file  Goals of episodes, one kind per family of benchmarks. Twice: with the names of a file,
/// and looked up in a graph.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"

namespace enfilade::tasks {

/// The benchmarks. Their names: name_of() (files.h).
enum class Task : std::uint8_t { kR2r, kR2rLast, kR2rBack, kR4r, kRxr, kReverie, kCvdn, kSoon };

/// The goal is not in the file: test splits.
struct HiddenGoal {
  friend bool operator==(const HiddenGoal&, const HiddenGoal&) = default;
};
/// To stop near the last viewpoint of the reference path: R2R, R2R-Last, R4R, RxR. With a path of
/// one viewpoint, which test splits have, it is hidden.
struct NearEnd {
  friend bool operator==(const NearEnd&, const NearEnd&) = default;
};

/// A direction in a viewpoint's panorama, world frame.
struct Direction {
  Radians heading;    ///< as in the file; SOON has [0, 2 pi)
  Radians elevation;  ///< from the horizon, up positive
  friend bool operator==(const Direction&, const Direction&) = default;
};

/// \name Goals with the names of a file
/// @{

/// R2R-Back: reach a turning point, report it, and return.
struct NamedTurningPoint {
  std::string viewpoint;
  friend bool operator==(const NamedTurningPoint&, const NamedTurningPoint&) = default;
};
/// REVERIE: to end where the object is seen, and to name it.
struct NamedObject {
  std::int64_t id = 0;
  /// `pos_vps`: the viewpoints that see it, if the file names them, as HM3DAutoVLN's does. Empty:
  /// ObjectBoxes have them.
  std::vector<std::string> seen_from = {};
  friend bool operator==(const NamedObject&, const NamedObject&) = default;
};
/// CVDN: to come nearer to any viewpoint of a region.
struct NamedRegion {
  std::string target;                   ///< the searched object: "plant"
  std::vector<std::string> viewpoints;  ///< `end_panos`; not empty
  std::vector<std::string> player;      ///< `player_path`: the navigator's next steps; may be empty
  std::vector<std::string> planner;     ///< `planner_path`: what the oracle saw; may be empty
  friend bool operator==(const NamedRegion&, const NamedRegion&) = default;
};
/// SOON: an object in a viewpoint's panorama, as a quadrilateral on the sphere.
struct NamedBox {
  std::string viewpoint;
  std::string object;
  Direction centre;
  std::array<Direction, 4> corners;  ///< left top, right top, right bottom, left bottom
  friend bool operator==(const NamedBox&, const NamedBox&) = default;
};
/// SOON: to end at a viewpoint that has a box, and to point into it.
struct NamedBoxes {
  std::vector<NamedBox> boxes;  ///< in the order of the file; one viewpoint may have several.
  /// The path that the released scorer compares with: the first of its item's alternatives that
  /// begin where this one does. Empty: this one.
  std::vector<std::string> first_alternative;
  friend bool operator==(const NamedBoxes&, const NamedBoxes&) = default;
};
/// Any of them.
using NamedGoal =
    std::variant<NearEnd, HiddenGoal, NamedTurningPoint, NamedObject, NamedRegion, NamedBoxes>;
/// @}

/// \name Goals looked up in a graph
/// @{

/// R2R-Back's, as NamedTurningPoint.
struct TurningPoint {
  ViewpointIndex viewpoint;
};
/// REVERIE's, as NamedObject, with the viewpoints that see it.
struct SeenObject {
  std::int64_t id = 0;
  std::vector<ViewpointIndex> seen_from;  ///< ascending; empty if no viewpoint sees it
};
/// CVDN's, as NamedRegion.
struct Region {
  std::vector<ViewpointIndex> viewpoints;       ///< not empty
  std::vector<ViewpointIndex> player, planner;  ///< as NamedRegion
};
/// One of SOON's, as NamedBox.
struct Box {
  ViewpointIndex viewpoint;
  Direction centre;
  std::array<Direction, 4> corners;  ///< as NamedBox
  std::string object = {};           ///< its name, "vase"; empty if the file has none
};
/// SOON's, as NamedBoxes.
struct Boxes {
  std::vector<Box> boxes;
  std::vector<ViewpointIndex> first_alternative;  ///< as NamedBoxes
};
/// Any of them.
using Goal = std::variant<NearEnd, HiddenGoal, TurningPoint, SeenObject, Region, Boxes>;
/// @}

}  // namespace enfilade::tasks
