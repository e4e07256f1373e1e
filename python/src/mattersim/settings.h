/// \file  A Simulator's settings, as old code sets them, and options for the old simulator's
/// defects.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/sim/simulator.h"

namespace enfilade::python::mattersim {

/// The interface that old code uses.
enum class Api : std::uint8_t { kUnknown, kV1, kV2 };

struct Settings {
  std::string dataset_path;  ///< empty: the default of the interface
  std::string nav_graph_path = "./connectivity";
  bool rendering = true;
  bool discretized = false;
  bool restricted = true;
  bool preloading = false;
  bool depth = false;
  std::int64_t width = 320, height = 240;
  double vertical_field_of_view = 0.8;  ///< radians
  sim::ElevationLimits limits;
  std::size_t batch_size = 1;
  std::size_t cache_panoramas = 200;
};

/// Defects of the old simulator to reproduce, and corrections to switch on: words in the
/// environment variable ENFILADE_MATTERSIM. See docs/python_mattersim.md.
struct Options {
  bool eight_bit_depth = false;   ///< "8bit-depth"
  bool smooth_edges = false;      ///< "smooth-edges"
  bool perspective_view = false;  ///< "perspective-fov"
  bool uniform_starts = false;    ///< "uniform-starts"
  bool one_stream = false;        ///< "one-stream"
  bool shared_cache = false;      ///< "shared-cache"

  /// \throws ArgumentError for an unknown word
  static Options from_environment();
};

}  // namespace enfilade::python::mattersim
