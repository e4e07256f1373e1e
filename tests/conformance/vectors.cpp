#include "tests/conformance/vectors.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/sim/simulator.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::tests {
namespace {

using json::Element;
using json::Faults;
using json::Path;

constexpr std::size_t kExamples = 10;

// Nearly all of (-pi/2, pi/2): the vectors look up and down further than an agent does.
constexpr sim::ElevationLimits kWideLimits{Radians(-1.57), Radians(1.57)};

// Reads names and numbers of cases; what is wrong goes into `faults`, and a stand-in is returned.
class CaseReader {
 public:
  CaseReader(const graph::GraphSet& graphs, Faults& faults) : graphs_(graphs), faults_(faults) {}

  template <std::size_t N>
  std::optional<std::array<Element, N>> fields(Element element,
                                               const std::array<json::Field, N>& wanted,
                                               const Path& path) {
    std::array<std::optional<Element>, N> found;
    if (!json::fields(element, wanted, found, path, faults_)) return std::nullopt;
    std::array<Element, N> values;
    for (std::size_t i = 0; i < N; ++i) values[i] = *found[i];
    return values;
  }

  double number(Element element, const Path& path) {
    return json::number(element, path, faults_).value_or(0);
  }

  std::string text(Element element, const Path& path) {
    return std::string(json::string(element, path, faults_).value_or(""));
  }

  std::uint32_t pixels(Element element, const Path& path) {
    const std::int64_t value = json::integer(element, path, faults_).value_or(1);
    if (value > 0 && value <= 65536) return static_cast<std::uint32_t>(value);
    faults_.error(path, "bad-size", fmt::format("{} pixels; 1 to 65536 are allowed", value));
    return 1;
  }

  std::optional<ScanIndex> scan(Element element, const Path& path) {
    const auto id = json::string(element, path, faults_);
    if (!id) return std::nullopt;
    const auto found = graphs_.find(*id);
    if (!found) {
      faults_.error(path, "unknown-scan",
                    fmt::format("{:?} is not one of the {} scans", *id, graphs_.size()));
    }
    return found;
  }

  std::optional<ViewpointIndex> viewpoint(Element element, ScanIndex scan, const Path& path) {
    const auto id = json::string(element, path, faults_);
    if (!id) return std::nullopt;
    const graph::NavGraph& graph = graphs_.graph(scan);
    const auto found = graph.find(*id);
    if (found && graph.included(*found)) return found;
    faults_.error(path, "unknown-viewpoint",
                  fmt::format("{:?} is not an included viewpoint of {}", *id, graph.scan()));
    return std::nullopt;
  }

  std::vector<ViewpointIndex> viewpoints(Element element, ScanIndex scan, const Path& path) {
    std::vector<ViewpointIndex> result;
    const auto elements = json::array(element, path, faults_);
    if (!elements) return result;
    std::size_t i = 0;
    for (const Element id : *elements) {
      if (const auto v = viewpoint(id, scan, Path(path, i++))) result.push_back(*v);
    }
    if (i == 0) faults_.error(path, "empty-path", "no viewpoint; one at least is expected");
    return result;
  }

  Faults& faults() { return faults_; }

 private:
  const graph::GraphSet& graphs_;
  Faults& faults_;
};

// --- metrics ---

struct MetricCase {
  std::string id;
  ScanIndex scan;
  std::vector<ViewpointIndex> trajectory, reference;
  std::vector<std::pair<tasks::MetricField, double>> expected;
};

std::vector<std::pair<tasks::MetricField, double>> read_expected(Element element, const Path& path,
                                                                 CaseReader& reader) {
  std::vector<std::pair<tasks::MetricField, double>> expected;
  const auto members = json::object(element, path, reader.faults());
  if (!members) return expected;
  const auto& known = tasks::kMetricFields;
  for (const auto member : *members) {
    const Path place(path, member.key);
    const auto field = std::ranges::find_if(
        known, [&member](const tasks::MetricField& f) { return member.key == f.name; });
    if (field == known.end()) {
      reader.faults().error(place, "unknown-metric", "there is no metric of this name");
    } else {
      expected.emplace_back(*field, reader.number(member.value, place));
    }
  }
  return expected;
}

MetricCase read_metric_case(Element element, const Path& path, CaseReader& reader) {
  MetricCase one;
  constexpr std::array<json::Field, 5> kFields{
      {{"id"}, {"scan"}, {"trajectory"}, {"reference"}, {"metrics"}}};
  const auto f = reader.fields(element, kFields, path);
  if (!f) return one;
  one.id = reader.text((*f)[0], Path(path, "id"));
  one.expected = read_expected((*f)[4], Path(path, "metrics"), reader);
  const auto scan = reader.scan((*f)[1], Path(path, "scan"));
  if (!scan) return one;
  one.scan = *scan;
  one.trajectory = reader.viewpoints((*f)[2], *scan, Path(path, "trajectory"));
  one.reference = reader.viewpoints((*f)[3], *scan, Path(path, "reference"));
  return one;
}

// What differs, or nothing.
std::string compare(const MetricCase& one, const graph::GraphSet& graphs,
                    const tasks::MetricOptions& options, double tolerance) {
  const tasks::EpisodeMetrics m =
      compute_metrics(graphs.graph(one.scan), one.trajectory, one.reference, options);
  std::string text;
  for (const auto& [field, expected] : one.expected) {
    const double value = m.*field.field;
    if (std::abs(value - expected) <= tolerance) continue;
    text += fmt::format("{}{} is {}, expected {}", text.empty() ? "" : "; ", field.name, value,
                        expected);
  }
  return text.empty() ? text : fmt::format("{}: {}", one.id, text);
}

// --- navigable viewpoints ---

struct NavEntry {
  std::string viewpoint;
  std::array<double, 3> numbers{};  // relative heading, relative elevation, distance
};

struct NavCase {
  sim::EpisodeStart start;
  Camera camera;
  bool restricted = true;
  std::vector<NavEntry> expected;
};

std::vector<NavEntry> read_navigable(Element element, const Path& path, CaseReader& reader) {
  std::vector<NavEntry> entries;
  const auto rows = json::array(element, path, reader.faults());
  if (!rows) return entries;
  for (const Element row : *rows) {
    const Path place(path, entries.size());
    NavEntry& entry = entries.emplace_back();
    const auto values = json::array(row, place, reader.faults());
    if (!values) continue;
    if (values->size() != 4) {
      reader.faults().error(place, "bad-entry",
                            fmt::format("{}, not [viewpoint, rel_heading, rel_elevation, distance]",
                                        json::describe(row)));
      continue;
    }
    std::size_t i = 0;
    for (const Element value : *values) {
      const Path at(place, i);
      if (i == 0) {
        entry.viewpoint = reader.text(value, at);
      } else {
        entry.numbers[i - 1] = reader.number(value, at);
      }
      ++i;
    }
  }
  return entries;
}

NavCase read_nav_case(Element element, const Path& path, CaseReader& reader) {
  NavCase one;
  constexpr std::array<json::Field, 9> kFields{{{"scan"},
                                                {"viewpoint"},
                                                {"heading"},
                                                {"elevation"},
                                                {"width"},
                                                {"height"},
                                                {"vfov"},
                                                {"restricted"},
                                                {"navigable"}}};
  const auto f = reader.fields(element, kFields, path);
  if (!f) return one;
  if (const auto scan = reader.scan((*f)[0], Path(path, "scan"))) {
    const auto viewpoint = reader.viewpoint((*f)[1], *scan, Path(path, "viewpoint"));
    one.start.location = {*scan, viewpoint.value_or(ViewpointIndex())};
  }
  one.start.heading = Radians(reader.number((*f)[2], Path(path, "heading")));
  one.start.elevation = Radians(reader.number((*f)[3], Path(path, "elevation")));
  one.camera = {reader.pixels((*f)[4], Path(path, "width")),
                reader.pixels((*f)[5], Path(path, "height")),
                Radians(reader.number((*f)[6], Path(path, "vfov")))};
  try {
    validate(one.camera);
  } catch (const ArgumentError& error) {
    reader.faults().error(path, "bad-camera", error.what());
  }
  one.restricted = json::boolean((*f)[7], Path(path, "restricted"), reader.faults()).value_or(true);
  one.expected = read_navigable((*f)[8], Path(path, "navigable"), reader);
  return one;
}

std::vector<NavEntry> navigable(const NavCase& one,
                                const std::shared_ptr<const graph::GraphSet>& graphs) {
  const graph::NavGraph& graph = graphs->graph(one.start.location.scan);
  sim::SimulatorConfig config;
  config.camera = one.camera;
  config.navigation =
      one.restricted ? sim::Navigation::kRestricted : sim::Navigation::kUnrestricted;
  config.field_of_view = sim::FieldOfView::kLinear;
  config.elevation_limits = kWideLimits;
  config.max_navigable = graph.max_degree() + 1;
  sim::Simulator simulator(graphs, config);
  sim::StateBuffer buffer(1, config.max_navigable);
  const sim::StateSpans state = buffer.spans();
  simulator.new_episode(0, one.start, state);
  std::vector<NavEntry> entries;
  for (std::size_t k = 1; k < state.navigable_count[0]; ++k) {
    entries.push_back({graph.id(state.navigable_viewpoint[k]),
                       {state.navigable_rel_heading[k], state.navigable_rel_elevation[k],
                        state.navigable_distance[k]}});
  }
  return entries;
}

// What differs, or nothing.
std::string compare(const std::vector<NavEntry>& found, const std::vector<NavEntry>& expected,
                    double tolerance) {
  if (found.size() != expected.size()) {
    return fmt::format("{} viewpoints are navigable, expected {}", found.size(), expected.size());
  }
  constexpr std::array<const char*, 3> kNames{"rel_heading", "rel_elevation", "distance"};
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k].viewpoint != expected[k].viewpoint) {
      return fmt::format("navigable[{}] is {}, expected {}", k, found[k].viewpoint,
                         expected[k].viewpoint);
    }
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      if (std::abs(found[k].numbers[i] - expected[k].numbers[i]) <= tolerance) continue;
      return fmt::format("navigable[{}].{} is {}, expected {}", k, kNames[i], found[k].numbers[i],
                         expected[k].numbers[i]);
    }
  }
  return {};
}

// --- files ---

template <class Case>
std::vector<Case> read_cases(simdjson::dom::array elements, CaseReader& reader,
                             Case (*read)(Element, const Path&, CaseReader&)) {
  const Path root;
  const Path list(root, "cases");
  std::vector<Case> cases;
  for (const Element element : elements) {
    cases.push_back(read(element, Path(list, cases.size()), reader));
  }
  reader.faults().throw_if_errors();
  return cases;
}

void count(VectorReport& report, std::size_t place, const std::string& difference) {
  ++report.cases;
  if (difference.empty()) return;
  if (++report.mismatches <= kExamples) {
    report.examples.push_back(fmt::format("$.cases[{}]: {}", place, difference));
  }
}

double read_threshold(Element root, Faults& faults) {
  const tasks::MetricOptions usual;
  std::array<std::optional<Element>, 1> found;
  constexpr std::array<json::Field, 1> kFields{{{"threshold", false}}};
  const Path path;
  if (!json::fields(root, kFields, found, path, faults) || !found[0]) return usual.success_distance;
  const Path place(path, "threshold");
  const double threshold = json::number(*found[0], place, faults).value_or(1);
  if (threshold <= 0) {
    faults.error(place, "bad-threshold", fmt::format("{} m; more than 0 is expected", threshold));
  }
  return threshold;
}

}  // namespace

VectorReport check_vectors(const std::filesystem::path& file,
                           const std::shared_ptr<const graph::GraphSet>& graphs,
                           const VectorTolerances& tolerances) {
  const json::Document document = json::Document::load(file);
  Faults faults(document.name());
  CaseReader reader(*graphs, faults);
  const Path root;
  const auto top = reader.fields(document.root(), std::array<json::Field, 1>{{{"cases"}}}, root);
  simdjson::dom::array cases;
  if (top) cases = json::array((*top)[0], Path(root, "cases"), faults).value_or(cases);
  if (top && faults.errors() == 0 && cases.size() == 0) {
    faults.error(Path(root, "cases"), "no-cases", "no case to compare");
  }
  const tasks::MetricOptions options{read_threshold(document.root(), faults)};
  faults.throw_if_errors();
  VectorReport report;
  Element first;
  const bool nav = cases.at(0).get(first) == simdjson::SUCCESS && first.is_object() &&
                   first.at_key("navigable").error() == simdjson::SUCCESS;
  if (nav) {
    for (const NavCase& one : read_cases(cases, reader, read_nav_case)) {
      count(report, report.cases, compare(navigable(one, graphs), one.expected, tolerances.nav));
    }
  } else {
    for (const MetricCase& one : read_cases(cases, reader, read_metric_case)) {
      count(report, report.cases, compare(one, *graphs, options, tolerances.metrics));
    }
  }
  return report;
}

}  // namespace enfilade::tests
