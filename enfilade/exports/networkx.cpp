#include "enfilade/exports/networkx.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/exports/detail/json_text.h"
#include "enfilade/exports/detail/pickle_writer.h"

namespace enfilade::exports {
namespace {

using detail::PickleWriter;
using graph::Edge;
using graph::NavGraph;

std::vector<ViewpointIndex> included(const NavGraph& graph) {
  std::vector<ViewpointIndex> found;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (graph.included(ViewpointIndex(i))) found.emplace_back(i);
  }
  return found;
}

/// The ids of all viewpoints as JSON has them.
std::vector<std::string> quoted_ids(const NavGraph& graph) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    ids.push_back(detail::json_string(graph.id(ViewpointIndex(i))));
  }
  return ids;
}

/// A text of every pair that is in reach, by from and to.
template <class Write>
std::string all_pairs(const NavGraph& graph, const std::vector<std::string>& ids,
                      const Write& write) {
  const std::vector<ViewpointIndex> all = included(graph);
  std::string text = "{";
  for (const ViewpointIndex a : all) {
    text += text.size() > 1 ? ",\n" : "\n";
    text += ids[a.at()] + ": {";
    bool first = true;
    for (const ViewpointIndex b : all) {
      if (!std::isfinite(graph.distance(a, b))) continue;
      if (!std::exchange(first, false)) text += ", ";
      text += ids[b.at()] + ": ";
      text += write(a, b);
    }
    text += '}';
  }
  return text + "\n}\n";
}

bool both_ways(const NavGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (const Edge& edge : graph.edges(ViewpointIndex(i))) {
      if (graph.edge(edge.target, ViewpointIndex(i)) == nullptr) return false;
    }
  }
  return true;
}

/// Pickles one graph, by the attributes that networkx keeps in its objects: `graph`, `_node`, and
/// `_adj`, of a DiGraph `_succ`, the same, and `_pred`. The dictionary of an edge is one object,
/// in whatever direction it is looked up.
class GraphPickler {
 public:
  GraphPickler(PickleWriter& out, const NavGraph& graph)
      : out_(out), graph_(graph), all_(included(graph)), undirected_(both_ways(graph)) {}

  void write() {
    out_.global(undirected_ ? "networkx.classes.graph" : "networkx.classes.digraph",
                undirected_ ? "Graph" : "DiGraph");
    out_.empty_tuple();
    out_.make_object();
    out_.empty_dictionary();
    out_.mark();
    out_.text("graph");
    out_.empty_dictionary();
    out_.text("_node");
    write_nodes();
    out_.text("_adj");
    write_neighbours(successors());
    if (!undirected_) {
      const std::uint32_t adjacency = out_.keep();
      out_.text("_succ");
      out_.again(adjacency);
      out_.text("_pred");
      write_neighbours(predecessors());
    }
    out_.text("__networkx_cache__");  // newer versions look for it
    out_.empty_dictionary();
    out_.set_items();
    out_.set_state();
  }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  /// Per viewpoint, the edges to write: the other end, and which edge's dictionary.
  using Neighbours = std::vector<std::vector<std::pair<ViewpointIndex, Pair>>>;

  Pair edge_name(ViewpointIndex a, ViewpointIndex b) const {
    return undirected_ && b < a ? Pair(b.value, a.value) : Pair(a.value, b.value);
  }

  Neighbours successors() const {
    Neighbours found(graph_.size());
    for (const ViewpointIndex v : all_) {
      for (const Edge& edge : graph_.edges(v)) {
        found[v.at()].emplace_back(edge.target, edge_name(v, edge.target));
      }
    }
    return found;
  }
  Neighbours predecessors() const {
    Neighbours found(graph_.size());
    for (const ViewpointIndex v : all_) {
      for (const Edge& edge : graph_.edges(v)) {
        found[edge.target.at()].emplace_back(v, edge_name(v, edge.target));
      }
    }
    return found;
  }

  void write_point(const char* name, double x, double y, double z) {
    out_.text(name);
    out_.empty_list();
    out_.mark();
    for (const double value : {x, y, z}) out_.number(value);
    out_.append_items();
  }

  void write_nodes() {
    out_.empty_dictionary();
    out_.mark();
    for (const ViewpointIndex v : all_) {
      const Vec3f at = graph_.position(v);
      out_.text(graph_.id(v));
      out_.empty_dictionary();
      out_.mark();
      write_point("position", at.x, at.z, -at.y);
      write_point("world_position", at.x, at.y, at.z);
      out_.set_items();
    }
    out_.set_items();
  }

  void write_neighbours(const Neighbours& neighbours) {
    out_.empty_dictionary();
    out_.mark();
    for (const ViewpointIndex v : all_) {
      out_.text(graph_.id(v));
      out_.empty_dictionary();
      out_.mark();
      for (const auto& [other, name] : neighbours[v.at()]) {
        out_.text(graph_.id(other));
        write_edge(name);
      }
      out_.set_items();
    }
    out_.set_items();
  }

  void write_edge(const Pair& name) {
    if (const auto written = edges_.find(name); written != edges_.end()) {
      out_.again(written->second);
      return;
    }
    out_.empty_dictionary();
    edges_[name] = out_.keep();
    out_.mark();
    out_.text("weight");
    out_.number(graph_.edge(ViewpointIndex(name.first), ViewpointIndex(name.second))->length);
    out_.set_items();
  }

  PickleWriter& out_;
  const NavGraph& graph_;
  std::vector<ViewpointIndex> all_;
  bool undirected_;
  std::map<Pair, std::uint32_t> edges_;
};

}  // namespace

std::string all_distances(const NavGraph& graph) {
  return all_pairs(graph, quoted_ids(graph), [&](ViewpointIndex a, ViewpointIndex b) {
    return detail::json_number(graph.distance(a, b));
  });
}

std::string all_paths(const NavGraph& graph) {
  const std::vector<std::string> ids = quoted_ids(graph);
  return all_pairs(graph, ids, [&](ViewpointIndex a, ViewpointIndex b) {
    const std::optional<std::vector<ViewpointIndex>> path = graph.path(a, b);
    std::string text = "[";
    for (const ViewpointIndex v : *path) {
      if (text.size() > 1) text += ", ";
      text += ids[v.at()];
    }
    return text + "]";
  });
}

std::string connectivity_pickle(const graph::GraphSet& graphs) {
  PickleWriter out;
  out.empty_dictionary();
  out.mark();
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const NavGraph& graph = graphs.graph(ScanIndex(i));
    out.text(graph.scan());
    GraphPickler(out, graph).write();
  }
  out.set_items();
  return out.finish();
}

}  // namespace enfilade::exports
