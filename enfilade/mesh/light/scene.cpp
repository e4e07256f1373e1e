#include <algorithm>
#include <bit>
#include <cmath>

#include "enfilade/mesh/detail/vector.h"
#include "enfilade/mesh/light/scene.h"

namespace enfilade::mesh::light {

using namespace detail;

namespace {

// Normals closer than about this part of 1 are the same: surfaces that bend less look smooth.
constexpr float kNormalSteps = 40;

std::uint64_t hashed(Vec3f position, const std::array<std::int16_t, 3>& normal) {
  std::uint64_t h = 0x9e3779b97f4a7c15U;
  const auto put = [&h](std::uint64_t value) {
    h = (h ^ value) * 0xff51afd7ed558ccdU;
    h ^= h >> 32U;
  };
  put(std::bit_cast<std::uint32_t>(position.x));
  put(std::bit_cast<std::uint32_t>(position.y));
  put(std::bit_cast<std::uint32_t>(position.z));
  for (const std::int16_t part : normal) put(static_cast<std::uint16_t>(part));
  return h;
}

Vec3f corner_normal(const Mesh& mesh, std::size_t triangle, std::size_t corner, Vec3f geometric) {
  if (mesh.normals.empty()) return geometric;
  const Vec3f n = unit(mesh.normals[triangle][corner], geometric);
  return dot(n, geometric) < 0 ? -n : n;
}

// The square root of the triangle's area in texels over that in space.
float texels_per_metre(const Mesh& mesh, std::uint32_t triangle, const TexturePyramid& texture,
                       float area) {
  const auto& [a, b, c] = mesh.texture_points[triangle];
  const float u1 = (b.u - a.u) * texture.width(), v1 = (b.v - a.v) * texture.height();
  const float u2 = (c.u - a.u) * texture.width(), v2 = (c.v - a.v) * texture.height();
  return area > 0 ? std::sqrt(0.5F * std::abs(u1 * v2 - u2 * v1) / area) : 0;
}

constexpr int kPortalGrid = 3;           // points across a portal, each way
constexpr std::size_t kGlowPoints = 12;  // of a glowing thing
constexpr float kSurface = 2e-3F;        // metres in front of a glowing surface: not on it
constexpr float kAimedAtFrom = 1.25F;    // times its radius

// Fractional parts of the plastic number's powers (Roberts' R2): evenly spread points.
constexpr float kR2u = 0.7548776662F, kR2v = 0.5698402910F;

float fraction(float x) { return x - std::floor(x); }

float luminance_of_brightest(const Sky& sky) {
  return std::max({luminance(sky.zenith), luminance(sky.horizon), luminance(sky.ground)});
}

}  // namespace

LightMesh::LightMesh(const Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  grow_table();
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3f a = mesh.positions[corners[0]], b = mesh.positions[corners[1]],
                c = mesh.positions[corners[2]];
    const Vec3f geometric = unit(cross(b - a, c - a));
    LightPiece piece{{}, t};
    for (std::size_t k = 0; k < 3; ++k) {
      piece.front[k] = point_at(mesh.positions[corners[k]], corner_normal(mesh, t, k, geometric));
    }
    pieces_.push_back(piece);
    node_of_piece_.push_back(t);
    nodes_.push_back({t, kWhole});
  }
  ends_.resize(positions_.size());
}

LightPoint LightMesh::point_at(Vec3f position, Vec3f normal) {
  position = position + Vec3f{};  // -0 becomes 0
  std::array<std::int16_t, 3> key{static_cast<std::int16_t>(std::lround(kNormalSteps * normal.x)),
                                  static_cast<std::int16_t>(std::lround(kNormalSteps * normal.y)),
                                  static_cast<std::int16_t>(std::lround(kNormalSteps * normal.z))};
  // The even side's first part that is not 0 is positive.
  const int first = key[0] != 0 ? key[0] : key[1] != 0 ? key[1] : key[2];
  const LightPoint side = first < 0 ? 1 : 0;
  if (side == 1) {
    normal = -normal;
    for (std::int16_t& part : key) part = static_cast<std::int16_t>(-part);
  }
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = hashed(position, key) & mask;
  for (; table_[slot] != 0; slot = (slot + 1) & mask) {
    const std::uint32_t place = table_[slot] - 1;
    if (positions_[place] == position && keys_[place] == key) return 2 * place + side;
  }
  const auto place = static_cast<std::uint32_t>(positions_.size());
  positions_.push_back(position);
  normals_.push_back(normal);
  keys_.push_back(key);
  table_[slot] = place + 1;
  if (2 * positions_.size() > table_.size()) grow_table();
  return 2 * place + side;
}

void LightMesh::grow_table() {
  table_.assign(std::max<std::size_t>(1024, 2 * table_.size()), 0);
  const std::size_t mask = table_.size() - 1;
  for (std::uint32_t place = 0; place < positions_.size(); ++place) {
    std::size_t slot = hashed(positions_[place], keys_[place]) & mask;
    while (table_[slot] != 0) slot = (slot + 1) & mask;
    table_[slot] = place + 1;
  }
}

std::uint32_t LightMesh::halve(std::uint32_t piece, unsigned edge) {
  const LightPoint a = pieces_[piece].front[edge], b = pieces_[piece].front[(edge + 1) % 3];
  const Vec3f normal = unit(this->normal(a) + this->normal(b), this->normal(a));
  const LightPoint middle = point_at(0.5F * (position(a) + position(b)), normal);
  if (ends_.size() < positions_.size()) {
    ends_.resize(positions_.size());
    ends_[middle / 2] = {a ^ (middle & 1U), b ^ (middle & 1U)};
  }
  const auto made = static_cast<std::uint32_t>(pieces_.size());
  pieces_.push_back(pieces_[piece]);
  pieces_[piece].front[(edge + 1) % 3] = middle;
  pieces_[made].front[edge] = middle;
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node_of_piece_[piece]] = {children, edge};
  nodes_.push_back({piece, kWhole});
  nodes_.push_back({made, kWhole});
  node_of_piece_[piece] = children;
  node_of_piece_.push_back(children + 1);
  return made;
}

bool LightMesh::is_line(const LightPiece& piece) const {
  constexpr float kRounding = 1e-6F;  // of coordinates; a float has a sixteenth of it
  const Vec3f a = position(piece.front[0]), b = position(piece.front[1]) - a,
              c = position(piece.front[2]) - a;
  const float longest = std::max({length(b), length(c), length(c - b)});
  return length(cross(b, c)) <= kRounding * (length(a) + longest) * longest;
}

LightMesh::PiecePoint LightMesh::locate(std::uint32_t triangle, float u, float v) const {
  PiecePoint place{0, {1 - u - v, u, v}};
  PieceNode node = nodes_[triangle];
  while (node.edge != kWhole) {
    const std::uint32_t i = node.edge, j = i == 2 ? 0 : i + 1;
    float &a = place.weights[i], &b = place.weights[j];
    if (a >= b) {  // the half with corner i: corner j is the edge's middle
      a -= b;
      b *= 2;
      node = nodes_[node.next];
    } else {
      b -= a;
      a *= 2;
      node = nodes_[node.next + 1];
    }
  }
  place.piece = node.next;
  return place;
}

float LightMesh::area(const LightPiece& piece) const {
  const Vec3f a = position(piece.front[0]);
  return 0.5F * length(cross(position(piece.front[1]) - a, position(piece.front[2]) - a));
}

Vec3f LightMesh::centroid(const LightPiece& piece) const {
  return (1.0F / 3) *
         (position(piece.front[0]) + position(piece.front[1]) + position(piece.front[2]));
}

LitSurfaces::LitSurfaces(const Mesh& mesh) : mesh_(mesh) {
  bool textured = false;
  for (const Material& material : mesh.materials) {
    const bool has = !material.texture.pixels.empty() && !mesh.texture_points.empty();
    textures_.push_back(has ? TexturePyramid(material.texture) : TexturePyramid());
    textured = textured || has;
  }
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  normals_.reserve(count);
  if (textured) texels_per_metre_.resize(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3f a = mesh.positions[corners[0]];
    const Vec3f across = cross(mesh.positions[corners[1]] - a, mesh.positions[corners[2]] - a);
    normals_.push_back(unit(across));
    const TexturePyramid& texture = textures_[mesh.triangle_material[t]];
    if (!texture.empty()) {
      texels_per_metre_[t] = texels_per_metre(mesh, t, texture, 0.5F * length(across));
    }
  }
}

Vec3f LitSurfaces::normal(std::uint32_t triangle, float u, float v) const {
  const Vec3f geometric = normals_[triangle];
  if (mesh_.normals.empty()) return geometric;
  const auto& [a, b, c] = mesh_.normals[triangle];
  const Vec3f n = unit((1 - u - v) * a + u * b + v * c, geometric);
  return dot(n, geometric) < 0 ? -n : n;
}

Vec3f LitSurfaces::position(std::uint32_t triangle, float u, float v) const {
  const auto& corners = mesh_.triangles[triangle];
  return (1 - u - v) * mesh_.positions[corners[0]] + u * mesh_.positions[corners[1]] +
         v * mesh_.positions[corners[2]];
}

Vec3f LitSurfaces::vertex_colour(std::uint32_t triangle, float u, float v) const {
  const auto& corners = mesh_.triangles[triangle];
  return (1 - u - v) * mesh_.colours[corners[0]] + u * mesh_.colours[corners[1]] +
         v * mesh_.colours[corners[2]];
}

Vec3f LitSurfaces::colour(std::uint32_t triangle, float u, float v, float footprint) const {
  const std::uint32_t material = mesh_.triangle_material[triangle];
  Vec3f colour = mesh_.materials[material].colour;
  if (!mesh_.colours.empty()) colour = colour * vertex_colour(triangle, u, v);
  const TexturePyramid& texture = textures_[material];
  if (texture.empty()) return colour;
  return colour *
         texture.at(texture_point(mesh_, triangle, u, v), footprint * texels_per_metre_[triangle]);
}

Vec3f LitSurfaces::mean_colour(std::uint32_t triangle) const {
  const std::uint32_t id = mesh_.triangle_material[triangle];
  const Material& material = mesh_.materials[id];
  Vec3f colour = material.colour;
  if (!mesh_.colours.empty()) colour = colour * vertex_colour(triangle, 1.0F / 3, 1.0F / 3);
  if (!textures_[id].empty()) colour = colour * textures_[id].mean();
  return mix(colour, {1, 1, 1}, material.mirror);
}

LightSource::LightSource(const Lamp& lamp)
    : kind_(SourceKind::kLamp),
      middle_(lamp.position),
      radius_(lamp.radius),
      strength_(lamp.power),
      most_(luminance(lamp.power)) {
  // Corners of a cube in the ball, each next to its opposite.
  const float r = lamp.radius / std::sqrt(3.0F);
  for (const Vec3f corner : {Vec3f{r, r, r}, Vec3f{r, -r, r}, Vec3f{-r, r, r}, Vec3f{-r, -r, r}}) {
    points_.push_back({middle_ + corner, {}, 0});
    points_.push_back({middle_ - corner, {}, 0});
  }
  first_few_ = 2;
}

LightSource::LightSource(const Portal& portal, const Sky& sky)
    : kind_(SourceKind::kPortal),
      middle_(portal.corner + 0.5F * (portal.edge0 + portal.edge1)),
      radius_(0.5F *
              std::max(length(portal.edge0 + portal.edge1), length(portal.edge0 - portal.edge1))),
      portal_(portal),
      sky_(sky) {
  const Vec3f across = cross(portal.edge0, portal.edge1);
  const float area = length(across);
  most_ = area * luminance_of_brightest(sky);
  const Vec3f normal = unit(across);
  const float part = area / (kPortalGrid * kPortalGrid);
  // The first three lie in three rows and columns.
  for (int i = 0; i < kPortalGrid * kPortalGrid; ++i) {
    const int row = i % kPortalGrid, column = (row + i / kPortalGrid) % kPortalGrid;
    const float s = (static_cast<float>(column) + fraction(kR2u * static_cast<float>(i + 1)));
    const float t = (static_cast<float>(row) + fraction(kR2v * static_cast<float>(i + 1)));
    points_.push_back(
        {portal.corner + (s / kPortalGrid) * portal.edge0 + (t / kPortalGrid) * portal.edge1,
         normal, part});
  }
  first_few_ = kPortalGrid;
}

LightSource::LightSource(const Mesh& mesh, std::span<const std::uint32_t> triangles, Vec3f radiance)
    : kind_(SourceKind::kGlow), strength_(radiance) {
  std::vector<float> until;  // area of all triangles up to this one
  float area = 0;
  Vec3f low{1e30F, 1e30F, 1e30F}, high{-1e30F, -1e30F, -1e30F};
  for (const std::uint32_t t : triangles) {
    const auto& c = mesh.triangles[t];
    const Vec3f a = mesh.positions[c[0]];
    area += 0.5F * length(cross(mesh.positions[c[1]] - a, mesh.positions[c[2]] - a));
    until.push_back(area);
    for (const std::uint32_t corner : c) {
      const Vec3f p = mesh.positions[corner];
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  middle_ = 0.5F * (low + high);
  radius_ = 0.5F * length(high - low);
  most_ = area * luminance(radiance);
  for (std::size_t i = 0; i < kGlowPoints && area > 0; ++i) {
    const float at = area * (static_cast<float>(i) + 0.5F) / kGlowPoints;
    const auto place =
        static_cast<std::size_t>(std::ranges::lower_bound(until, at) - until.begin());
    const auto& c = mesh.triangles[triangles[std::min(place, triangles.size() - 1)]];
    const Vec3f a = mesh.positions[c[0]], b = mesh.positions[c[1]], d = mesh.positions[c[2]];
    float u = fraction(kR2u * static_cast<float>(i + 1));
    float v = fraction(kR2v * static_cast<float>(i + 1));
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    points_.push_back(
        {(1 - u - v) * a + u * b + v * d, unit(cross(b - a, d - a)), area / kGlowPoints});
  }
  first_few_ = points_.size();
}

bool LightSource::aimed_at(Vec3f from) const {
  return kind_ == SourceKind::kLamp || length(from - middle_) > kAimedAtFrom * radius_;
}

float LightSource::distance(Vec3f from) const {
  return std::max(length(from - middle_) - radius_, 0.0F);
}

bool LightSource::reaches(const Receiver& receiver, float least) const {
  const Vec3f way = middle_ - receiver.position;
  const float along = dot(way, receiver.normal);
  if (along <= -radius_) return false;
  const float distance = std::max(length(way) - radius_, 0.05F);
  return most_ > least * distance * distance;
}

LightSource::Aim LightSource::aim(const Receiver& receiver, std::size_t point) const {
  const SourcePoint& at = points_[point];
  const Vec3f way = at.position - receiver.position;
  Aim aim{{receiver.position, way, 0, 1}, {}};
  if (kind_ == SourceKind::kLamp) {
    const Vec3f to_middle = middle_ - receiver.position;
    const float square = std::max(dot(to_middle, to_middle), radius_ * radius_ + 1e-6F);
    const float cosine = std::max(dot(to_middle, receiver.normal), 0.0F) / std::sqrt(square);
    aim.irradiance = cosine / (square * static_cast<float>(points_.size())) * strength_;
    return aim;
  }
  const float square = std::max(dot(way, way), 1e-6F);
  const float distance = std::sqrt(square);
  const float cosines =
      std::max(dot(way, receiver.normal), 0.0F) * std::abs(dot(way, at.normal)) / square;
  const Vec3f radiance =
      kind_ == SourceKind::kGlow ? strength_ : sky_radiance(sky_, (1 / distance) * way);
  aim.irradiance = cosines * at.area / square * radiance;
  aim.ray.far = kind_ == SourceKind::kGlow ? std::max(1 - kSurface / distance, 0.0F)
                                           : std::numeric_limits<float>::infinity();
  return aim;
}

bool LightSource::crossed_by(Vec3f origin, Vec3f direction) const {
  if (kind_ != SourceKind::kPortal) return false;
  // origin + t direction = corner + s edge0 + r edge1 (Moeller and Trumbore's way to solve it)
  const Vec3f p = cross(direction, portal_.edge1);
  const float determinant = dot(portal_.edge0, p);
  if (determinant == 0) return false;
  const Vec3f from = origin - portal_.corner;
  const float s = dot(from, p) / determinant;
  const Vec3f q = cross(from, portal_.edge0);
  const float r = dot(direction, q) / determinant;
  const float t = dot(portal_.edge1, q) / determinant;
  return t > 0 && s >= 0 && s <= 1 && r >= 0 && r <= 1;
}

}  // namespace enfilade::mesh::light
