#include "enfilade/render/cpu/row_plan.h"

namespace enfilade::render::cpu {

ViewPlan::ViewPlan(const PixelRays& rays) : rays_(plain(rays)) {
  for (std::uint32_t k = 0; k < pixels::kCrossings; ++k) {
    crossings_[k] = pixels::find_crossing(rays_, k);
  }
}

}  // namespace enfilade::render::cpu
