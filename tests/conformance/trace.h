/// \file  Recorded runs of MatterSim: a header line, then a line for each state, as JSON.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::tests {

/// The first line.
struct TraceHeader {
  std::map<std::string, sim::SimulatorConfig> configs;  ///< by the name that steps use
};

/// An episode begins.
struct TraceStart {
  std::string viewpoint;
  double heading = 0, elevation = 0;
};

/// One row of a navigable list; row 0 is the present viewpoint.
struct TraceNavigable {
  std::string viewpoint;
  std::int64_t ix = 0;
  double rel_heading = 0, rel_elevation = 0, distance = 0;
};

/// What MatterSim said that it was in.
struct TraceState {
  std::string scan, viewpoint;
  std::int64_t step = 0, ix = 0, view_index = 0;
  double x = 0, y = 0, z = 0, heading = 0, elevation = 0;
  std::vector<TraceNavigable> navigable;
};

/// A line: what was done, and the state after it.
struct TraceStep {
  std::size_t line = 0;  ///< of the file, from 1
  std::string scan;
  std::string config;
  std::variant<TraceStart, sim::Action> action;
  TraceState state;
};

/// Reads a trace line by line, compressed with gzip or not. Both interfaces of MatterSim, v0.1 and
/// v0.2, are recorded in this form. Each function throws FileError if the file cannot be read or
/// its compressed data ends early, InvalidInput naming file, line and JSON path if a line is
/// broken.
class TraceReader {
 public:
  explicit TraceReader(const std::filesystem::path& path);
  ~TraceReader();
  TraceReader(TraceReader&&) noexcept;
  TraceReader& operator=(TraceReader&&) noexcept;

  const TraceHeader& header() const noexcept { return header_; }
  /// Nothing at the end.
  std::optional<TraceStep> next();

 private:
  class Lines;
  std::unique_ptr<Lines> lines_;
  TraceHeader header_;
};

}  // namespace enfilade::tests
