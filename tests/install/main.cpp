// Walks a building of three viewpoints by the installed library: a reader, the graph, and what
// they link (simdjson, nanoflann, oneTBB) have to be found by find_package(enfilade) alone.
#include <cstdio>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/scan/connectivity.h"

namespace {

// A corridor along world +y: a (0 m) - b (3 m) - c (7 m).
std::string entry(const char* id, const char* y, const char* unobstructed) {
  return std::string(R"({"image_id":")") + id + R"(","pose":[1,0,0,0, 0,1,0,)" + y +
         R"(, 0,0,1,1.5, 0,0,0,1],"included":true,"height":1.5,"visible":)" + unobstructed +
         R"(,"unobstructed":)" + unobstructed + "}";
}

std::string corridor() {
  return "[" + entry("a", "0", "[false,true,false]") + "," + entry("b", "3", "[true,false,true]") +
         "," + entry("c", "7", "[false,true,false]") + "]";
}

}  // namespace

int main() {
  using namespace enfilade;
  const graph::NavGraph graph(scan::parse_connectivity(corridor(), "corridor", "<memory>"));
  const auto path = graph.path(ViewpointIndex(0), ViewpointIndex(2));
  if (!path) return 1;
  for (const ViewpointIndex v : *path) std::printf("%s ", graph.id(v).c_str());
  std::printf("%.1f m\n", graph.distance(ViewpointIndex(0), ViewpointIndex(2)));
  try {
    scan::parse_connectivity("[", "broken", "<memory>");
  } catch (const InvalidInput& error) {  // exceptions have to cross the library's edge
    std::printf("%zu fault\n", error.diagnostics().size());
  }
}
