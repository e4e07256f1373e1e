// The part of the baker that takes noise out of far light.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "enfilade/mesh/light/baker.h"

namespace enfilade::mesh::light {

namespace {

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
  for (const LightMesh::Piece& piece : mesh_.pieces()) {
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
