// What the connectivity reader accepts, the graph, its checker and the writer must take.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/scan/connectivity.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const scan::Connectivity c = scan::parse_connectivity(text, "fuzz", "<fuzz>");
    graph::check_graph(c);
    const graph::NavGraph graph(c);
    for (std::size_t i = 0; i < graph.size(); ++i) {
      EN_CHECK_EQ(graph.distance(ViewpointIndex(i), ViewpointIndex(i)), 0.0);
      graph.nearest(graph.position(ViewpointIndex(i)));
    }
    const std::string written = to_json(c);
    EN_CHECK_EQ(to_json(scan::parse_connectivity(written, "fuzz", "<fuzz>")), written);
  } catch (const Error&) {
  }
  return 0;
}
