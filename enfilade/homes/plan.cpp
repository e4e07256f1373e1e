#include "enfilade/homes/plan.h"

#include <fmt/format.h>

#include "enfilade/homes/plan/draws.h"

namespace enfilade::homes {

std::string to_string(HomeKind kind) {
  switch (kind) {
    case HomeKind::kHouse:
      return "house";
    case HomeKind::kFlat:
      return "flat";
    case HomeKind::kOffice:
      return "office";
    case HomeKind::kHotelFloor:
      return "hotel";
  }
  return "house";
}

void check_options(const PlanOptions& o) {
  const auto check = [](bool good, const std::string& message) {
    if (!good) throw ArgumentError(message);
  };
  check(o.area == 0 || (o.area >= kLeastArea && o.area <= kMostArea),
        fmt::format("area: {} m2, not from {} to {}, or 0", o.area, kLeastArea, kMostArea));
  if (!o.storeys) return;
  check(*o.storeys >= 1 && *o.storeys <= 3,
        fmt::format("storeys: {}, not from 1 to 3", *o.storeys));
  const bool one = o.kind == HomeKind::kFlat || o.kind == HomeKind::kHotelFloor;
  check(!one || *o.storeys == 1,
        fmt::format("storeys: {}, but flats and hotel floors have 1", *o.storeys));
  check(o.area == 0 || *o.storeys == 1 || o.area >= plan::kLeastWithStairs * *o.storeys,
        fmt::format("area: {} m2 are too few for {} storeys of at least {} m2", o.area, *o.storeys,
                    plan::kLeastWithStairs));
}

Plan make_plan(const PlanOptions& options) {
  // Of 4,500 homes of all kinds and sizes, each had a plan within 1,000.
  constexpr unsigned kMostDraws = 20000;
  return plan::make_plan(options, kMostDraws);
}

}  // namespace enfilade::homes
