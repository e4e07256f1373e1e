/// \file  Success in unseen buildings by the number of training buildings: a curve and its page.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/tasks/bootstrap.h"

namespace enfilade::report {

/// One trained agent, scored in buildings that it was not trained in.
struct CurvePoint {
  std::size_t buildings = 0;  ///< trained in, >= 1
  std::uint64_t seed = 1;
  tasks::MeanInterval success;  ///< shares
  tasks::MeanInterval spl;      ///< likewise
};

/// A curve, with its explanations.
struct ScalingCurve {
  std::string title;
  bool synthetic = false;  ///< synthetic homes: noted on the picture
  std::vector<CurvePoint> points;
  std::optional<tasks::MeanInterval> random;  ///< success of the Random agent; a share
  /// Named facts below the curve, in order, such as {"iterations", "2000"}.
  std::vector<std::pair<std::string, std::string>> facts;
};

/// Success in per cent over the number of buildings, whose axis is logarithmic. A dot per agent
/// with its interval, and the line through the means of the seeds.
/// \throws ArgumentError for no point, or one without a building
std::string scaling_curve_svg(const ScalingCurve& curve);

/// One HTML document with the curve, a table of its points and the facts; needs no other file.
/// \throws as scaling_curve_svg()
std::string scaling_curve_page(const ScalingCurve& curve);

}  // namespace enfilade::report
