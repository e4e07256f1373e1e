// Graphs and Graph: navigation graphs.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <memory>
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

nb::list edges(const Graph& g) {
  nb::list rows;
  for (std::size_t v = 0; v < g.graph->size(); ++v) {
    const ViewpointIndex from(v);
    for (const graph::Edge& edge : g.graph->edges(from)) {
      // Each edge once, one-way edges included.
      if (edge.target < from && g.graph->edge(edge.target, from) != nullptr) continue;
      rows.append(nb::make_tuple(g.graph->id(from), g.graph->id(edge.target), edge.length));
    }
  }
  return rows;
}

// (m, 2) indices, and (m) metres; an edge in both directions is listed twice.
nb::tuple edge_arrays(const Graph& g) {
  std::vector<std::uint32_t> pairs;
  std::vector<double> lengths;
  for (std::size_t v = 0; v < g.graph->size(); ++v) {
    for (const graph::Edge& edge : g.graph->edges(ViewpointIndex(v))) {
      pairs.insert(pairs.end(), {static_cast<std::uint32_t>(v), edge.target.value});
      lengths.push_back(edge.length);
    }
  }
  const std::size_t count = lengths.size();
  return nb::make_tuple(owned_array(std::move(pairs), count, 2),
                        owned_array(std::move(lengths), count));
}

nb::object distances(const Graph& g) {
  const std::size_t n = g.graph->size();
  std::vector<double> values(n * n);
  {
    const nb::gil_scoped_release unlocked;
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) {
        values[a * n + b] = g.graph->distance(ViewpointIndex(a), ViewpointIndex(b));
      }
    }
  }
  return owned_array(std::move(values), n, n);
}

void bind_graph_arrays(nb::class_<Graph>& c) {
  c.def("edges", edges, nb::sig("def edges(self) -> list[tuple[str, str, float]]"),
        "(from, to, metres), each edge once, for networkx's add_weighted_edges_from().")
      .def("edge_arrays", edge_arrays,
           nb::sig("def edge_arrays(self) -> tuple[numpy.typing.NDArray[numpy.uint32], "
                   "numpy.typing.NDArray[numpy.float64]]"),
           "(m, 2) indices from and to, and (m,) metres; an edge in both directions is listed "
           "twice.")
      .def("distances", distances,
           nb::sig("def distances(self) -> numpy.typing.NDArray[numpy.float64]"),
           "(n, n) lengths of shortest paths, metres, by index; inf where there is none. The "
           "result of networkx's all_pairs_dijkstra_path_length(), in milliseconds.");
}

void bind_graph(nb::module_& m) {
  nb::class_<Graph> c(
      m, "Graph",
      "The viewpoints of one scan and the edges between them. Immutable. Iterates over ids.");
  c.def_prop_ro(
       "scan", [](const Graph& g) { return g.graph->scan(); }, "Name of the scan.")
      .def("__len__", [](const Graph& g) { return g.graph->size(); })
      .def(
          "__iter__", [](const Graph& g) { return nb::cast(viewpoints(g)).attr("__iter__")(); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[str]"), "Ids, as `viewpoints`.")
      .def("__contains__",
           [](const Graph& g, const std::string& v) { return g.graph->find(v).has_value(); })
      .def(
          "__reduce__",
          [](const Graph& g) {
            return nb::make_tuple(nb::module_::import_("operator").attr("getitem"),
                                  nb::make_tuple(g.set, g.graph->scan()));
          },
          nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
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
          "viewpoint"_a, "Whether agents can be at a viewpoint.")
      .def(
          "index", [](const Graph& g, const std::string& v) { return g.at(v).value; },
          "viewpoint"_a, "Index in `viewpoints`: MatterSim's `ix`. Raises UnknownNameError.")
      .def("neighbours", neighbours, "viewpoint"_a, "Ids of the viewpoints that an edge leads to.")
      .def(
          "distance",
          [](const Graph& g, const std::string& a, const std::string& b) {
            return g.graph->distance(g.at(a), g.at(b));
          },
          "a"_a, "b"_a,
          "Length of the shortest path, metres; inf if there is none. Raises UnknownNameError.")
      .def("path", path, "a"_a, "b"_a,
           "Ids of the shortest path, both ends included; None if there is none.")
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
  bind_graph_arrays(c);
}

Origins<GraphSet, std::string>& folders() {
  static Origins<GraphSet, std::string> known;
  return known;
}

std::shared_ptr<const GraphSet> open_graphs(const std::filesystem::path& folder) {
  std::shared_ptr<const GraphSet> set;
  {
    const nb::gil_scoped_release unlocked;
    set = GraphSet::open_shared(folder);
  }
  folders().put(set, std::filesystem::absolute(folder).string());
  return set;
}

// Graphs of a folder are opened again; those of a data set's stores come from the data set.
nb::tuple reduce_graphs(nb::handle self) {
  if (nb::hasattr(self, "_folder")) {
    return nb::make_tuple(nb::module_::import_("enfilade._dataset").attr("_graphs_of"),
                          nb::make_tuple(self.attr("_folder")));
  }
  if (const std::string* folder = folders().find(nb::cast<const GraphSet&>(self))) {
    return nb::make_tuple(self.type(), nb::make_tuple(*folder));
  }
  throw nb::type_error("these graphs are of no folder: pickle their Dataset");
}

}  // namespace

ViewpointIndex find_viewpoint(const NavGraph& graph, const std::string& id) {
  if (const auto found = graph.find(id)) return *found;
  throw LookupError("viewpoint '" + id + "' is not in the graph of scan " + graph.scan());
}

void bind_graphs(nb::module_& m) {
  bind_graph(m);
  nb::class_<GraphSet>(m, "Graphs",
                       "The scans of a folder of <scan>_connectivity.json and scans.txt. A graph "
                       "is read at first use, once per process.",
                       nb::dynamic_attr())
      .def(nb::new_(&open_graphs), "folder"_a,
           "Raises FileError or InvalidInput for a folder without a scans.txt.")
      .def("__reduce__", reduce_graphs, nb::sig("def __reduce__(self) -> tuple[typing.Any, ...]"))
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
          "scan"_a, "Index in `scans`. Raises UnknownNameError.")
      .def(
          "locate",
          [](const GraphSet& s, const std::string& scan, const std::string& viewpoint) {
            const graph::Location found = s.locate(scan, viewpoint);
            return std::tuple(found.scan.value, found.viewpoint.value);
          },
          "scan"_a, "viewpoint"_a,
          "Indices of an included viewpoint: its scan, then itself. Raises UnknownNameError.")
      .def("load_all", &GraphSet::load_all, "threads"_a = 0,
           nb::call_guard<nb::gil_scoped_release>(),
           "Reads all graphs that are not read yet; threads 0: all cores. Raises FileError, "
           "InvalidInput.");
}

}  // namespace enfilade::python
