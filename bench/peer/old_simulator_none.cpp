#include "bench/peer/old_simulator.h"

namespace enfilade::bench {

std::unique_ptr<OldSimulator> make_old_simulator(const OldWalk& /*walk*/) { return nullptr; }

std::string old_simulator_description() {
  return "old simulator: left out, as this build was not given its sources "
         "(-DEN_PEER_MATTERSIM=DIR)";
}

bool old_simulator_built() { return false; }

}  // namespace enfilade::bench
