#include "enfilade/homes/plan.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>

#include "enfilade/homes/plan/draws.h"

namespace enfilade::homes {

namespace {

// In the order of HomeKind.
constexpr std::array<std::string_view, 4> kKinds{"house", "flat", "office", "hotel"};

}  // namespace

std::string to_string(HomeKind kind) {
  return std::string(kKinds.at(static_cast<std::size_t>(kind)));
}

std::optional<HomeKind> parse_home_kind(std::string_view name) {
  const auto found = std::ranges::find(kKinds, name);
  if (found == kKinds.end()) return std::nullopt;
  return static_cast<HomeKind>(found - kKinds.begin());
}

std::vector<std::string> home_kinds() { return {kKinds.begin(), kKinds.end()}; }

void check_options(const PlanOptions& o) {
  const auto check = [](bool good, const std::string& message) {
    if (!good) throw ArgumentError(message);
  };
  check(o.area == 0 || (o.area >= kLeastArea && o.area <= kMostArea),
        fmt::format("area: {} m2, not from {} to {}, or 0", o.area, kLeastArea, kMostArea));
  if (!o.storeys) return;
  check_range("storeys", *o.storeys, 1, 3);
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
