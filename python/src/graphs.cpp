// Graphs and Graph: navigation graphs.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <tuple>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

using graph::GraphSet;
using graph::NavGraph;
using namespace nb::literals;

/// A graph that keeps its set alive.
struct Graph {
  std::shared_ptr<const GraphSet> set;
  const NavGraph* graph;

  ViewpointIndex at(const std::string& viewpoint) const {
    return find_viewpoint(*graph, viewpoint);
  }
  std::vector<std::string> names(const std::vector<ViewpointIndex>& indices) const {
    std::vector<std::string> names;
    for (const ViewpointIndex v : indices) names.push_back(graph->id(v));
    return names;
  }
};

Graph graph_of(const std::shared_ptr<const GraphSet>& set, const std::string& scan) {
  const nb::gil_scoped_release unlocked;
  return {set, &set->graph(scan)};
}

std::vector<std::string> viewpoints(const Graph& g) {
  std::vector<std::string> ids;
  for (std::size_t v = 0; v < g.graph->size(); ++v) ids.push_back(g.graph->id(ViewpointIndex(v)));
  return ids;
}

std::vector<std::string> neighbours(const Graph& g, const std::string& viewpoint) {
  std::vector<ViewpointIndex> targets;
  for (const graph::Edge& edge : g.graph->edges(g.at(viewpoint))) targets.push_back(edge.target);
  return g.names(targets);
}

std::optional<std::vector<std::string>> path(const Graph& g, const std::string& from,
                                             const std::string& to) {
  const auto found = g.graph->path(g.at(from), g.at(to));
  if (!found) return std::nullopt;
  return g.names(*found);
}

void bind_graph(nb::module_& m) {
  nb::class_<Graph>(m, "Graph", "The viewpoints of one scan and the edges between them. Immutable.")
      .def_prop_ro(
          "scan", [](const Graph& g) { return g.graph->scan(); }, "Name of the scan.")
      .def("__len__", [](const Graph& g) { return g.graph->size(); })
      .def_prop_ro("viewpoints", viewpoints, "Ids by index, excluded viewpoints too.")
      .def_prop_ro(
          "positions",
          [](nb::handle self) {
            const auto& p = nb::cast<const Graph&>(self).graph->positions();
            return array_of(reinterpret_cast<const float*>(p.data()), self, p.size(), 3);
          },
          nb::sig("def positions(self) -> numpy.typing.NDArray[numpy.float32]"),
          "(n, 3) float32, metres, world frame; a read-only view.")
      .def(
          "included",
          [](const Graph& g, const std::string& v) { return g.graph->included(g.at(v)); },
          "viewpoint"_a, "Whether agents may stand there.")
      .def(
          "index", [](const Graph& g, const std::string& v) { return g.at(v).value; },
          "viewpoint"_a, "Place in `viewpoints`: MatterSim's `ix`. Raises UnknownNameError.")
      .def("neighbours", neighbours, "viewpoint"_a, "Ids of where one can step to.")
      .def(
          "distance",
          [](const Graph& g, const std::string& a, const std::string& b) {
            return g.graph->distance(g.at(a), g.at(b));
          },
          "a"_a, "b"_a,
          "Shortest way along edges, metres; inf if there is none. Raises UnknownNameError.")
      .def("path", path, "a"_a, "b"_a, "That way's viewpoints, both ends too; None if none.")
      .def(
          "nearest",
          [](const Graph& g, std::tuple<float, float, float> p) {
            const auto [x, y, z] = p;
            std::optional<std::string> id;
            if (const auto v = g.graph->nearest({x, y, z})) id = g.graph->id(*v);
            return id;
          },
          "point"_a,
          "The included viewpoint nearest to a point, metres, world frame; None if there is none, "
          "or a coordinate is not finite.");
}

}  // namespace

ViewpointIndex find_viewpoint(const NavGraph& graph, const std::string& id) {
  if (const auto found = graph.find(id)) return *found;
  throw LookupError("viewpoint '" + id + "' is not in the graph of scan " + graph.scan());
}

void bind_graphs(nb::module_& m) {
  bind_graph(m);
  nb::class_<GraphSet>(
      m, "Graphs",
      "The scans of a folder of <scan>_connectivity.json and scans.txt. A graph is "
      "read when first used, once a process.")
      .def(nb::new_(&GraphSet::open_shared), "folder"_a,
           "Raises FileError or InvalidInput for a folder without a scans.txt.")
      .def("__len__", &GraphSet::size)
      .def(
          "__iter__", [](const GraphSet& g) { return nb::cast(g.scans()).attr("__iter__")(); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[str]"), "Names, as `scans`.")
      .def_prop_ro("scans", &GraphSet::scans, "Names by index.")
      .def("__contains__",
           [](const GraphSet& s, const std::string& scan) { return s.find(scan).has_value(); })
      .def("__getitem__", graph_of, "scan"_a, "Raises UnknownNameError.")
      .def(
          "index", [](const GraphSet& s, const std::string& scan) { return s.at(scan).value; },
          "scan"_a, "Place in `scans`. Raises UnknownNameError.")
      .def(
          "locate",
          [](const GraphSet& s, const std::string& scan, const std::string& viewpoint) {
            const graph::Location found = s.locate(scan, viewpoint);
            return std::tuple(found.scan.value, found.viewpoint.value);
          },
          "scan"_a, "viewpoint"_a,
          "Indices of an included viewpoint, of its scan first. Raises UnknownNameError.")
      .def(
          "load_all", &GraphSet::load_all, "threads"_a = 0,
          nb::call_guard<nb::gil_scoped_release>(),
          "Reads all that are not read yet; threads 0: all cores. Raises FileError, InvalidInput.");
}

}  // namespace enfilade::python
