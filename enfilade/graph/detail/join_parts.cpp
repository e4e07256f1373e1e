#include "enfilade/graph/detail/join_parts.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "enfilade/graph/detail/floor_walk.h"

namespace enfilade::graph::detail {
namespace {

// Each second cell of a way is tried: they are closer than a body is wide.
constexpr std::size_t kStride = 2;

class Joiner {
 public:
  Joiner(const mesh::WalkableFloor& floor, const Passage& passage,
         const std::function<PlacedViewpoint(std::uint32_t)>& placed,
         std::vector<std::uint32_t>& cells)
      : floor_(floor), passage_(passage), placed_(placed), cells_(cells) {
    start_from(cells.size());
  }

  // Groups of a part of the floor join their nearest, the smallest first.
  void run() {
    for (std::uint32_t area = 0; area < floor_.areas(); ++area) {
      while (join_next(area)) {
      }
    }
  }

 private:
  std::size_t root(std::size_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }

  std::size_t add(std::uint32_t cell) {
    const std::size_t v = cells_.size();
    cells_.push_back(cell);
    viewpoints_.push_back(placed_(cell));
    parent_.push_back(v);
    for (std::size_t other = 0; other < v; ++other) {
      if (root(other) != root(v) && passage_.is_free(viewpoints_[other], viewpoints_[v])) {
        parent_[root(v)] = root(other);
      }
    }
    return v;
  }

  bool join_next(std::uint32_t area) {
    std::map<std::size_t, std::vector<std::uint32_t>> groups;
    for (std::size_t v = 0; v < cells_.size(); ++v) {
      const std::uint32_t cell = cells_[v];
      if (floor_.cells()[cell].area == area && !given_up_.contains(cell)) {
        groups[root(v)].push_back(cell);
      }
    }
    if (groups.size() < 2) return false;
    const auto smallest =
        std::ranges::min_element(groups, {}, [](const auto& group) { return group.second.size(); });
    std::vector<std::uint32_t> others;
    for (const auto& [name, group] : groups) {
      if (name != smallest->first) others.insert(others.end(), group.begin(), group.end());
    }
    const std::vector<std::uint32_t> way = find_way(floor_, smallest->second, others);
    if (way.empty() || !walk(way)) {
      // Too narrow for an edge; check_graph() reports the gap.
      given_up_.insert(smallest->second.begin(), smallest->second.end());
    }
    return true;
  }

  std::size_t root_of(std::uint32_t cell) {
    const auto at = std::ranges::find(cells_, cell);
    return root(static_cast<std::size_t>(at - cells_.begin()));
  }

  // Adds viewpoints along the way until its ends are connected.
  bool walk(const std::vector<std::uint32_t>& way) {
    std::size_t here = 0;
    const std::size_t first = cells_.size();
    while (root_of(way.front()) != root_of(way.back())) {
      const std::optional<std::size_t> next = next_stop(way, here);
      if (!next || *next == here) {
        start_from(first);
        return false;
      }
      here = *next;
      add(way[here]);
    }
    return true;
  }

  // A place from which one can go on to the way's end, with most room; else the farthest one.
  std::optional<std::size_t> next_stop(const std::vector<std::uint32_t>& way, std::size_t here) {
    const PlacedViewpoint from = placed_(way[here]), end = placed_(way.back());
    std::optional<std::size_t> farthest, best;
    for (std::size_t i = here + kStride; i + 1 < way.size(); i += kStride) {
      const PlacedViewpoint stop = placed_(way[i]);
      if (!passage_.is_free(from, stop)) continue;
      farthest = i;
      if (!passage_.is_free(stop, end)) continue;
      if (!best || value(way, here, i) > value(way, here, *best)) best = i;
    }
    return best ? best : farthest;
  }

  // Room around, and not too near either end.
  double value(const std::vector<std::uint32_t>& way, std::size_t here, std::size_t i) const {
    const double share = static_cast<double>(i - here) / static_cast<double>(way.size() - here);
    return std::min<double>(floor_.cells()[way[i]].clearance, 0.5) + 2 * share * (1 - share);
  }

  // Keeps the first `count` viewpoints only.
  void start_from(std::size_t count) {
    const std::vector<std::uint32_t> kept(cells_.begin(),
                                          cells_.begin() + static_cast<std::ptrdiff_t>(count));
    cells_.clear();
    viewpoints_.clear();
    parent_.clear();
    for (const std::uint32_t cell : kept) add(cell);
  }

  const mesh::WalkableFloor& floor_;
  const Passage& passage_;
  const std::function<PlacedViewpoint(std::uint32_t)>& placed_;
  std::vector<std::uint32_t>& cells_;
  std::vector<PlacedViewpoint> viewpoints_;
  std::vector<std::size_t> parent_;
  std::set<std::uint32_t> given_up_;
};

}  // namespace

void join_parts(const mesh::WalkableFloor& floor, const Passage& passage,
                const std::function<PlacedViewpoint(std::uint32_t)>& placed,
                std::vector<std::uint32_t>& cells) {
  Joiner(floor, passage, placed, cells).run();
}

}  // namespace enfilade::graph::detail
