#include "enfilade/graph/detail/thin_out.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace enfilade::graph::detail {
namespace {

class Thinner {
 public:
  Thinner(const ThinningInput& input, std::vector<std::uint32_t>& cells)
      : in_(input), cells_(cells) {
    for (const std::uint32_t cell : cells_) viewpoints_.push_back(in_.placed(cell));
  }

  // The nearest two first; two that have to stay are not asked about again.
  void run() {
    std::set<std::pair<std::uint32_t, std::uint32_t>> kept;
    while (const auto pair = nearest_pair(kept)) {
      const auto [a, b] = *pair;
      if (const auto one = instead_of(a, b)) {
        replace(a, b, *one);
      } else {
        kept.emplace(cells_[a], cells_[b]);
      }
    }
  }

 private:
  using Pair = std::pair<std::size_t, std::size_t>;

  std::optional<Pair> nearest_pair(
      const std::set<std::pair<std::uint32_t, std::uint32_t>>& kept) const {
    std::optional<Pair> nearest;
    double metres = in_.least;
    for (std::size_t a = 0; a < cells_.size(); ++a) {
      for (std::size_t b = a + 1; b < cells_.size(); ++b) {
        const double apart = length(viewpoints_[b].eye - viewpoints_[a].eye);
        if (apart >= metres || kept.contains({cells_[a], cells_[b]})) continue;
        if (!in_.passage.in_sight(viewpoints_[a], viewpoints_[b])) continue;
        metres = apart;
        nearest = Pair(a, b);
      }
    }
    return nearest;
  }

  std::optional<std::uint32_t> instead_of(std::size_t a, std::size_t b) const {
    const auto pocket_a = in_.pockets.of[cells_[a]], pocket_b = in_.pockets.of[cells_[b]];
    const bool alone_a = is_alone(a, b), alone_b = is_alone(b, a);
    if (b < in_.first || (alone_a && alone_b && pocket_a != pocket_b)) return std::nullopt;
    const auto groups = groups_around(a, b);
    WalkingDistances near(in_.floor);
    const double reach = a < in_.first ? in_.least / 2 : in_.least;
    near.add(cells_[a], reach);
    if (a >= in_.first) near.add(cells_[b], reach);
    const auto good = [&](std::uint32_t cell) {
      if (!(near[cell] <= reach)) return false;
      if (alone_a && in_.pockets.of[cell] != pocket_a) return false;
      if (alone_b && in_.pockets.of[cell] != pocket_b) return false;
      return reaches_all(in_.placed(cell), groups);
    };
    if (good(cells_[a])) return cells_[a];
    if (good(cells_[b])) return cells_[b];
    const auto one = std::ranges::find_if(in_.candidates, good);
    if (one == in_.candidates.end()) return std::nullopt;
    return *one;
  }

  // Whether no viewpoint but these two is in a's pocket.
  bool is_alone(std::size_t a, std::size_t b) const {
    for (std::size_t v = 0; v < cells_.size(); ++v) {
      if (v != a && v != b && in_.pockets.of[cells_[v]] == in_.pockets.of[cells_[a]]) return false;
    }
    return true;
  }

  // Neighbours of the two, those together that have edges between them.
  std::vector<std::vector<std::size_t>> groups_around(std::size_t a, std::size_t b) const {
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t v = 0; v < cells_.size(); ++v) {
      if (v == a || v == b || !(is_free(a, v) || is_free(b, v))) continue;
      std::vector<std::size_t> own{v};
      std::erase_if(groups, [&](const std::vector<std::size_t>& group) {
        const bool joined =
            std::ranges::any_of(group, [&](std::size_t other) { return is_free(v, other); });
        if (joined) own.insert(own.end(), group.begin(), group.end());
        return joined;
      });
      groups.push_back(std::move(own));
    }
    return groups;
  }

  bool is_free(std::size_t a, std::size_t b) const {
    return in_.passage.is_free(viewpoints_[std::min(a, b)], viewpoints_[std::max(a, b)]);
  }

  bool reaches_all(const PlacedViewpoint& one,
                   const std::vector<std::vector<std::size_t>>& groups) const {
    return std::ranges::all_of(groups, [&](const std::vector<std::size_t>& group) {
      return std::ranges::any_of(
          group, [&](std::size_t v) { return in_.passage.is_free(viewpoints_[v], one); });
    });
  }

  void replace(std::size_t a, std::size_t b, std::uint32_t one) {
    cells_[a] = one;
    viewpoints_[a] = in_.placed(one);
    cells_.erase(cells_.begin() + static_cast<std::ptrdiff_t>(b));
    viewpoints_.erase(viewpoints_.begin() + static_cast<std::ptrdiff_t>(b));
  }

  const ThinningInput& in_;
  std::vector<std::uint32_t>& cells_;
  std::vector<PlacedViewpoint> viewpoints_;
};

}  // namespace

void thin_out(const ThinningInput& input, std::vector<std::uint32_t>& cells) {
  Thinner(input, cells).run();
}

}  // namespace enfilade::graph::detail
