/// \file  Doing again what a trace did, and comparing.
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/sim/simulator.h"
#include "tests/conformance/trace.h"

namespace enfilade::tests {

/// One value that came out otherwise.
struct Mismatch {
  std::string field;     ///< "nav[1].rel_heading"
  std::string expected;  ///< the trace's
  std::string got;       ///< ours
};

/// What became of one state.
struct Comparison {
  std::vector<Mismatch> mismatches;  ///< empty: the same within the tolerance
  bool identical = true;             ///< every real number to the last bit as well
};

/// Replays the steps of one trace in order, on one Simulator per configuration.
class Replay {
 public:
  /// `tolerance`: how far real numbers may be off. Ids, indices and order may not at all.
  Replay(std::shared_ptr<const graph::GraphSet> graphs, const TraceHeader& header,
         double tolerance);

  /// An action that the simulator refuses is a mismatch.
  /// \throws LookupError for a scan or start viewpoint that the data set doesn't have; FileError,
  /// InvalidInput for its files
  Comparison compare(const TraceStep& step);

 private:
  struct Body {
    sim::Simulator simulator;
    sim::StateBuffer buffer;
  };
  void act(Body& body, const TraceStep& step) const;

  std::shared_ptr<const graph::GraphSet> graphs_;
  double tolerance_;
  std::map<std::string, Body> bodies_;  // by configuration
};

}  // namespace enfilade::tests
