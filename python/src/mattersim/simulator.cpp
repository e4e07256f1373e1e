#include "python/src/mattersim/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

#include "python/src/mattersim/arguments.h"

namespace enfilade::python::mattersim {
namespace {

constexpr std::size_t kNavigable = 32;        // rows of a list; Matterport3D's graphs need 14
constexpr std::size_t kAgentsWorthAGil = 16;  // below, a step is shorter than releasing the GIL
constexpr double kStep = kPi / 6;

class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds), begin_(Clock::now()) {}
  ~Stopwatch() { seconds_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& seconds_;
  Clock::time_point begin_;
};

int sign(double x) { return int{x > 0} - int{x < 0}; }

bool lists(const SharedGraphs& graphs, const std::string& scan) {
  return graphs.set()->find(scan).has_value();
}

std::size_t widest(const SharedGraphs& graphs, const std::vector<sim::EpisodeStart>& starts) {
  std::size_t rows = kNavigable;
  for (const sim::EpisodeStart& start : starts) {
    rows = std::max(rows, graphs.set()->graph(start.location.scan).max_degree() + 1);
  }
  return rows;
}

}  // namespace

Simulator::Walk::Walk(std::shared_ptr<SharedGraphs> shared, const sim::SimulatorConfig& config)
    : graphs(std::move(shared)), native(graphs->set(), config) {}

Simulator::Simulator() : options_(Options::from_environment()) {}
Simulator::~Simulator() = default;

// --- life

void Simulator::initialize() {
  const Busy busy(busy_);
  begin(Api::kV2);
}

void Simulator::init() {
  const Busy busy(busy_);
  begin(Api::kV1);
}

void Simulator::begin(Api api) {
  active_ = settings_;
  if (active_.width < 0 || active_.height < 0) {
    throw WrongOrder(fmt::format("camera resolution {} x {}: at least 1 x 1 is needed",
                                 active_.width, active_.height));
  }
  if (api == Api::kV1) active_.batch_size = 1;
  if (active_.batch_size > 0) validate(native_config(kNavigable));
  api_ = api;
  begun_ = true;
  started_ = false;
  camera_changed_ = path_changed_ = false;
  walk_.reset();
  pictures_.reset();
  if (seed_) {
    seed_stream();
  } else {  // v0.1 takes its seed from the clock
    random_ =
        sim::MatterSimRandom(api == Api::kV1 ? static_cast<std::uint64_t>(std::time(nullptr)) : 1);
  }
  make_states();
  if (active_.rendering && active_.preloading && active_.batch_size > 0) preload();
}

void Simulator::ensure_begun(Api api) {
  if (begun_ && api_ == api) return;
  if (!begun_) return begin(api);
  const bool one = api_ == Api::kV1;
  PyErr_Format(PyExc_TypeError,
               "%s was called, so %s are wanted: a Simulator speaks %s from then on",
               one ? "init()" : "initialize()", one ? "scalars" : "lists, one element an agent",
               one ? "v0.1" : "v0.2");
  throw nb::python_error();
}

void Simulator::make_states() {
  states_ = own(PyList_New(0));
  for (std::size_t i = 0; i < active_.batch_size; ++i) {
    const nb::object state = make_state(static_cast<std::uint32_t>(active_.width),
                                        static_cast<std::uint32_t>(active_.height));
    if (PyList_Append(states_.ptr(), state.ptr()) != 0) throw nb::python_error();
  }
}

void Simulator::close() {
  const Busy busy(busy_);
  begun_ = started_ = false;
  walk_.reset();
  pictures_.reset();
}

std::shared_ptr<SharedGraphs> Simulator::open_graphs(const std::string& scan) const {
  const std::string& folder = active_.nav_graph_path;
  if (api_ == Api::kV2) return SharedGraphs::of_folder(folder);
  try {
    auto all = SharedGraphs::of_folder(folder);
    if (lists(*all, scan)) return all;
  } catch (const FileError&) {  // v0.1 reads no scans.txt
  } catch (const InvalidInput&) {
  }
  return SharedGraphs::of_scan(folder, scan);
}

sim::SimulatorConfig Simulator::native_config(std::size_t max_navigable) const {
  using namespace sim;
  SimulatorConfig config = SimulatorConfig::mattersim();
  config.batch_size = active_.batch_size;
  config.camera = {static_cast<std::uint32_t>(active_.width),
                   static_cast<std::uint32_t>(active_.height),
                   Radians(active_.vertical_field_of_view)};
  if (active_.discretized) config.viewing = Viewing::kDiscretized;
  if (!active_.restricted && api_ != Api::kV1) config.navigation = Navigation::kUnrestricted;
  if (options_.perspective_view) config.field_of_view = FieldOfView::kPerspective;
  config.elevation_limits = active_.limits;
  config.max_navigable = max_navigable;
  return config;
}

// --- images

void Simulator::ensure_pictures(const SharedGraphs& graphs) {
  const sim::SimulatorConfig config = native_config(kNavigable);
  if (pictures_ && pictured_ == &graphs && pictures_->camera() == config.camera) return;
  std::string path = active_.dataset_path;
  if (path.empty()) path = api_ == Api::kV1 ? "./data" : "./data/v1/scans/";
  pictures_.emplace(open_panoramas(path, active_.nav_graph_path, graphs.set()->scans()), active_,
                    options_);
  pictured_ = &graphs;
  shown_ = false;
}

void Simulator::preload() {
  const Stopwatch watch(preload_seconds_);
  const auto graphs = open_graphs({});
  const nb::gil_scoped_release unlocked;
  graphs->set()->load_all();
  ensure_pictures(*graphs);
  for (std::size_t s = 0; s < graphs->set()->size(); ++s) {
    const graph::NavGraph& graph = graphs->set()->graph(ScanIndex(s));
    std::vector<ViewpointIndex> included;
    for (std::size_t v = 0; v < graph.size(); ++v) {
      if (graph.included(ViewpointIndex(v))) included.emplace_back(v);
    }
    pictures_->preload(ScanIndex(s), included);
  }
}

void Simulator::show_pictures() {
  if (!pictures_ || shown_) return;
  for (std::size_t i = 0; i < active_.batch_size; ++i) {
    SimStateObject& state = as_state(PyList_GetItem(states_.ptr(), static_cast<Py_ssize_t>(i)));
    const Pixels colour = pictures_->colour_of(i);
    put(state.rgb, make_mat(colour));
    put(state.depth, make_mat(pictures_->depth_of(i)));
    state.width = colour.width;
    state.height = colour.height;
  }
  shown_ = true;
}

// --- episodes

sim::MatterSimRandom& Simulator::stream() {
  if (!options_.one_stream) return random_;
  static sim::MatterSimRandom shared = random_;  // a copy of the first simulator's
  return shared;
}

ScanIndex Simulator::find_scan(const SharedGraphs& graphs, std::size_t agent,
                               const std::string& scan) const {
  if (const auto found = graphs.set()->find(scan)) return *found;
  throw UnknownScan(fmt::format("scan '{}' of environment {} of {} is not in {}/scans.txt", scan,
                                agent, active_.batch_size, active_.nav_graph_path));
}

graph::Location Simulator::locate(const SharedGraphs& graphs, std::size_t agent,
                                  const std::string& scan, const std::string& viewpoint) const {
  const ScanIndex found = find_scan(graphs, agent, scan);
  const graph::NavGraph& graph = graphs.set()->graph(found);
  const auto v = graph.find(viewpoint);
  if (!v) {
    throw LookupError(
        fmt::format("MatterSim: Could not find viewpointId: {} in scan {}, is viewpoint id valid?",
                    viewpoint, scan));
  }
  if (!graph.included(*v)) {
    throw LookupError(fmt::format(
        "MatterSim: ViewpointId: {}, is excluded from the connectivity graph of scan {}.",
        viewpoint, scan));
  }
  return {found, *v};
}

void Simulator::new_episode(PyObject* scans, PyObject* viewpoints, PyObject* headings,
                            PyObject* elevations) {
  const Busy busy(busy_);
  if (is_text(scans)) return start_scalar(scans, viewpoints, headings, elevations);
  const std::vector<std::string> scan = to_texts(scans, "scanId");
  const std::vector<std::string> viewpoint = to_texts(viewpoints, "viewpointId");
  ensure_begun(Api::kV2);
  const std::size_t n = active_.batch_size;
  if (scan.size() < n) too_short("scanId", scan.size(), n);
  if (viewpoint.size() < n) too_short("viewpointId", viewpoint.size(), n);
  to_angles(headings, "heading", n, headings_);
  to_angles(elevations, "elevation", n, elevations_);
  if (n == 0) return;
  const auto graphs = walk_ ? walk_->graphs : open_graphs({});
  std::vector<sim::EpisodeStart> starts;
  {
    const nb::gil_scoped_release unlocked;  // may read a graph
    for (std::size_t i = 0; i < n; ++i) {
      starts.push_back({locate(*graphs, i, scan[i], viewpoint[i]), Radians(headings_[i]),
                        Radians(elevations_[i])});
    }
  }
  start(graphs, starts);
}

namespace {

// Any viewpoint of the scan, or the first included one after it.
graph::Location draw_location(const graph::GraphSet& graphs, ScanIndex scan,
                              sim::MatterSimRandom& random) {
  const graph::NavGraph& graph = graphs.graph(scan);
  if (graph.included_count() == 0) {
    throw WrongOrder(fmt::format("scan {} has no included viewpoint to start from", graph.scan()));
  }
  std::size_t v = random.below(static_cast<std::uint32_t>(graph.size()));
  while (!graph.included(ViewpointIndex(v))) v = (v + 1) % graph.size();
  return {scan, ViewpointIndex(v)};
}

}  // namespace

void Simulator::start_scalar(PyObject* scans, PyObject* viewpoints, PyObject* headings,
                             PyObject* elevations) {
  const std::string scan = to_text(scans, "scanId");
  const std::string viewpoint = to_text(viewpoints, "viewpointId");
  const Radians heading(to_angle(headings, "heading"));
  const Radians elevation(to_angle(elevations, "elevation"));
  ensure_begun(Api::kV1);
  const bool known = walk_ && !path_changed_ && lists(*walk_->graphs, scan);
  const auto graphs = known ? walk_->graphs : open_graphs(scan);
  sim::MatterSimRandom random = stream();
  const graph::Location location =
      viewpoint.empty() ? draw_location(*graphs->set(), graphs->set()->at(scan), random)
                        : locate(*graphs, 0, scan, viewpoint);
  start(graphs, {{location, heading, elevation}});
  path_changed_ = false;
  stream() = random;
}

void Simulator::new_random_episode(PyObject* scans) {
  const Busy busy(busy_);
  const std::vector<std::string> scan = to_texts(scans, "scanId");
  ensure_begun(Api::kV2);
  const std::size_t n = active_.batch_size;
  if (scan.size() < n) too_short("scanId", scan.size(), n);
  if (n == 0) return;
  const auto graphs = walk_ ? walk_->graphs : open_graphs({});
  sim::MatterSimRandom viewpoints = stream();
  sim::MatterSimRandom fixed;  // new at every call: the old simulator's headings never change
  std::vector<sim::EpisodeStart> starts;
  for (std::size_t i = 0; i < n; ++i) {
    const ScanIndex found = find_scan(*graphs, i, scan[i]);
    const graph::Location location = draw_location(*graphs->set(), found, viewpoints);
    sim::MatterSimRandom& headings = options_.uniform_starts ? viewpoints : fixed;
    starts.push_back({location, headings.heading(), Radians(0)});
  }
  start(graphs, starts);
  stream() = viewpoints;
}

void Simulator::start(const std::shared_ptr<SharedGraphs>& graphs,
                      const std::vector<sim::EpisodeStart>& starts) {
  const std::size_t rows = widest(*graphs, starts);
  std::unique_ptr<Walk> fresh;
  const bool fits = walk_ && !camera_changed_ && walk_->graphs == graphs &&
                    walk_->native.config().max_navigable >= rows;
  if (!fits) fresh = std::make_unique<Walk>(graphs, native_config(rows));
  Walk& walk = fresh ? *fresh : *walk_;
  carry_out(walk, [&] { walk.native.new_episodes(starts); });
  if (fresh) walk_ = std::move(fresh);
  camera_changed_ = false;
  started_ = true;
  write_states(false);
}

template <class Step>
void Simulator::carry_out(Walk& walk, const Step& step) {
  if (!active_.rendering) {
    const Stopwatch watch(step_seconds_);
    if (active_.batch_size < kAgentsWorthAGil) return step();
    const nb::gil_scoped_release unlocked;
    return step();
  }
  const nb::gil_scoped_release unlocked;
  const Stopwatch watch(draw_seconds_);
  ensure_pictures(*walk.graphs);
  const bool may_go_back = started_ && &walk == walk_.get();
  std::vector<sim::EpisodeStart> before;
  for (std::size_t i = 0; may_go_back && i < active_.batch_size; ++i) {
    before.push_back({{walk.native.state().scan[i], walk.native.state().viewpoint[i]},
                      Radians(walk.native.state().heading[i]),
                      Radians(walk.native.state().elevation[i])});
  }
  step();
  try {
    pictures_->draw(walk.native.state());
  } catch (...) {
    if (may_go_back) walk.native.new_episodes(before);
    throw;
  }
  frames_ += active_.batch_size;
}

// --- actions

void Simulator::check_started(Api api) const {
  if (started_) return;
  if (begun_ && active_.batch_size == 0) return;
  if (begun_ || api == Api::kV1) {
    throw ArgumentError(
        "MatterSim: Invalid action index: newEpisode must be called before makeAction");
  }
  throw WrongOrder("MatterSim: newEpisode must be called before makeAction");
}

void Simulator::read_actions(PyObject* indices, PyObject* headings, PyObject* elevations) {
  if (is_list(indices) &&
      !(api_ == Api::kV1 && !PyList_Check(indices) && !PyTuple_Check(indices))) {
    check_started(Api::kV2);
    ensure_begun(Api::kV2);
    const std::size_t n = active_.batch_size;
    to_indices(indices, "index", n, indices_);
    to_angles(headings, "heading", n, headings_);
    to_angles(elevations, "elevation", n, elevations_);
  } else {
    indices_ = {to_index(indices, "index")};
    headings_ = {to_angle(headings, "heading")};
    elevations_ = {to_angle(elevations, "elevation")};
    check_started(Api::kV1);
    ensure_begun(Api::kV1);
  }
  actions_.clear();
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const std::uint32_t count = walk_->native.state().navigable_count[i];
    if (indices_[i] < 0 || indices_[i] >= count) {
      throw ArgumentError(fmt::format(
          "MatterSim: Invalid action index: {} in environment {} of {}: 0 to {} are allowed",
          indices_[i], i, indices_.size(), count - 1));
    }
    actions_.push_back(
        {static_cast<std::uint32_t>(indices_[i]), Radians(headings_[i]), Radians(elevations_[i])});
  }
}

// The poses after the actions: the starts of the simulator with the new camera.
std::vector<sim::EpisodeStart> Simulator::after_action() const {
  std::vector<sim::EpisodeStart> starts;
  const sim::StateSpans& now = walk_->native.state();
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const sim::Action& action = actions_[i];
    const std::size_t row = i * now.max_navigable() + action.index;
    const bool views = active_.discretized;
    const double right = action.heading_change.value, up = action.elevation_change.value;
    starts.push_back({{now.scan[i], now.navigable_viewpoint[row]},
                      Radians(now.heading[i] + (views ? sign(right) * kStep : right)),
                      Radians(now.elevation[i] + (views ? sign(up) * kStep : up))});
  }
  return starts;
}

void Simulator::make_action(PyObject* indices, PyObject* headings, PyObject* elevations) {
  const Busy busy(busy_);
  read_actions(indices, headings, elevations);
  if (actions_.empty()) return;
  if (camera_changed_) {
    auto fresh =
        std::make_unique<Walk>(walk_->graphs, native_config(walk_->native.config().max_navigable));
    const std::vector<sim::EpisodeStart> starts = after_action();
    carry_out(*fresh, [&] { fresh->native.new_episodes(starts); });
    walk_ = std::move(fresh);
    camera_changed_ = false;
  } else {
    carry_out(*walk_, [&] { walk_->native.step(actions_); });
  }
  write_states(true);
}

// --- states

void Simulator::write_states(bool moved) {
  show_pictures();
  for (std::size_t i = 0; i < active_.batch_size; ++i) write_state(i, moved);
}

void Simulator::write_state(std::size_t agent, bool moved) {
  SimStateObject& state = as_state(PyList_GetItem(states_.ptr(), static_cast<Py_ssize_t>(agent)));
  const sim::StateSpans& now = walk_->native.state();
  const std::vector<ViewpointNames>& names = walk_->graphs->names(now.scan[agent]);
  const bool live = api_ == Api::kV2;
  nb::object here;
  if (moved && live) {  // the same object as in the previous list
    here = nb::borrow(PyList_GetItem(state.navigable, static_cast<Py_ssize_t>(indices_[agent])));
    become_here(as_viewpoint(here.ptr()));
  } else {
    here = make_viewpoint(names[now.viewpoint[agent].at()], {});
  }
  const std::size_t row = agent * now.max_navigable();
  const std::uint32_t count = now.navigable_count[agent];
  nb::object list = own(PyList_New(count));
  PyList_SetItem(
      list.ptr(), 0,
      (live ? here : make_viewpoint(names[now.viewpoint[agent].at()], {})).release().ptr());
  for (std::uint32_t k = 1; k < count; ++k) {
    const std::size_t at = row + k;
    PyList_SetItem(list.ptr(), k,
                   make_viewpoint(names[now.navigable_viewpoint[at].at()],
                                  {now.navigable_rel_heading[at], now.navigable_rel_elevation[at],
                                   now.navigable_distance[at]})
                       .release()
                       .ptr());
  }
  const long step = moved ? PyLong_AsLong(state.step) + 1 : 0;
  if (!moved) put(state.scan_id, walk_->graphs->scan_name(now.scan[agent]));
  put(state.step, own(PyLong_FromLong(step)));
  put(state.location, std::move(here));
  put(state.heading, own(PyFloat_FromDouble(now.heading[agent])));
  put(state.elevation, own(PyFloat_FromDouble(now.elevation[agent])));
  put(state.view_index, own(PyLong_FromUnsignedLong(now.view_index[agent])));
  put(state.navigable, std::move(list));
}

}  // namespace enfilade::python::mattersim
