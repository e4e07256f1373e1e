#include "enfilade/graph/graph_set.h"

#include <fmt/format.h>
#include <atomic>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/threads.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::graph {

// Not std::call_once, which on some targets hangs once its function has thrown (GCC bug 66146), and
// a graph file may well be broken. The atomic keeps readers off the mutex.
struct GraphSet::Slot {
  std::atomic<const NavGraph*> ready = nullptr;
  std::mutex mutex;
  std::unique_ptr<const NavGraph> graph;
};

GraphSet::GraphSet(std::string origin, std::vector<std::string> scans)
    : origin_(std::move(origin)),
      scans_(std::move(scans)),
      slots_(std::make_unique<Slot[]>(scans_.size())) {}

GraphSet::~GraphSet() = default;

std::shared_ptr<const GraphSet> GraphSet::open(const std::filesystem::path& directory) {
  return open(directory, scan::load_scan_list(directory));
}

std::shared_ptr<const GraphSet> GraphSet::open(const std::filesystem::path& directory,
                                               std::vector<std::string> scans) {
  std::set<std::string_view> seen;
  for (const std::string& scan : scans) {
    if (seen.insert(scan).second) continue;
    throw ArgumentError(fmt::format("scans: {} twice; each may be named once", quote(scan)));
  }
  return std::shared_ptr<const GraphSet>(new GraphSet(directory.string(), std::move(scans)));
}

std::shared_ptr<const GraphSet> GraphSet::open_shared(const std::filesystem::path& directory) {
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::weak_ptr<const GraphSet>> opened;
  std::error_code unknown;  // open() says what is wrong
  std::filesystem::path key = std::filesystem::weakly_canonical(directory, unknown);
  if (unknown) key = directory;
  const std::scoped_lock lock(mutex);
  std::shared_ptr<const GraphSet> set = opened[key].lock();
  if (!set) opened[key] = set = open(directory);
  return set;
}

std::shared_ptr<const GraphSet> GraphSet::of(std::vector<NavGraph> graphs) {
  std::vector<std::string> scans;
  for (const NavGraph& graph : graphs) scans.push_back(graph.scan());
  std::shared_ptr<GraphSet> set(new GraphSet("<memory>", std::move(scans)));
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    if (set->at(graphs[i].scan()) != ScanIndex(i)) {
      throw ArgumentError(fmt::format("two graphs of scan {} in one set", quote(graphs[i].scan())));
    }
    Slot& slot = set->slots_[i];
    slot.graph = std::make_unique<NavGraph>(std::move(graphs[i]));
    slot.ready = slot.graph.get();
  }
  return set;
}

std::optional<ScanIndex> GraphSet::find(std::string_view scan) const {
  // A data set has tens of scans, and each is looked up once an episode.
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    if (scans_[i] == scan) return ScanIndex(i);
  }
  return std::nullopt;
}

ScanIndex GraphSet::at(std::string_view scan) const {
  if (const auto index = find(scan)) return *index;
  throw LookupError(
      fmt::format("scan {} is not one of the {} scans of {}", quote(scan), size(), origin_));
}

const NavGraph& GraphSet::graph(ScanIndex scan) const {
  EN_CHECK_LT(scan.at(), size());
  Slot& slot = slots_[scan.at()];
  if (const NavGraph* graph = slot.ready.load(std::memory_order_acquire)) return *graph;
  const std::scoped_lock lock(slot.mutex);
  if (!slot.graph) {
    slot.graph = std::make_unique<NavGraph>(scan::load_connectivity(origin_, scans_[scan.at()]));
    slot.ready.store(slot.graph.get(), std::memory_order_release);
  }
  return *slot.graph;
}

void GraphSet::load_all(int threads) const {
  parallel_for(size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) graph(ScanIndex(i));
  });
}

Location GraphSet::locate(std::string_view scan, std::string_view viewpoint) const {
  const ScanIndex index = at(scan);
  const NavGraph& nav = graph(index);
  const auto found = nav.find(viewpoint);
  if (!found) {
    throw LookupError(fmt::format("viewpoint {} is not one of the {} of scan {}", quote(viewpoint),
                                  nav.size(), scan));
  }
  if (!nav.included(*found)) {
    throw LookupError(
        fmt::format("viewpoint {} of scan {} is excluded from its graph", quote(viewpoint), scan));
  }
  return {index, *found};
}

}  // namespace enfilade::graph
