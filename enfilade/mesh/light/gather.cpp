// The part of the baker that casts rays.
#include <algorithm>
#include <cmath>

#include "enfilade/core/rng.h"
#include "enfilade/mesh/detail/vector.h"
#include "enfilade/mesh/light/baker.h"

namespace enfilade::mesh::light {

using namespace detail;

namespace {

constexpr std::size_t kBlock = 64;  // points that are worked on together, for packets of rays
constexpr float kLeastIrradiance = 0.015F;     // less light from a source is ignored
constexpr std::size_t kMostRays = 48'000'000;  // whose ends are kept, 4 bytes each
constexpr std::size_t kProbes = 8;
constexpr float kNear = 2;    // spacings: what a point does not share with its neighbours
constexpr float kBright = 4;  // times what is typical
constexpr float kAir = 1.5F;  // metres in which Lights::ambient comes up to two thirds

// Metres off the surface: a millimetre, and what floats far from the origin can tell apart.
float step_off(Vec3f at) {
  return 1e-3F + 1e-6F * std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
}

// Two directions at right angles to a normal and each other (Duff et al. 2017).
struct Frame {
  Vec3f x, y;
  explicit Frame(Vec3f n) {
    const float sign = std::copysign(1.0F, n.z);
    const float a = -1 / (sign + n.z), b = n.x * n.y * a;
    x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
  }
};

// Computes the light that a block of receivers gets from one source.
class Shining {
 public:
  Shining(const RayTracer& tracer, std::span<const Receiver> receivers)
      : tracer_(tracer), receivers_(receivers), seen_(receivers.size()), sum_(receivers.size()) {}

  void shine(const LightSource& source, std::span<Vec3f> irradiance) {
    std::ranges::fill(seen_, std::uint32_t{0});
    std::ranges::fill(sum_, Vec3f{});
    const auto reached = [&](std::size_t i) {
      return source.reaches(receivers_[i], kLeastIrradiance) &&
             source.aimed_at(receivers_[i].position);
    };
    trace(source, 0, source.first_few(), reached);
    trace(source, source.first_few(), source.points(), [&](std::size_t i) { return seen_[i] > 0; });
    for (std::size_t i = 0; i < receivers_.size(); ++i) irradiance[i] += sum_[i];
  }

 private:
  template <class Which>
  void trace(const LightSource& source, std::size_t first, std::size_t last, const Which& which) {
    rays_.clear();
    targets_.clear();
    for (std::uint32_t i = 0; i < receivers_.size(); ++i) {
      if (!which(i)) continue;
      for (std::size_t k = first; k < last; ++k) {
        const LightSource::Aim aim = source.aim(receivers_[i], k);
        if (!(luminance(aim.irradiance) > 0)) continue;
        rays_.push_back(aim.ray);
        targets_.push_back({i, aim.irradiance});
      }
    }
    blocked_.resize(rays_.size());
    tracer_.blocked(rays_, blocked_, source.blockers());
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      if (blocked_[k] != 0) continue;
      sum_[targets_[k].receiver] += targets_[k].irradiance;
      ++seen_[targets_[k].receiver];
    }
  }

  // What a ray brings if it is not blocked.
  struct Target {
    std::uint32_t receiver;
    Vec3f irradiance;
  };

  const RayTracer& tracer_;
  std::span<const Receiver> receivers_;
  std::vector<std::uint32_t> seen_;
  std::vector<Vec3f> sum_;
  std::vector<Ray> rays_;
  std::vector<Target> targets_;  ///< one a ray
  std::vector<std::uint8_t> blocked_;
};

}  // namespace

Receiver Baker::receiver(LightPoint p) const {
  const Vec3f normal = mesh_.normal(p), at = start_[p / 2];
  return {at + step_off(at) * normal, normal};
}

void Baker::make_directions() {
  std::size_t rays = options_.rays;
  rays = std::clamp<std::size_t>(kMostRays / mesh_.size(), kProbes, rays);
  const std::array<std::size_t, 4> counts{rays, std::max(rays / 2, kProbes),
                                          std::max(rays / 4, kProbes), kProbes};
  const float turn = static_cast<float>(Rng(options_.seed).uniform()) * 2 * kFloatPi;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    Directions& made = directions_[k];
    const auto n = static_cast<float>(counts[k]);
    for (std::size_t i = 0; i < counts[k]; ++i) {
      // A sunflower pattern: even over the disc, so cosine-distributed over the half-sphere.
      constexpr float kGolden = 2.39996323F;
      const float square = (static_cast<float>(i) + 0.5F) / n;
      const float angle = turn + kGolden * static_cast<float>(i);
      const float r = std::sqrt(square);
      made.push_back({r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - square)});
    }
    // Neighbouring rays are traced together.
    std::ranges::sort(made, {}, [](Vec3f d) {
      return std::pair((d.x > 0 ? 1 : 0) + (d.y > 0 ? 2 : 0), std::atan2(d.y, d.x));
    });
  }
}

void Baker::aim_at_sources(std::size_t first, std::size_t last, std::size_t share) {
  const std::size_t blocks = (last - first + kBlock - 1) / kBlock;
  steps_.run(blocks, 1, share, [&](std::size_t a, std::size_t b) {
    for (std::size_t block = a; block < b; ++block) {
      const std::size_t from = first + block * kBlock, to = std::min(from + kBlock, last);
      std::vector<Receiver> receivers;
      for (std::size_t p = from; p < to; ++p) {
        receivers.push_back(receiver(static_cast<LightPoint>(p)));
      }
      Shining shining(tracer_, receivers);
      for (const LightSource& source : sources_) {
        shining.shine(source, std::span(direct_).subspan(from, to - from));
      }
    }
  });
}

void Baker::shine_sun() {
  const Vec3f towards = unit(lights_.sun.towards);
  if (luminance(lights_.sun.irradiance) <= 0) return;
  constexpr std::size_t kSamples = 4;  // a piece: patches of sun are smaller than pieces
  constexpr std::array<std::array<float, 2>, kSamples> kAt{
      {{0.333F, 0.333F}, {0.15F, 0.15F}, {0.7F, 0.15F}, {0.15F, 0.7F}}};
  const auto pieces = mesh_.pieces();
  std::vector<float> share(pieces.size());
  steps_.run((pieces.size() + kBlock - 1) / kBlock, 1, 50, [&](std::size_t a, std::size_t b) {
    std::array<Ray, kBlock * kSamples> rays;
    std::array<std::uint8_t, kBlock * kSamples> blocked{};
    for (std::size_t block = a; block < b; ++block) {
      const std::size_t from = block * kBlock, to = std::min(from + kBlock, pieces.size());
      std::size_t n = 0;
      for (std::size_t i = from; i < to; ++i) {
        const auto& f = pieces[i].front;
        const Vec3f p = mesh_.position(f[0]), q = mesh_.position(f[1]), r = mesh_.position(f[2]);
        const Vec3f normal = surfaces_.normal(pieces[i].triangle);
        const Vec3f off = std::copysign(step_off(p), dot(normal, towards)) * normal;
        for (const auto& [u, v] : kAt) {
          rays[n++] = {(1 - u - v) * p + u * q + v * r + off, towards};
        }
      }
      tracer_.blocked(std::span(rays).first(n), std::span(blocked).first(n));
      for (std::size_t i = 0; i < n; ++i) {
        if (blocked[i] == 0) share[from + i / kSamples] += 1.0F / kSamples;
      }
    }
  });
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (share[i] == 0) continue;
    const float cosine = dot(surfaces_.normal(pieces[i].triangle), towards);
    const float third = mesh_.area(pieces[i]) / 3;
    for (const LightPoint front : pieces[i].front) {
      const LightPoint p = front ^ (cosine < 0 ? 1U : 0U);
      sun_[p] += share[i] * std::abs(cosine) * third / area_[p / 2] * lights_.sun.irradiance;
    }
  }
}

const Baker::Directions& Baker::directions(LightPoint p) const {
  // Where points lie close together, neighbours make up for fewer rays.
  const float share = area_[p / 2] / (0.5F * spacing_ * spacing_);
  return directions_[share > 0.4F ? 0 : share > 0.08F ? 1 : share > 0.02F ? 2 : 3];
}

template <class Use>
void Baker::cast(LightPoint p, const Directions& directions, const Use& use) const {
  constexpr std::size_t kRays = 64;
  const Receiver from = receiver(p);
  const Frame frame(from.normal);
  // Each point turns them by its own angle, so that neighbours' rays complement each other.
  const float turn = static_cast<float>(Rng(options_.seed, p / 2).uniform()) * 2 * kFloatPi;
  const float c = std::cos(turn), s = std::sin(turn);
  const Vec3f x = c * frame.x + s * frame.y, y = c * frame.y - s * frame.x;
  std::array<Ray, kRays> rays;
  std::array<Hit, kRays> hits;
  for (std::size_t first = 0; first < directions.size(); first += kRays) {
    const std::size_t n = std::min(kRays, directions.size() - first);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3f d = directions[first + i];
      rays[i] = {from.position, d.x * x + d.y * y + d.z * from.normal};
    }
    tracer_.trace(std::span(rays).first(n), std::span(hits).first(n));
    for (std::size_t i = 0; i < n; ++i) use(first + i, find(from, rays[i].direction, hits[i]));
  }
}

Baker::RayEnd Baker::find(const Receiver& from, Vec3f direction, const Hit& hit) const {
  RayEnd found{lights_.ambient, kNowhere, false, false};
  if (!hit) {
    const bool aimed_at = std::ranges::any_of(sources_, [&](const LightSource& source) {
      return source.crossed_by(from.position, direction) && source.aimed_at(from.position);
    });
    if (!aimed_at) found.radiance += sky_radiance(lights_.sky, direction);
    return found;
  }
  found.radiance = (1 - std::exp(-hit.distance / kAir)) * found.radiance;
  const std::int32_t source = source_of_.empty() ? -1 : source_of_[hit.triangle];
  if (source < 0 || !sources_[static_cast<std::size_t>(source)].aimed_at(from.position)) {
    found.radiance += surfaces_.material(hit.triangle).emission;
  }
  found.back = dot(direction, surfaces_.normal(hit.triangle)) > 0;
  const LightMesh& mesh = base_mesh_;
  const LightMesh::PiecePoint place = mesh.locate(hit.triangle, hit.u, hit.v);
  const auto nearest =
      static_cast<std::size_t>(std::ranges::max_element(place.weights) - place.weights.begin());
  found.surface = mesh.pieces()[place.piece].front[nearest] ^ (found.back ? 1U : 0U);
  // Far light is averaged over neighbours. That must not light the insides of solids, but is needed
  // for bright surfaces, which few rays find.
  const bool bright = luminance(sends_[found.surface]) > kBright / kFloatPi * typical_;
  found.near = state_[found.surface].buried || (hit.distance < kNear * spacing_ && !bright);
  return found;
}

void Baker::measure_room() {
  const std::size_t known = room_.size();
  room_.resize(mesh_.size() / 2);
  // Only the ends of edges that may be cut are asked for.
  std::vector<std::uint8_t> wanted(room_.size());
  for (const LightMesh::LightPiece& piece : mesh_.pieces()) {
    for (std::size_t k = 0; k < 3; ++k) {
      const LightPoint a = piece.front[k], b = piece.front[(k + 1) % 3];
      if (length(mesh_.position(a) - mesh_.position(b)) <= spacing_) continue;
      wanted[a / 2] = wanted[b / 2] = 1;
    }
  }
  const Directions& few = directions_[3];
  parallel_for(room_.size() - known, kBlock, options_.threads, [&](std::size_t a, std::size_t b) {
    std::array<Ray, kProbes> rays;
    std::array<Hit, kProbes> hits;
    for (std::size_t i = known + a; i < known + b; ++i) {
      if (wanted[i] == 0) continue;
      float least = std::numeric_limits<float>::infinity();
      for (const LightSource& source : sources_) {
        least = std::min(least, source.distance(start_[i]));
      }
      for (const LightPoint side : {0U, 1U}) {
        const Receiver from = receiver(static_cast<LightPoint>(2 * i + side));
        const Frame frame(from.normal);
        for (std::size_t k = 0; k < kProbes; ++k) {
          const Vec3f d = few[k];
          rays[k] = {from.position, d.x * frame.x + d.y * frame.y + d.z * from.normal};
        }
        tracer_.trace(rays, hits);
        float sum = 0;
        for (const Hit& hit : hits) sum += 1 / std::max(hit.distance, 1e-3F);
        least = std::min(least, kProbes / sum);
      }
      room_[i] = least;
    }
  });
}

void Baker::probe() {
  const Directions& few = directions_[3];
  seen_.assign(mesh_.size() * few.size(), {});
  first_ray_.resize(mesh_.size() + 1);
  for (std::size_t p = 0; p < first_ray_.size(); ++p) first_ray_[p] = p * few.size();
  steps_.run(mesh_.size(), kBlock, 100, [&](std::size_t a, std::size_t b) {
    for (std::size_t p = a; p < b; ++p) {
      std::size_t backs = 0;
      Vec3f sum;
      cast(static_cast<LightPoint>(p), few, [&](std::size_t i, const RayEnd& found) {
        seen_[p * few.size() + i] = {found.surface, found.near};
        if (found.back) ++backs;
        sum += found.radiance;
      });
      state_[p].backs = 2 * backs >= few.size();
      // Ambient light is in solids, too, which should stay dark.
      const bool solid = backs == few.size() && lights_.ambient != Vec3f{};
      found_[p] = solid ? Vec3f{} : kFloatPi / static_cast<float>(few.size()) * sum;
    }
  });
}

// Metres above a surface: rays pass over its roughness, but not through what stands on it.
constexpr float kLow = 0.02F;

Ray Baker::along(LightPoint a, LightPoint b) const {
  const Vec3f from = start_[a / 2] + kLow * mesh_.normal(a);
  return {from, start_[b / 2] + kLow * mesh_.normal(b) - from, 0, 1};
}

// For each new point and each end of the edge that it lies on: 1 if nothing is between them.
std::vector<std::uint8_t> Baker::sees_ends(std::size_t known) const {
  std::vector<std::uint8_t> seen(2 * (mesh_.size() - known));
  parallel_for(mesh_.size() - known, kBlock, options_.threads, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i) {
      const auto p = static_cast<LightPoint>(known + i);
      for (const std::size_t k : {0U, 1U}) {
        seen[2 * i + k] = tracer_.blocked(along(p, mesh_.ends(p)[k])) ? 0 : 1;
      }
    }
  });
  return seen;
}

void Baker::gather_base() {
  first_ray_.assign(mesh_.size() + 1, 0);
  for (std::size_t p = 0; p < mesh_.size(); ++p) {
    const std::size_t n = state_[p].live ? directions(static_cast<LightPoint>(p)).size() : 0;
    first_ray_[p + 1] = first_ray_[p] + n;
  }
  seen_.assign(first_ray_.back(), {});
  std::ranges::fill(found_, Vec3f{});
  steps_.run(mesh_.size(), kBlock, 300, [&](std::size_t a, std::size_t b) {
    for (std::size_t p = a; p < b; ++p) {
      if (!state_[p].live) continue;
      const Directions& all = directions(static_cast<LightPoint>(p));
      std::size_t skies = 0;
      Vec3f sum, near;
      cast(static_cast<LightPoint>(p), all, [&](std::size_t i, const RayEnd& found) {
        seen_[first_ray_[p] + i] = {found.surface, found.near};
        sum += found.radiance;
        if (found.near) near += found.radiance;
        if (found.surface == kNowhere) ++skies;
      });
      const auto n = static_cast<float>(all.size());
      found_[p] = kFloatPi / n * sum;
      near_[p] = kFloatPi / n * near;
      open_[p] = static_cast<float>(skies) / n;
    }
  });
}

void Baker::gather_new(std::size_t known) {
  const std::vector<std::uint8_t> seen = sees_ends(known);
  // In order: ends may be new, too.
  for (std::size_t p = known; p < mesh_.size(); ++p) {
    const auto ends = mesh_.ends(static_cast<LightPoint>(p));
    float count = 0;
    for (const std::size_t k : {0U, 1U}) {
      if (seen[2 * (p - known) + k] == 0 || state_[ends[k]].buried) continue;
      far_[p] += far_[ends[k]];
      ++count;
    }
    if (count > 0) far_[p] = (1 / count) * far_[p];
  }
  aim_at_sources(known, mesh_.size(), 20);
  steps_.run(mesh_.size() - known, kBlock, 50, [&](std::size_t a, std::size_t b) {
    for (std::size_t p = known + a; p < known + b; ++p) {
      const Directions& some = directions_[1];
      std::size_t backs = 0, far = 0;
      Vec3f near;
      cast(static_cast<LightPoint>(p), some, [&](std::size_t, const RayEnd& found) {
        if (found.back) ++backs;
        if (!found.near) {
          ++far;
          return;
        }
        near += found.radiance + sends_[found.surface];
      });
      const auto n = static_cast<float>(some.size());
      near_[p] = kFloatPi / n * near;
      far_share_[p] = static_cast<float>(far) / n;
      join_near_and_far(static_cast<LightPoint>(p));
      PointState& state = state_[p];
      state.backs = 2 * backs >= some.size();
      state.buried = state.backs && is_dark(static_cast<LightPoint>(p));
      state.live = !state.buried;
      if (state.buried) direct_[p] = indirect_[p] = {};
    }
  });
}

}  // namespace enfilade::mesh::light
