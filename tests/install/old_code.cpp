// Code of the old simulator, by the installed header: walks the corridor whose files it writes into
// the folder that it is given.
#include <MatterSim.hpp>

#include <cstdio>
#include <fstream>
#include <string>

namespace {

std::string entry(const char* id, const char* y, const char* unobstructed) {
  return std::string(R"({"image_id":")") + id + R"(","pose":[1,0,0,0, 0,1,0,)" + y +
         R"(, 0,0,1,1.5, 0,0,0,1],"included":true,"height":1.5,"visible":)" + unobstructed +
         R"(,"unobstructed":)" + unobstructed + "}";
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) return 2;
  const std::string folder = words[1];
  std::ofstream(folder + "/scans.txt") << "corridor\n";
  std::ofstream(folder + "/corridor_connectivity.json")
      << "[" << entry("a", "0", "[false,true,false]") << "," << entry("b", "3", "[true,false,true]")
      << "," << entry("c", "7", "[false,true,false]") << "]";
  mattersim::Simulator simulator;
  simulator.setNavGraphPath(folder);
  simulator.setRenderingEnabled(false);
  simulator.newEpisode({"corridor"}, {"a"}, {0}, {0});
  const mattersim::SimStatePtr state = simulator.getState().at(0);
  for (int step = 0; step < 2; ++step) {
    const auto last = static_cast<unsigned int>(state->navigableLocations.size() - 1);
    simulator.makeAction({last}, {0}, {0});
  }
  std::printf("%s after %u steps\n", state->location->viewpointId.c_str(), state->step);
}
