#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/draw/floor_plan.h"

namespace enfilade::draw {
namespace {

constexpr double kWindow = 1.2;  // floors of one storey differ by less (steps, sloping ground)
constexpr double kApart = 1.8;   // storeys are farther apart: people stand in the lower one
constexpr double kCore = 0.25;   // around the median floor; stairs have few viewpoints so level
constexpr double kLeastShare = 0.03;
constexpr double kLeastViewpoints = 3;

struct Mode {
  double floor = 0;
  std::size_t count = 0;
};

// The window of kWindow metres that holds most of the sorted floors, kApart from each of `taken`
// and with `least` of its floors about at its median; of equally full ones the lowest.
Mode densest_window(const std::vector<double>& floors, const std::vector<double>& taken,
                    std::size_t least) {
  Mode best;
  for (std::size_t begin = 0, end = 0; begin < floors.size(); ++begin) {
    while (end < floors.size() && floors[end] - floors[begin] <= kWindow) ++end;
    const std::size_t count = end - begin;
    const double floor = floors[begin + count / 2];
    if (count <= best.count) continue;
    const auto near = [&](double f) { return std::abs(f - floor) <= kCore; };
    if (std::ranges::any_of(taken, [&](double t) { return std::abs(floor - t) < kApart; }) ||
        static_cast<std::size_t>(std::ranges::count_if(floors, near)) < least) {
      continue;
    }
    best = {floor, count};
  }
  return best;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

std::vector<Storey> find_storeys(const graph::NavGraph& graph) {
  std::vector<double> sorted;
  std::vector<std::pair<ViewpointIndex, double>> floors;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    if (!graph.included(v)) continue;
    floors.emplace_back(v, static_cast<double>(graph.position(v).z) - graph.height(v));
    sorted.push_back(floors.back().second);
  }
  std::ranges::sort(sorted);
  const auto least = static_cast<std::size_t>(
      std::ceil(std::max(kLeastViewpoints, kLeastShare * static_cast<double>(sorted.size()))));
  std::vector<double> modes;  // the largest storey has no least number of viewpoints
  for (Mode mode = densest_window(sorted, modes, 0); mode.count > 0;
       mode = densest_window(sorted, modes, least)) {
    modes.push_back(mode.floor);
  }
  std::ranges::sort(modes);
  std::vector<Storey> storeys;
  for (const double mode : modes) storeys.push_back({mode, {}});
  std::vector<std::vector<double>> members(modes.size());
  for (const auto& [v, floor] : floors) {
    const std::size_t s = nearest_storey(storeys, floor);
    storeys[s].viewpoints.push_back(v);
    members[s].push_back(floor);
  }
  for (std::size_t s = 0; s < storeys.size(); ++s) storeys[s].floor = median(members[s]);
  return storeys;
}

std::size_t nearest_storey(const std::vector<Storey>& storeys, double floor) {
  const auto nearest = std::ranges::min_element(
      storeys, {}, [floor](const Storey& s) { return std::abs(s.floor - floor); });
  return static_cast<std::size_t>(nearest - storeys.begin());
}

}  // namespace enfilade::draw
