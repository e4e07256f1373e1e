#include "tests/conformance/replay.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <variant>

namespace enfilade::tests {
namespace {

class Comparer {
 public:
  Comparer(double tolerance, Comparison& result) : tolerance_(tolerance), result_(result) {}

  void text(std::string_view field, const std::string& expected, const std::string& got) {
    if (expected != got) add(field, expected, got);
  }
  void integer(std::string_view field, std::int64_t expected, std::int64_t got) {
    if (expected != got) add(field, fmt::to_string(expected), fmt::to_string(got));
  }
  void real(std::string_view field, double expected, double got) {
    if (std::bit_cast<std::uint64_t>(expected) == std::bit_cast<std::uint64_t>(got)) return;
    result_.identical = false;
    if (!(std::abs(expected - got) <= tolerance_)) {  // also refuses NaN
      add(field, fmt::format("{:.17g}", expected), fmt::format("{:.17g}", got));
    }
  }

 private:
  void add(std::string_view field, std::string expected, std::string got) {
    result_.identical = false;
    result_.mismatches.push_back({std::string(field), std::move(expected), std::move(got)});
  }

  double tolerance_;
  Comparison& result_;
};

void compare_navigable(const std::vector<TraceNavigable>& expected, const sim::StateSpans& got,
                       const graph::NavGraph& graph, Comparer& compare) {
  const std::size_t n = got.navigable_count[0];
  compare.integer("nav.length", static_cast<std::int64_t>(expected.size()),
                  static_cast<std::int64_t>(n));
  for (std::size_t i = 0; i < std::min(n, expected.size()); ++i) {
    const auto field = [i](std::string_view name) { return fmt::format("nav[{}].{}", i, name); };
    const TraceNavigable& row = expected[i];
    const ViewpointIndex viewpoint = got.navigable_viewpoint[i];
    compare.text(field("viewpointId"), row.viewpoint, graph.id(viewpoint));
    compare.integer(field("ix"), row.ix, viewpoint.value);
    compare.real(field("rel_heading"), row.rel_heading, got.navigable_rel_heading[i]);
    compare.real(field("rel_elevation"), row.rel_elevation, got.navigable_rel_elevation[i]);
    compare.real(field("rel_distance"), row.distance, got.navigable_distance[i]);
  }
}

void compare_state(const TraceState& expected, const sim::StateSpans& got,
                   const graph::NavGraph& graph, Comparer& compare) {
  const ViewpointIndex viewpoint = got.viewpoint[0];
  const Vec3f position = graph.position(viewpoint);
  compare.text("scanId", expected.scan, graph.scan());
  compare.integer("step", expected.step, got.step[0]);
  compare.text("viewpointId", expected.viewpoint, graph.id(viewpoint));
  compare.integer("ix", expected.ix, viewpoint.value);
  compare.real("x", expected.x, static_cast<double>(position.x));
  compare.real("y", expected.y, static_cast<double>(position.y));
  compare.real("z", expected.z, static_cast<double>(position.z));
  compare.real("heading", expected.heading, got.heading[0]);
  compare.real("elevation", expected.elevation, got.elevation[0]);
  compare.integer("viewIndex", expected.view_index, got.view_index[0]);
  compare_navigable(expected.navigable, got, graph, compare);
}

}  // namespace

Replay::Replay(std::shared_ptr<const graph::GraphSet> graphs, const TraceHeader& header,
               double tolerance)
    : graphs_(std::move(graphs)), tolerance_(tolerance) {
  for (const auto& [name, config] : header.configs) {
    bodies_.emplace(name, Body{sim::Simulator(graphs_, config),
                               sim::StateBuffer(config.batch_size, config.max_navigable)});
  }
}

void Replay::act(Body& body, const TraceStep& step) const {
  const sim::StateSpans out = body.buffer.spans();
  if (const auto* start = std::get_if<TraceStart>(&step.action)) {
    const sim::EpisodeStart ours{graphs_->locate(step.scan, start->viewpoint),
                                 Radians(start->heading), Radians(start->elevation)};
    body.simulator.new_episodes({&ours, 1}, out);
  } else {
    body.simulator.step({&std::get<sim::Action>(step.action), 1}, out);
  }
}

Comparison Replay::compare(const TraceStep& step) {
  Body& body = bodies_.at(step.config);
  Comparison result;
  Comparer comparer(tolerance_, result);
  try {
    act(body, step);
  } catch (const ArgumentError& error) {  // refused, or an action before any start
    comparer.text("action", "is carried out", error.what());
    return result;
  }
  const sim::StateSpans got = body.buffer.spans();
  compare_state(step.state, got, graphs_->graph(got.scan[0]), comparer);
  return result;
}

}  // namespace enfilade::tests
