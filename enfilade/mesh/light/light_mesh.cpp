#include "enfilade/mesh/light/light_mesh.h"

#include <bit>
#include <cmath>

#include "enfilade/mesh/detail/vector.h"

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

}  // namespace

LightMesh::LightMesh(const Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  grow_table();
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3f a = mesh.positions[corners[0]], b = mesh.positions[corners[1]],
                c = mesh.positions[corners[2]];
    const Vec3f geometric = unit(cross(b - a, c - a));
    Piece piece{{}, t};
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

LightMesh::Place LightMesh::locate(std::uint32_t triangle, float u, float v) const {
  Place place{0, {1 - u - v, u, v}};
  Node node = nodes_[triangle];
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

float LightMesh::area(const Piece& piece) const {
  const Vec3f a = position(piece.front[0]);
  return 0.5F * length(cross(position(piece.front[1]) - a, position(piece.front[2]) - a));
}

Vec3f LightMesh::centroid(const Piece& piece) const {
  return (1.0F / 3) *
         (position(piece.front[0]) + position(piece.front[1]) + position(piece.front[2]));
}

}  // namespace enfilade::mesh::light
