#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "enfilade/mesh/detail/vector.h"
#include "enfilade/mesh/light/baker.h"

namespace enfilade::mesh::light {

using namespace detail;

namespace {

constexpr double kMostPieces = 3e6;  // of the surface's area; the spacing grows with larger ones
constexpr std::size_t kMostSources = 96;  // that are aimed at; more would take too long
constexpr float kPortalPart = 1.6F;       // metres: portals are cut so that none is larger

template <class T>
T median(std::vector<T> values, T otherwise) {
  if (values.empty()) return otherwise;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// A point in a grid of cells.
struct InCell {
  std::int64_t x, y, z;
  LightPoint point;
  auto cell() const { return std::tuple(x, y, z); }
};

InCell in_cell(Vec3f at, float size, LightPoint point) {
  const auto part = [size](float v) { return static_cast<std::int64_t>(std::floor(v / size)); };
  return {part(at.x), part(at.y), part(at.z), point};
}

}  // namespace

Baker::Baker(const RayTracer& tracer, const LitSurfaces& surfaces, const Lights& lights,
             const BakeOptions& options, const Progress& progress)
    : tracer_(tracer),
      surfaces_(surfaces),
      lights_(lights),
      options_(options),
      steps_(progress, options.threads),
      surroundings_(tracer.mesh()),
      mesh_(tracer.mesh()),
      base_mesh_(mesh_) {}

BakedLight Baker::run() {
  make_directions();
  make_sources();
  cut_to_spacing();
  grow();
  aim_at_sources(0, mesh_.size(), 250);
  shine_sun();
  probe();
  bounce();
  find_buried();
  gather_base();
  bounce();
  part_near_from_far();
  smooth(6);
  send_on();
  find_key();
  refine();
  fill_buried();
  steps_.report(BakeSteps::kTotal);
  BakedLight baked{std::move(mesh_), {}, key_};
  baked.light.resize(baked.mesh.size());
  for (std::size_t p = 0; p < baked.light.size(); ++p) {
    baked.light[p] = (1 / kFloatPi) * (direct_[p] + indirect_[p]);
  }
  return baked;
}

void Baker::cut_to_spacing() {
  double area = 0;
  for (const LightMesh::LightPiece& piece : mesh_.pieces()) area += mesh_.area(piece);
  const Box box = bounds(tracer_.mesh());
  const float far = std::max(length(box.low), length(box.high));
  // Halving makes pieces of about a quarter of spacing squared. Far from the origin, an edge cannot
  // be cut finer than what a float resolves.
  spacing_ = std::max({static_cast<float>(options_.spacing),
                       static_cast<float>(std::sqrt(4 * area / kMostPieces)), 1e-5F * far});
  // Light changes over about the distance to what is near: lawns need fewer points than rooms.
  constexpr float kCoarsest = 8, kNear = 12;
  constexpr int kRounds = 2;  // the first one's cuts make new edges
  for (float longest = kCoarsest * spacing_; longest >= spacing_; longest /= 2) {
    for (int round = 0; round < kRounds; ++round) {
      const std::size_t known = 2 * room_.size();
      mesh_.cut([&](LightPoint a, LightPoint b) {
        if (length(mesh_.position(a) - mesh_.position(b)) <= longest) return false;
        if (known == 0) return true;
        if (std::max(a, b) < known && (outside_[a / 2] || outside_[b / 2])) return false;
        // What is not measured yet waits for the next round.
        return std::max(a, b) < known && std::min(room_[a / 2], room_[b / 2]) < kNear * longest;
      });
      if (mesh_.size() == known) break;
      measure();
      measure_room();
    }
  }
  base_mesh_ = mesh_;
}

void Baker::grow() {
  const std::size_t n = mesh_.size();
  state_.resize(n);
  open_.resize(n);
  far_share_.resize(n);
  for (auto* light : {&direct_, &indirect_, &sun_, &found_, &near_, &far_, &sends_}) {
    light->resize(n);
  }
}

void Baker::measure() {
  start_.assign(mesh_.size() / 2, {});
  area_.assign(mesh_.size() / 2, 0);
  colour_.assign(mesh_.size() / 2, {});
  outside_.assign(mesh_.size() / 2, 1);
  for (const LightMesh::LightPiece& piece : mesh_.pieces()) {
    const float third = std::max(mesh_.area(piece) / 3, 1e-12F);
    const Vec3f middle = third * mesh_.centroid(piece);
    const Vec3f colour = third * surfaces_.mean_colour(piece.triangle);
    const bool outside = surroundings_.has(piece.triangle);
    for (const LightPoint p : piece.front) {
      if (!outside) outside_[p / 2] = 0;
      area_[p / 2] += third;
      start_[p / 2] += middle;
      colour_[p / 2] += colour;
    }
  }
  // Inwards from the rim of a surface, where another one may stand; along the surface, so that the
  // start does not get inside a bent one.
  constexpr float kInwards = 0.15F;
  for (std::size_t i = 0; i < start_.size(); ++i) {
    const auto p = static_cast<LightPoint>(2 * i);
    const Vec3f normal = mesh_.normal(p), at = mesh_.position(p);
    const Vec3f way = (1 / area_[i]) * start_[i] - at;
    start_[i] = at + kInwards * (way - dot(way, normal) * normal);
    colour_[i] = (1 / area_[i]) * colour_[i];
  }
}

// In meshes with rooms, what is outside all of them is only seen from afar, through windows.
void Baker::make_sources() {
  for (const Lamp& lamp : lights_.lamps) sources_.emplace_back(lamp);
  for (const Portal& portal : lights_.portals) {
    const auto parts = [](Vec3f edge) {
      return std::clamp(static_cast<int>(std::ceil(length(edge) / kPortalPart)), 1, 8);
    };
    const int columns = parts(portal.edge0), rows = parts(portal.edge1);
    const Vec3f across = (1 / static_cast<float>(columns)) * portal.edge0;
    const Vec3f up = (1 / static_cast<float>(rows)) * portal.edge1;
    for (int i = 0; i < columns * rows; ++i) {
      const Vec3f corner = portal.corner + static_cast<float>(i % columns) * across +
                           static_cast<float>(i / columns) * up;
      sources_.emplace_back(Portal{corner, across, up}, lights_.sky);
    }
  }
  make_glowing_sources();
}

void Baker::make_glowing_sources() {
  const Mesh& mesh = tracer_.mesh();
  // One of each object and material.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> glowing;
  std::vector<Vec3f> radiances;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (luminance(surfaces_.material(t).emission) <= 0) continue;
    const std::uint32_t object = object_of(mesh, t);
    glowing[{object, mesh.triangle_material[t]}].push_back(t);
  }
  if (glowing.empty()) return;
  source_of_.assign(mesh.triangles.size(), -1);
  for (const auto& [key, triangles] : glowing) {
    if (sources_.size() >= lights_.lamps.size() + kMostSources) break;
    for (const std::uint32_t t : triangles) {
      source_of_[t] = static_cast<std::int32_t>(sources_.size());
    }
    sources_.emplace_back(mesh, triangles, mesh.materials[key.second].emission);
  }
}

void Baker::find_buried() {
  for (std::size_t p = 0; p < state_.size(); ++p) {
    state_[p].live = luminance(direct_[p] + indirect_[p] + sun_[p]) > 0;
  }
  typical_ = median_irradiance();
  for (std::size_t p = 0; p < state_.size(); ++p) {
    PointState& state = state_[p];
    state.buried = state.backs && is_dark(static_cast<LightPoint>(p));
    if (state.buried) {
      state.live = false;
      direct_[p] = {};
    }
  }
}

bool Baker::is_dark(LightPoint p) const {
  constexpr float kDark = 0.03F;
  return luminance(direct_[p] + indirect_[p] + sun_[p]) <= kDark * typical_;
}

float Baker::median_irradiance() const {
  std::vector<float> fronts, all;
  for (std::size_t p = 0; p < state_.size(); ++p) {
    if (!state_[p].live) continue;
    const float value = luminance(direct_[p] + indirect_[p]);
    all.push_back(value);
    if (!state_[p].backs) fronts.push_back(value);
  }
  return median(std::move(fronts.empty() ? all : fronts), 1.0F);
}

void Baker::send_on() {
  for (std::size_t p = 0; p < sends_.size(); ++p) {
    sends_[p] = (1 / kFloatPi) * colour_[p / 2] * (direct_[p] + indirect_[p] + sun_[p]);
  }
}

void Baker::bounce() {
  constexpr std::size_t kGrain = 1024;
  indirect_ = found_;
  for (std::uint32_t k = 0; k < options_.bounces; ++k) {
    send_on();
    steps_.run(mesh_.size(), kGrain, 40 / options_.bounces, [&](std::size_t a, std::size_t b) {
      for (std::size_t p = a; p < b; ++p) {
        const std::size_t first = first_ray_[p], last = first_ray_[p + 1];
        Vec3f sum;
        for (std::size_t i = first; i < last; ++i) {
          if (seen_[i].surface() != kNowhere) sum += sends_[seen_[i].surface()];
        }
        if (last > first)
          indirect_[p] = found_[p] + kFloatPi / static_cast<float>(last - first) * sum;
      }
    });
  }
}

void Baker::part_near_from_far() {
  for (std::size_t p = 0; p < mesh_.size(); ++p) {
    const std::size_t first = first_ray_[p], last = first_ray_[p + 1];
    if (first == last) continue;
    Vec3f sum;  // near_ has what is not sent by surfaces
    std::size_t far = 0;
    for (std::size_t i = first; i < last; ++i) {
      if (seen_[i].near()) {
        sum += sends_[seen_[i].surface()];
      } else {
        ++far;
      }
    }
    const auto n = static_cast<float>(last - first);
    near_[p] += kFloatPi / n * sum;
    far_share_[p] = static_cast<float>(far) / n;
    if (far > 0) far_[p] = 1 / (kFloatPi * far_share_[p]) * (indirect_[p] - near_[p]);
  }
}

void Baker::join_near_and_far(LightPoint p) {
  indirect_[p] = near_[p] + kFloatPi * far_share_[p] * far_[p];
}

void Baker::find_key() {
  constexpr float kOutside = 0.4F;   // surfaces that see so much of the sky are outdoors
  constexpr float kCeiling = -0.5F;  // normals
  struct Part {
    float value, area;
  };
  std::vector<Part> parts, all;
  float area = 0, all_area = 0;
  for (std::size_t p = 0; p < state_.size(); ++p) {
    if (!state_[p].live) continue;
    const Part part{luminance(sends_[p]), area_[p / 2]};
    all.push_back(part);
    all_area += part.area;
    const float up = mesh_.normal(static_cast<LightPoint>(p)).z;
    if (open_[p] > kOutside || state_[p].backs || up < kCeiling) continue;
    parts.push_back(part);
    area += part.area;
  }
  typical_ = median_irradiance();
  if (parts.empty()) {
    parts = std::move(all);
    area = all_area;
  }
  std::ranges::sort(parts, {}, &Part::value);
  float below = 0;
  for (const Part& part : parts) {
    below += part.area;
    if (below < 0.5F * area) continue;
    if (part.value > 0) key_ = part.value;
    return;
  }
}

bool Baker::uneven(LightPoint a, LightPoint b, float distance) const {
  constexpr float kStep = 0.15F;      // part of the brighter end
  constexpr float kDarkStep = 0.02F;  // of what is typical
  constexpr float kAtSolids = 0.4F;   // where something stands on the surface
  if (distance <= options_.detail * spacing_ || outside_[a / 2] || outside_[b / 2]) return false;
  if (state_[a].buried != state_[b].buried) return distance > kAtSolids * spacing_;
  const float x = luminance(direct_[a] + indirect_[a]), y = luminance(direct_[b] + indirect_[b]);
  return std::abs(x - y) > kStep * std::max(x, y) + kDarkStep * typical_;
}

void Baker::refine() {
  constexpr int kRounds = 6;
  constexpr std::size_t kMostMore = 4;  // times the points before
  const std::size_t most = kMostMore * mesh_.size() + 400'000;
  for (int round = 0; round < kRounds && mesh_.size() < most; ++round) {
    const std::size_t known = mesh_.size();
    mesh_.cut([&](LightPoint a, LightPoint b) {
      if (a >= known || b >= known) return false;
      const float distance = length(mesh_.position(a) - mesh_.position(b));
      return uneven(a, b, distance) || uneven(a ^ 1U, b ^ 1U, distance);
    });
    if (mesh_.size() == known) break;
    grow();
    measure();
    gather_new(known);
  }
}

void Baker::fill_buried() {
  // Points inside solids are not seen, but light is interpolated up to them. They get the light of
  // their neighbours, or surfaces would look dark along the edges of solids that stand on them.
  for (int round = 0; round < 2; ++round) {
    std::vector<Vec3f> sum(mesh_.size());
    std::vector<float> count(mesh_.size());
    for (const LightMesh::LightPiece& piece : mesh_.pieces()) {
      for (std::size_t k = 0; k < 6; ++k) {
        const LightPoint side = k % 2;
        const LightPoint to = piece.front[k / 2] ^ side;
        if (!state_[to].buried || state_[to].live) continue;
        for (const LightPoint front : piece.front) {
          const LightPoint from = front ^ side;
          if (!state_[from].live) continue;
          sum[to] += direct_[from] + indirect_[from];
          count[to] += 1;
        }
      }
    }
    for (std::size_t p = 0; p < sum.size(); ++p) {
      if (count[p] == 0) continue;
      indirect_[p] = (1 / count[p]) * sum[p];
      state_[p].live = true;
    }
  }
}

void Baker::smooth(std::size_t rounds) {
  const std::vector<Link> links = make_links();
  std::vector<Vec3f> sum(far_.size());
  std::vector<float> weight(far_.size());
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t p = 0; p < far_.size(); ++p) {
      weight[p] = far_share_[p] + 1e-6F;
      sum[p] = weight[p] * far_[p];
    }
    for (const auto [a, b] : links) {
      constexpr float kShare = 0.6F;
      sum[a] += kShare * far_share_[b] * far_[b];
      weight[a] += kShare * far_share_[b];
      sum[b] += kShare * far_share_[a] * far_[a];
      weight[b] += kShare * far_share_[a];
    }
    for (std::size_t p = 0; p < far_.size(); ++p) far_[p] = (1 / weight[p]) * sum[p];
  }
  for (std::size_t p = 0; p < far_.size(); ++p) {
    if (state_[p].live) join_near_and_far(static_cast<LightPoint>(p));
  }
}

// Neighbours on one surface, on either side, with nothing between them.
std::vector<Baker::Link> Baker::make_links() const {
  std::vector<Link> links;
  for (const LightMesh::LightPiece& piece : mesh_.pieces()) {
    for (std::size_t k = 0; k < 3; ++k) {
      const LightPoint a = piece.front[k], b = piece.front[(k + 1) % 3];
      // As seen from the side on which the first is even.
      const LightPoint side = std::min(a, b) & 1U;
      links.push_back({std::min(a, b) ^ side, std::max(a, b) ^ side});
    }
  }
  std::ranges::sort(links);
  std::vector<std::uint8_t> rim(mesh_.size() / 2);
  for (std::size_t i = 0; i < links.size(); ++i) {
    const bool shared =
        (i > 0 && links[i] == links[i - 1]) || (i + 1 < links.size() && links[i] == links[i + 1]);
    if (!shared) rim[links[i][0] / 2] = rim[links[i][1] / 2] = 1;
  }
  const auto repeated = std::ranges::unique(links);
  links.erase(repeated.begin(), repeated.end());
  const std::vector<Link> across = seams(rim);
  links.insert(links.end(), across.begin(), across.end());
  return open_links(links);
}

// Links between points near each other on two rims in one plane: a wall around a window, for
// example, is made of several pieces that share no corners.
std::vector<Baker::Link> Baker::seams(const std::vector<std::uint8_t>& rim) const {
  constexpr float kReach = 0.75F;      // spacings
  constexpr float kLeastArea = 0.04F;  // spacings squared; seams of small things are not seen
  constexpr float kOnePlane = 0.005F;  // metres
  const float reach = kReach * spacing_;
  std::vector<InCell> points;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const auto p = static_cast<LightPoint>(2 * i);
    if (rim[i] == 0 || area_[i] < kLeastArea * spacing_ * spacing_) continue;
    points.push_back(in_cell(mesh_.position(p), reach, p));
  }
  std::ranges::sort(points, [](const InCell& a, const InCell& b) {
    return std::tuple(a.cell(), a.point) < std::tuple(b.cell(), b.point);
  });
  std::vector<Link> links;
  for (const InCell& from : points) {
    const Vec3f at = mesh_.position(from.point), normal = mesh_.normal(from.point);
    for (std::int64_t k = 0; k < 9; ++k) {
      const auto row = std::tuple(from.x + k / 3 - 1, from.y + k % 3 - 1, from.z - 1);
      auto other = std::ranges::lower_bound(points, row, {}, &InCell::cell);
      for (; other != points.end() && other->x == from.x + k / 3 - 1 &&
             other->y == from.y + k % 3 - 1 && other->z <= from.z + 1;
           ++other) {
        if (other->point <= from.point) continue;
        const Vec3f way = mesh_.position(other->point) - at;
        const float alike = dot(normal, mesh_.normal(other->point));
        if (length(way) > reach || std::abs(dot(way, normal)) > kOnePlane) continue;
        if (std::abs(alike) > 0.999F) links.push_back({from.point, other->point ^ (alike < 0)});
      }
    }
  }
  return links;
}

std::vector<Baker::Link> Baker::open_links(const std::vector<Link>& fronts) const {
  constexpr std::size_t kBlock = 128;
  std::vector<std::uint8_t> is_open(2 * fronts.size());
  const std::size_t blocks = (fronts.size() + kBlock - 1) / kBlock;
  parallel_for(blocks, 1, options_.threads, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> rays;
    std::vector<std::size_t> of;
    std::vector<std::uint8_t> blocked;
    for (std::size_t block = first; block < last; ++block) {
      rays.clear();
      of.clear();
      const std::size_t to = std::min((block + 1) * kBlock, fronts.size());
      for (std::size_t i = 2 * block * kBlock; i < 2 * to; ++i) {
        const LightPoint side = i % 2, a = fronts[i / 2][0] ^ side, b = fronts[i / 2][1] ^ side;
        if (!state_[a].live || !state_[b].live) continue;
        rays.push_back(along(a, b));
        of.push_back(i);
      }
      blocked.resize(rays.size());
      tracer_.blocked(rays, blocked);
      for (std::size_t k = 0; k < rays.size(); ++k) is_open[of[k]] = blocked[k] == 0 ? 1 : 0;
    }
  });
  std::vector<Link> links;
  for (std::size_t i = 0; i < is_open.size(); ++i) {
    const LightPoint side = i % 2;
    if (is_open[i] != 0) links.push_back({fronts[i / 2][0] ^ side, fronts[i / 2][1] ^ side});
  }
  return links;
}

}  // namespace enfilade::mesh::light
