#include "bench/peer/remap.h"

namespace enfilade::bench {

std::vector<render::View> face_views(ScanIndex /*scan*/, ViewpointIndex /*viewpoint*/) {
  return {};
}

std::unique_ptr<Remap> make_remap(const Camera& /*camera*/, std::uint32_t /*face_size*/) {
  return nullptr;
}

std::string remap_description() {
  return "OpenCV's remap: left out, as this build found no OpenCV (libopencv-dev)";
}

bool remap_built() { return false; }

}  // namespace enfilade::bench
