#include "enfilade/homes/plan.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/homes/plan/draws.h"
#include "tests/support/refusal.h"

namespace enfilade::homes {
namespace EN_UNIT {

std::string text_of(const Plan& plan) {
  std::string text;
  const auto add = [&](double x) { text += std::to_string(std::llround(x * 1e6)) + " "; };
  for (const PlanRoom& r : plan.rooms) {
    text += r.name + " ";
    for (const double x : {r.floor.x0, r.floor.y0, r.floor.x1, r.floor.y1, r.ceiling}) add(x);
  }
  for (const Opening& o : plan.openings) {
    for (const double x : {o.wall, o.from, o.to, o.sill, o.head, o.leaf}) add(x);
  }
  return text;
}

void expect_sound(const PlanOptions& options) {
  const Plan plan = make_plan(options);
  for (const std::string& fault : plan::plan_faults(plan)) {
    ADD_FAILURE() << "seed " << options.seed << ", " << enum_name(plan.kind) << ", " << options.area
                  << " m2: " << fault;
  }
}

TEST(Plan, IsSoundForThousandSeedsOfEachKind) {
  for (const auto kind :
       {HomeKind::kHouse, HomeKind::kFlat, HomeKind::kOffice, HomeKind::kHotelFloor}) {
    for (std::uint64_t seed = 0; seed < 1000; ++seed) expect_sound({seed, kind, {}, 0});
  }
}

TEST(Plan, IsSoundForAllAreasAndStoreys) {
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    for (const double area :
         {60.0, 75.0, 110.0, 160.0, 190.0, 240.0, 400.0, 700.0, 1200.0, 3000.0}) {
      for (unsigned kind = 0; kind < 4; ++kind) {
        expect_sound({seed, static_cast<HomeKind>(kind), {}, area});
      }
      for (unsigned storeys = 2; storeys <= 3 && area >= 85 * storeys; ++storeys) {
        expect_sound({seed, HomeKind::kHouse, storeys, area});
        expect_sound({seed, HomeKind::kOffice, storeys, area});
      }
    }
  }
}

TEST(Plan, KeepsToOptions) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Plan plan = make_plan({seed, HomeKind::kHouse, 2, 260});
    EXPECT_EQ(plan.kind, HomeKind::kHouse);
    EXPECT_EQ(plan.seed, seed);
    EXPECT_EQ(plan.storeys.size(), 2U);
    EXPECT_EQ(plan.stairs.size(), 1U);
    // Walls lie on a grid of 5 cm, and the outline's area is that of middle lines made larger.
    EXPECT_NEAR(2 * plan.outline.area(), 260, 260 * 0.03);
  }
}

TEST(Plan, SameSeedGivesSamePlanAndOthersDiffer) {
  std::set<std::string> seen;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::string text = text_of(make_plan({seed, {}, {}, 0}));
    EXPECT_EQ(text, text_of(make_plan({seed, {}, {}, 0})));
    seen.insert(text);
  }
  EXPECT_EQ(seen.size(), 200U);
}

TEST(Plan, UsesManyRoomTypesKindsAndStoreys) {
  std::set<char> types;
  std::set<HomeKind> kinds;
  std::set<std::size_t> storeys;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Plan plan = make_plan({seed, {}, {}, 0});
    kinds.insert(plan.kind);
    storeys.insert(plan.storeys.size());
    for (const PlanRoom& room : plan.rooms) types.insert(room.type);
  }
  EXPECT_GE(types.size(), 18U);
  EXPECT_EQ(kinds.size(), 4U);
  EXPECT_EQ(storeys.size(), 3U);
}

TEST(Plan, HomesHaveWhatPeopleNeed) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    for (const auto kind : {HomeKind::kHouse, HomeKind::kFlat}) {
      const Plan plan = make_plan({seed, kind, {}, 0});
      for (const char type : {'l', 'k', 'b', 'a', 'e'}) {
        EXPECT_TRUE(std::any_of(plan.rooms.begin(), plan.rooms.end(),
                                [&](const PlanRoom& r) { return r.type == type; }))
            << "no " << type << " with seed " << seed;
      }
    }
  }
}

TEST(Plan, FaultsAreFound) {
  const Plan good = make_plan({5, HomeKind::kHouse, 2, 240});
  ASSERT_TRUE(plan::plan_faults(good).empty());
  Plan moved = good;
  moved.rooms.back().floor.x0 -= 0.3;
  EXPECT_FALSE(plan::plan_faults(moved).empty());
  Plan closed = good;
  std::erase_if(closed.openings, [](const Opening& o) { return o.room1.has_value(); });
  EXPECT_FALSE(plan::plan_faults(closed).empty());
  Plan dark = good;
  std::erase_if(dark.openings, [](const Opening& o) { return o.kind == OpeningKind::kWindow; });
  EXPECT_FALSE(plan::plan_faults(dark).empty());
  Plan steep = good;
  steep.stairs[0].steps = 9;
  EXPECT_FALSE(plan::plan_faults(steep).empty());
  Plan apart = good;
  apart.stairs.clear();
  EXPECT_FALSE(plan::plan_faults(apart).empty());
}

TEST(Plan, SaysSoIfNoDrawWorksOut) {
  const PlanOptions options{7, HomeKind::kHouse, 3U, 300};
  EXPECT_EQ(tests::refusal<NoPlan>([&] { plan::make_plan(options, 1); }),
            "no plan of a house of 300 m2 on 3 storeys with seed 7: rooms, doors and stairs fitted "
            "in none of 1 draws. Take another seed or more area, 3000 m2 at most");
  // What the first draws give stays with more of them to come.
  EXPECT_EQ(text_of(plan::make_plan(options, 1000)), text_of(make_plan(options)));
}

TEST(Plan, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(make_plan({1, {}, {}, 59}), ArgumentError);
  EXPECT_THROW(make_plan({1, {}, {}, 3001}), ArgumentError);
  EXPECT_THROW(make_plan({1, {}, {}, std::nan("")}), ArgumentError);
  EXPECT_THROW(make_plan({1, {}, 0U, 0}), ArgumentError);
  EXPECT_THROW(make_plan({1, {}, 4U, 0}), ArgumentError);
  EXPECT_THROW(make_plan({1, HomeKind::kFlat, 2U, 0}), ArgumentError);
  EXPECT_THROW(make_plan({1, HomeKind::kHouse, 3U, 250}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes
