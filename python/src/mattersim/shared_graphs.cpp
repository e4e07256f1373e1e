#include "python/src/mattersim/shared_graphs.h"

#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "enfilade/scan/connectivity.h"

namespace enfilade::python::mattersim {
namespace {

// Never freed: Python ends before static objects are destroyed. Guarded by the GIL.
using Registry = std::map<std::pair<std::string, std::string>, std::shared_ptr<SharedGraphs>>;
Registry& registry() {
  static auto* kept = new Registry;
  return *kept;
}

// Paths are relative to the current working directory, as in the old simulator.
std::string absolute(const std::string& folder) {
  std::error_code error;
  const auto path = std::filesystem::canonical(folder, error);
  return error ? folder : path.string();
}

std::string state_of(const std::filesystem::path& file) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(file, error).time_since_epoch().count();
  return error ? "" : std::to_string(time);
}

nb::object text(const std::string& s) {
  return own(PyUnicode_FromStringAndSize(s.data(), static_cast<Py_ssize_t>(s.size())));
}

}  // namespace

SharedGraphs::SharedGraphs(std::shared_ptr<const graph::GraphSet> set)
    : set_(std::move(set)), names_(set_->size()) {
  for (const std::string& scan : set_->scans()) scan_names_.push_back(text(scan));
}

std::shared_ptr<SharedGraphs> SharedGraphs::of_folder(const std::string& folder) {
  const std::string path = absolute(folder);
  auto& kept = registry()[{path, state_of(std::filesystem::path(path) / "scans.txt")}];
  if (!kept) kept = std::make_shared<SharedGraphs>(graph::GraphSet::open(path));
  return kept;
}

std::shared_ptr<SharedGraphs> SharedGraphs::of_scan(const std::string& folder,
                                                    const std::string& scan) {
  const std::string path = absolute(folder);
  scan::require_scan_id(scan);
  const auto file = scan::connectivity_file(path, scan);
  auto& kept = registry()[{file.string(), state_of(file)}];
  if (!kept) {
    std::vector<graph::NavGraph> graphs;
    graphs.emplace_back(scan::load_connectivity(path, scan));
    kept = std::make_shared<SharedGraphs>(graph::GraphSet::of(std::move(graphs)));
  }
  return kept;
}

const std::vector<ViewpointNames>& SharedGraphs::names(ScanIndex scan) {
  std::vector<ViewpointNames>& names = names_[scan.at()];
  const graph::NavGraph& graph = set_->graph(scan);
  if (!names.empty() || graph.size() == 0) return names;
  names.reserve(graph.size());
  const auto number = [](float value) {
    return own(PyFloat_FromDouble(static_cast<double>(value)));
  };
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    const Vec3f p = graph.position(v);
    names.push_back(
        {text(graph.id(v)), own(PyLong_FromSize_t(i)), number(p.x), number(p.y), number(p.z)});
  }
  return names;
}

}  // namespace enfilade::python::mattersim
