#include "enfilade/homes/plan/draws.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "enfilade/core/enum_names.h"

namespace enfilade::homes::plan {
namespace {

constexpr double kHighestRise = 0.185, kGoing = 0.262;  // of steps, metres
constexpr double kSlab = 0.3;  // from the highest ceiling to the next floor

// What a plan is drawn from, once the options' gaps are filled.
struct Brief {
  HomeKind kind = HomeKind::kHouse;
  unsigned storeys = 1;
  double area = 100;             // of all storeys
  std::vector<double> ceilings;  // usual height of each storey
  std::vector<PlanStorey> levels;
  unsigned most_steps = 16;
};

unsigned steps_of(const PlanStorey& storey) {
  return static_cast<unsigned>(std::ceil(storey.height / kHighestRise));
}

HomeKind draw_kind(const PlanOptions& o, Rng& rng) {
  if (o.kind) return *o.kind;
  const double pick = rng.uniform();
  const bool one = !o.storeys || *o.storeys == 1;
  if (pick < 0.62 || (!one && pick < 0.82)) return HomeKind::kHouse;
  if (pick < 0.78 && one) return HomeKind::kFlat;
  return pick < 0.9 || !one ? HomeKind::kOffice : HomeKind::kHotelFloor;
}

unsigned draw_storeys(const PlanOptions& o, HomeKind kind, Rng& rng) {
  if (o.storeys) return *o.storeys;
  const double pick = rng.uniform();
  if (kind == HomeKind::kFlat || kind == HomeKind::kHotelFloor) return 1;
  const double area = o.area;
  if (area == 0) return pick < 0.3 ? 1 : pick < 0.85 ? 2 : 3;
  if (area < 2 * kLeastWithStairs) return 1;
  if (area < 3 * kLeastWithStairs) return pick < 0.35 ? 1 : 2;
  if (area < 400) return pick < 0.2 ? 1 : pick < 0.8 ? 2 : 3;
  return pick < 0.1 ? 1 : pick < 0.55 ? 2 : 3;
}

double draw_area(HomeKind kind, unsigned storeys, Rng& rng) {
  switch (kind) {
    case HomeKind::kHouse:
      return storeys == 1 ? draw(rng, 85, 160) : storeys * draw(rng, 86, storeys == 2 ? 125 : 110);
    case HomeKind::kFlat:
      return draw(rng, 70, 140);
    case HomeKind::kOffice:
      return storeys * draw(rng, 120, 280);
    case HomeKind::kHotelFloor:
      break;
  }
  return draw(rng, 280, 560);
}

void draw_heights(Brief& brief, Rng& rng) {
  const bool office = brief.kind == HomeKind::kOffice;
  double floor = 0;
  for (unsigned s = 0; s < brief.storeys; ++s) {
    const double ceiling = snap(office ? draw(rng, 2.65, 3.05) : draw(rng, 2.45, 2.8));
    const double height = snap(ceiling + draw(rng, 0.05, 0.2) + kSlab);
    brief.ceilings.push_back(ceiling);
    brief.levels.push_back({floor, height});
    floor += height;
  }
  brief.most_steps = 0;
  for (unsigned s = 0; s + 1 < brief.storeys; ++s) {
    brief.most_steps = std::max(brief.most_steps, steps_of(brief.levels[s]));
  }
}

// Turns the building so that its front, drawn at y = 0, comes to any side; and to the middle of the
// world.
class Turning {
 public:
  Turning(const BuildingFrame& b, Rng& rng)
      : width_(b.width),
        depth_(b.depth),
        mirrored_(chance(rng, 0.5)),
        upside_(chance(rng, 0.5)),
        swapped_(chance(rng, 0.5)) {}
  Rect operator()(Rect r) const {
    if (mirrored_) r = {width_ - r.x1, r.y0, width_ - r.x0, r.y1};
    if (upside_) r = {r.x0, depth_ - r.y1, r.x1, depth_ - r.y0};
    const double dx = snap(width_ / 2), dy = snap(depth_ / 2);
    r = {snap2(r.x0 - dx), snap2(r.y0 - dy), snap2(r.x1 - dx), snap2(r.y1 - dy)};
    return swapped_ ? Rect{r.y0, r.x0, r.y1, r.x1} : r;
  }
  Side operator()(Side side) const {
    if (faces_x(side) ? mirrored_ : upside_) side = opposite(side);
    return swapped_ ? mirrored_at_diagonal(side) : side;
  }

 private:
  static Side mirrored_at_diagonal(Side side) {
    constexpr std::array kSwapped{Side::kPlusY, Side::kPlusX, Side::kMinusY, Side::kMinusX};
    return kSwapped[index(side)];
  }
  // Middle lines that were equal stay equal after mirroring: a tenth of a millimetre.
  static double snap2(double x) { return std::round(x * 1e4) / 1e4; }
  double width_, depth_;
  bool mirrored_, upside_, swapped_;
};

double draw_ceiling(char type, double usual, double highest, Rng& rng) {
  if (is_one_of(type, "lndrmkf")) return std::min({3.4, highest, snap(usual + draw(rng, 0, 0.2))});
  if (is_one_of(type, "atcjuzg")) return std::max(2.4, snap(usual - draw(rng, 0, 0.25)));
  if (is_one_of(type, "he")) return std::max(2.4, snap(usual - draw(rng, 0, 0.12)));
  return usual;
}

void add_rooms(const Sketch& sketch, const std::vector<unsigned>& storey_of, const Brief& brief,
               Plan& plan, Rng& rng) {
  const Rect& m = sketch.middle;
  const double half = plan.inner_wall / 2, outer = plan.outer_wall / 2;
  const auto inset = [&](double at, double edge) {
    return std::abs(at - edge) < 1e-6 ? outer : half;
  };
  for (std::size_t c = 0; c < sketch.cells.size(); ++c) {
    const Cell& cell = sketch.cells[c];
    const Rect& b = cell.box;
    const unsigned s = storey_of[c];
    PlanRoom room;
    room.type = cell.type;
    room.name = cell.name;
    room.storey = s;
    room.floor = {b.x0 + inset(b.x0, m.x0), b.y0 + inset(b.y0, m.y0), b.x1 - inset(b.x1, m.x1),
                  b.y1 - inset(b.y1, m.y1)};
    room.ceiling = draw_ceiling(cell.type, brief.ceilings[s], brief.levels[s].height - kSlab, rng);
    plan.rooms.push_back(std::move(room));
  }
}

void add_stairs(const Sketch& sketch, const Brief& brief, Plan& plan) {
  if (!sketch.flight) return;
  const auto stair_room = [&](unsigned storey) {
    std::size_t r = 0;
    while (plan.rooms[r].type != 's' || plan.rooms[r].storey != storey) ++r;
    return r;
  };
  for (unsigned s = 0; s + 1 < brief.storeys; ++s) {
    plan.stairs.push_back({s, stair_room(s), stair_room(s + 1), sketch.flight->box,
                           sketch.flight->towards, steps_of(brief.levels[s])});
  }
}

struct Scored {
  Plan plan;
  double score = 0;
};

std::optional<Scored> draw_plan(const Brief& brief, Rng& rng) {
  const double run = snap(brief.most_steps * kGoing + 0.02);
  // Middle lines enclose less than the outline by half an outer wall all round.
  const double storey_area = brief.area / brief.storeys;
  const double inner_area = storey_area - 2 * std::sqrt(storey_area) * kOuterWall;
  const auto building = draw_building({brief.kind, brief.storeys, inner_area, run}, rng);
  if (!building) return std::nullopt;
  const Turning turn(*building, rng);
  Sketch sketch;
  std::vector<unsigned> storey_of;
  double score = 0;
  for (unsigned s = 0; s < brief.storeys; ++s) {
    ProgramNeeds needs{brief.kind, s, brief.storeys, 0, 0, 0};
    for (const auto& block : building->storeys[s].blocks) {
      (block.inner ? needs.inner : needs.strips) += block.box.area();
      needs.depth = std::max(needs.depth, block.box.length(faces_x(block.faces)));
    }
    const auto layout = fill(*building, s, draw_program(needs, rng), 60, rng);
    if (!layout) return std::nullopt;
    const std::size_t first = sketch.cells.size();
    for (Cell cell : layout->cells) {
      cell.box = turn(cell.box);
      if (cell.host) *cell.host += first;
      sketch.cells.push_back(std::move(cell));
      storey_of.push_back(s);
    }
    score += layout->score;
  }
  sketch.middle = turn(Rect{0, 0, building->width, building->depth});
  sketch.front = turn(Side::kMinusY);
  if (building->flight) {
    sketch.flight = Flight{turn(building->flight->box), turn(building->flight->towards)};
  }
  Plan plan;
  plan.kind = brief.kind;
  plan.storeys = brief.levels;
  const double half = plan.outer_wall / 2;
  const Rect& m = sketch.middle;
  plan.outline = {m.x0 - half, m.y0 - half, m.x1 + half, m.y1 + half};
  add_rooms(sketch, storey_of, brief, plan, rng);
  add_stairs(sketch, brief, plan);
  // In large buildings a door is easily in another's way, in other places it is not.
  bool open = false;
  for (unsigned i = 0; i < 6 && !open; ++i) {
    plan.openings.clear();
    open = add_openings(sketch, plan, rng);
  }
  if (!open) return std::nullopt;
  if (!plan_faults(plan).empty()) return std::nullopt;
  return Scored{std::move(plan), score / brief.storeys};
}

std::string no_plan(std::uint64_t seed, const Brief& brief, unsigned draws) {
  return fmt::format(
      "no plan of a {} of {:.6g} m2 on {} storey{} with seed {}: rooms, doors and stairs fitted in "
      "none of {} draws. Take another seed or more area, {} m2 at most",
      enum_name(brief.kind), brief.area, brief.storeys, brief.storeys == 1 ? "" : "s", seed, draws,
      kMostArea);
}

}  // namespace

Plan make_plan(const PlanOptions& options, unsigned most_draws) {
  check_options(options);
  Rng rng(options.seed, stream_of("plan", 4));
  Brief brief;
  brief.kind = draw_kind(options, rng);
  brief.storeys = draw_storeys(options, brief.kind, rng);
  brief.area = options.area > 0 ? options.area : draw_area(brief.kind, brief.storeys, rng);
  draw_heights(brief, rng);
  // Most draws do not work out; of the first few that do, the best is kept.
  constexpr unsigned kGood = 3;
  std::optional<Scored> best;
  unsigned good = 0;
  for (unsigned i = 0; i < most_draws && good < kGood; ++i) {
    Rng own(options.seed, stream_of("draw", 4), i);
    auto drawn = draw_plan(brief, own);
    if (!drawn) continue;
    ++good;
    if (!best || drawn->score > best->score) best = std::move(drawn);
  }
  if (!best) throw NoPlan(no_plan(options.seed, brief, most_draws));
  best->plan.seed = options.seed;
  return std::move(best->plan);
}

}  // namespace enfilade::homes::plan

namespace enfilade::homes {

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
