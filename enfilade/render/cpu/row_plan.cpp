#include "enfilade/render/cpu/row_plan.h"

namespace enfilade::render::cpu {

ViewPlan::ViewPlan(const PixelRays& rays) : rays_(plain(rays)) {
  for (std::uint32_t k = 0; k < pixels::kCrossings; ++k) {
    if (pixels::find_crossing(rays_, k, crossings_[count_])) ++count_;
  }
}

}  // namespace enfilade::render::cpu
