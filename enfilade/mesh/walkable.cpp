#include "enfilade/mesh/walkable.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "enfilade/mesh/detail/exact_heights.h"
#include "enfilade/mesh/detail/floor_field.h"

namespace enfilade::mesh {

using namespace detail;

namespace {

constexpr double kAboveFloor = 0.05;  // points this far below the floor are still on it

Cells gather(const Field& field, const Lattice& lattice, const WalkableOptions& options) {
  const std::vector<std::uint32_t> ranks = rank_spans(field, options);
  Cells out;
  out.first_in_column.assign(static_cast<std::size_t>(lattice.width * lattice.depth) + 1, 0);
  std::vector<std::uint32_t> place(field.spans(), kNoSpan);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (ranks[s] == kNoSpan) continue;
    place[s] = static_cast<std::uint32_t>(out.cells.size());
    out.cells.push_back(field.cell(s));
    out.cells.back().area = ranks[s];
    ++out.first_in_column[static_cast<std::size_t>(field.column(s)) + 1];
  }
  std::partial_sum(out.first_in_column.begin(), out.first_in_column.end(),
                   out.first_in_column.begin());
  out.first_link.push_back(0);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (place[s] == kNoSpan) continue;
    field.each_neighbour(s, [&](std::uint32_t next) { out.links.push_back(place[next]); });
    out.first_link.push_back(static_cast<std::uint32_t>(out.links.size()));
  }
  return out;
}

}  // namespace

struct WalkableFloor::Impl {
  WalkableOptions options;
  Lattice lattice;
  Cells floor;
  std::size_t areas = 0;
};

WalkableFloor::WalkableFloor(const Mesh& mesh, const WalkableOptions& options)
    : impl_(std::make_unique<Impl>()) {
  check_walkable_input(mesh, options);
  impl_->options = options;
  impl_->lattice = make_lattice(mesh, options);
  const Lattice& lattice = impl_->lattice;
  Field field = make_field(mesh, options, lattice);
  field.erode(options);
  field.measure_distances();
  impl_->floor = gather(field, lattice, options);
  set_exact_heights(mesh, lattice, options.body.step, impl_->floor);
  for (const FloorCell& cell : impl_->floor.cells) {
    impl_->areas = std::max<std::size_t>(impl_->areas, cell.area + 1);
  }
}

WalkableFloor::~WalkableFloor() = default;
WalkableFloor::WalkableFloor(WalkableFloor&&) noexcept = default;
WalkableFloor& WalkableFloor::operator=(WalkableFloor&&) noexcept = default;

const WalkableOptions& WalkableFloor::options() const noexcept { return impl_->options; }
std::span<const FloorCell> WalkableFloor::cells() const noexcept { return impl_->floor.cells; }
std::size_t WalkableFloor::areas() const noexcept { return impl_->areas; }

std::span<const std::uint32_t> WalkableFloor::neighbours(std::size_t cell) const noexcept {
  const Cells& floor = impl_->floor;
  return std::span(floor.links)
      .subspan(floor.first_link[cell], floor.first_link[cell + 1] - floor.first_link[cell]);
}

double WalkableFloor::area_m2() const noexcept {
  return static_cast<double>(cells().size()) * impl_->options.cell * impl_->options.cell;
}

std::optional<std::size_t> WalkableFloor::below(Vec3f point, double drop) const {
  const Lattice& lattice = impl_->lattice;
  const double x = std::floor((point.x - lattice.box.low.x) / lattice.cell);
  const double y = std::floor((point.y - lattice.box.low.y) / lattice.cell);
  if (!(x >= 0 && x < lattice.width && y >= 0 && y < lattice.depth)) return std::nullopt;
  const auto column = static_cast<std::size_t>(y * lattice.width + x);
  const Cells& floor = impl_->floor;
  for (std::size_t c = floor.first_in_column[column + 1]; c > floor.first_in_column[column]; --c) {
    const double down = static_cast<double>(point.z) - floor.cells[c - 1].position.z;
    if (down >= -kAboveFloor) return down <= drop ? std::optional(c - 1) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace enfilade::mesh
