/// \file  The C++ interface of Matterport3DSimulator v0.2 (`MatterSim.hpp`), over Enfilade's
/// simulator and renderer: graphs, states, colour and depth, without OpenCV, a display or a GPU.
/// One header; link `enfilade::mattersim`. What differs from the old one: docs/mattersim.md.
///
/// Pictures are `mattersim::Mat`s; where MATTERSIM_WITH_OPENCV is defined before this is included,
/// `cv::Mat`s over the same memory (then the program links OpenCV's core).
#pragma once
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/sim/observe.h"
#include "enfilade/sim/simulator.h"

#ifdef MATTERSIM_WITH_OPENCV
#include <opencv2/core.hpp>
#endif

namespace mattersim {

#ifdef MATTERSIM_WITH_OPENCV
using Mat = cv::Mat;
#else
/// A picture: rows from the top, no padding. A view of the simulator's memory, which the next
/// episode or action draws over; copies see the same memory, and keep it.
struct Mat {
  int rows = 0, cols = 0;
  int channels_ = 0, value_bytes = 0;  ///< 3 and 1 of colour (B G R), 1 and 2 of depth
  unsigned char* data = nullptr;
  std::shared_ptr<unsigned char[]> memory = {};

  bool empty() const noexcept { return data == nullptr || rows == 0 || cols == 0; }
  int channels() const noexcept { return channels_; }
  std::size_t total() const noexcept {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
  }
  std::size_t elemSize() const noexcept {
    return static_cast<std::size_t>(channels_) * static_cast<std::size_t>(value_bytes);
  }
  bool isContinuous() const noexcept { return true; }
  /// The values of a row. \pre 0 <= row < rows, and T is as large as a value
  template <class T = unsigned char>
  T* ptr(int row = 0) const {
    const auto begin = static_cast<std::size_t>(row) * static_cast<std::size_t>(cols) * elemSize();
    return reinterpret_cast<T*>(data + begin);
  }
  /// The value of a picture of one channel. \pre as above; 0 <= column < cols
  template <class T>
  T& at(int row, int column) const {
    return ptr<T>(row)[column];
  }
};
#endif

/// A viewpoint as an agent sees it.
struct Viewpoint {
  std::string viewpointId;     ///< in the files of its scan
  unsigned int ix = 0;         ///< place in the connectivity file, excluded ones counted
  double x = 0, y = 0, z = 0;  ///< metres, world frame, z up
  double rel_heading = 0, rel_elevation = 0;  ///< radians from the view's middle, right and up
  double rel_distance = 0;                    ///< metres
};
using ViewpointPtr = std::shared_ptr<Viewpoint>;

/// Where an agent is, and what it sees and can reach. The simulator changes it at each action.
struct SimState {
  std::string scanId;
  unsigned int step = 0;       ///< actions since the episode began
  Mat rgb;                     ///< (height, width) B G R; all 0 if nothing is drawn
  Mat depth;                   ///< quarter millimetres along the optical axis; 0: no reading
  ViewpointPtr location;       ///< null before the first episode
  double heading = 0;          ///< radians clockwise from world +y, [0, 2 pi]
  double elevation = 0;        ///< radians above the horizon
  unsigned int viewIndex = 0;  ///< 0..35 when discretized, else 0
  std::vector<ViewpointPtr> navigableLocations;  ///< [0] is the present place
};
using SimStatePtr = std::shared_ptr<SimState>;

/// The old simulator's class. Camera and elevation limits may be set at any time, and count from
/// the next episode or action on; the other settings count from the next initialize(). A call that
/// fails moves no agent. One thread at a time; any number of simulators in a process.
///
/// Errors are of the old types: std::out_of_range for an unknown scan and lists that are too short,
/// std::domain_error for an action that is not possible, std::runtime_error for a call too early,
/// std::invalid_argument for everything else.
class Simulator {
 public:
  Simulator() = default;
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  /// Folder of the scans' pictures: strips, sky-boxes, zips or stores. Default ./data/v1/scans/.
  void setDatasetPath(const std::string& path) { settings_.dataset_path = path; }
  /// Folder of scans.txt and the graphs. Default ./connectivity.
  void setNavGraphPath(const std::string& path) { settings_.nav_graph_path = path; }
  void setRenderingEnabled(bool value) { settings_.rendering = value; }  ///< default true
  /// Pixels; default 320 x 240.
  void setCameraResolution(int width, int height) {
    settings_.width = active_.width = width;
    settings_.height = active_.height = height;
    camera_changed_ = true;
  }
  /// Vertical field of view, radians; default 0.8.
  void setCameraVFOV(double vfov) {
    settings_.vfov = active_.vfov = vfov;
    camera_changed_ = true;
  }
  /// Radians. False, and nothing changes, unless -pi/2 < min < 0 < max < pi/2.
  bool setElevationLimits(double min, double max) {
    constexpr double kQuarter = enfilade::kPi / 2;
    if (!(-kQuarter < min && min < 0 && 0 < max && max < kQuarter)) return false;
    settings_.limits = active_.limits = {enfilade::Radians(min), enfilade::Radians(max)};
    camera_changed_ = true;
    return true;
  }
  /// 36 views: 12 headings, 3 elevations. Default false.
  void setDiscretizedViewingAngles(bool value) { settings_.discretized = value; }
  /// Only what the picture's width shows is navigable. Default true.
  void setRestrictedNavigation(bool value) { settings_.restricted = value; }
  /// Decodes the pictures of all scans at initialize(), and keeps them. Default false.
  void setPreloadingEnabled(bool value) { settings_.preloading = value; }
  void setDepthEnabled(bool value) { settings_.depth = value; }               ///< default false
  void setBatchSize(unsigned int size) { settings_.batch_size = size; }       ///< agents; default 1
  void setCacheSize(unsigned int size) { settings_.cache_panoramas = size; }  ///< default 200
  /// Of newRandomEpisode(); default 1.
  void setSeed(int seed) {
    random_ = enfilade::sim::MatterSimRandom(static_cast<std::uint64_t>(std::int64_t{seed}));
  }

  /// Applies the settings. newEpisode() calls it if it was not called.
  void initialize();
  /// Starts an episode for every agent; angles in radians.
  void newEpisode(const std::vector<std::string>& scanId,
                  const std::vector<std::string>& viewpointId, const std::vector<double>& heading,
                  const std::vector<double>& elevation);
  /// A random viewpoint and the old simulator's headings.
  void newRandomEpisode(const std::vector<std::string>& scanId);
  /// The states of all agents: the same objects at every call. Empty before initialize().
  const std::vector<SimStatePtr>& getState() { return states_; }
  /// Moves to navigableLocations[index], then turns by the given radians, right and up positive.
  void makeAction(const std::vector<unsigned int>& index, const std::vector<double>& heading,
                  const std::vector<double>& elevation);
  /// Lets go of graphs and pictures; initialize() begins anew.
  void close();
  void resetTimers() { frames_ = 0, seconds_ = 0; }  ///< timingInfo() begins anew
  std::string timingInfo() const;                    ///< how long moving and drawing took, as text

 private:
  struct Settings {
    std::string dataset_path = "./data/v1/scans/", nav_graph_path = "./connectivity";
    bool rendering = true, discretized = false, restricted = true, preloading = false;
    bool depth = false;
    int width = 320, height = 240;
    double vfov = 0.8;
    enfilade::sim::ElevationLimits limits;
    std::size_t batch_size = 1, cache_panoramas = 200;
  };
  using Starts = std::vector<enfilade::sim::EpisodeStart>;

  template <class Call>
  static void as_before(const Call& call);
  enfilade::Camera camera() const;
  std::size_t pixels() const {  ///< of a picture
    return static_cast<std::size_t>(active_.width) * static_cast<std::size_t>(active_.height);
  }
  enfilade::sim::SimulatorConfig config() const;
  enfilade::ScanIndex scan_of(const std::string& scan) const;
  enfilade::graph::Location locate(const std::string& scan, const std::string& viewpoint) const;
  void ensure_graphs();
  void check_length(const char* name, std::size_t found) const;
  void start(const Starts& starts);
  Starts after(const std::vector<enfilade::sim::Action>& actions) const;
  template <class Step>
  void carry_out(enfilade::sim::Simulator& walk, const Step& step, bool may_go_back);
  void open_pictures();
  void preload();
  void draw(const enfilade::sim::StateSpans& state);
  ViewpointPtr viewpoint(enfilade::ScanIndex scan, enfilade::ViewpointIndex v) const;
  void write_states(const std::vector<unsigned int>* moves);
  void show(SimState& state, std::size_t agent) const;

  Settings settings_, active_;
  bool begun_ = false, camera_changed_ = false;
  enfilade::sim::MatterSimRandom random_;
  std::shared_ptr<const enfilade::graph::GraphSet> graphs_;
  std::unique_ptr<enfilade::sim::Simulator> walk_;
  std::shared_ptr<enfilade::render::FaceCache> faces_;
  std::unique_ptr<enfilade::render::Renderer> renderer_;
  std::vector<enfilade::render::View> views_;
  std::shared_ptr<unsigned char[]> colour_, depth_;
  std::vector<SimStatePtr> states_;
  std::size_t frames_ = 0;
  double seconds_ = 0;
};

// --- what follows is of no interest to users

template <class Call>
void Simulator::as_before(const Call& call) {
  try {
    call();
  } catch (const enfilade::Error& error) {
    throw std::invalid_argument(error.what());
  }
}

inline enfilade::Camera Simulator::camera() const {
  if (active_.width < 1 || active_.height < 1) {
    throw enfilade::ArgumentError("camera resolution " + std::to_string(active_.width) + " x " +
                                  std::to_string(active_.height) + ": at least 1 x 1 is needed");
  }
  return {static_cast<std::uint32_t>(active_.width), static_cast<std::uint32_t>(active_.height),
          enfilade::Radians(active_.vfov)};
}

inline enfilade::sim::SimulatorConfig Simulator::config() const {
  namespace sim = enfilade::sim;
  sim::SimulatorConfig config = sim::SimulatorConfig::mattersim();
  config.batch_size = active_.batch_size;
  config.camera = camera();
  if (active_.discretized) config.viewing = sim::Viewing::kDiscretized;
  if (!active_.restricted) config.navigation = sim::Navigation::kUnrestricted;
  config.elevation_limits = active_.limits;
  if (graphs_) {
    for (const SimStatePtr& state : states_) {
      const auto scan = graphs_->find(state->scanId);
      if (scan) {
        config.max_navigable =
            std::max(config.max_navigable, graphs_->graph(*scan).max_degree() + 1);
      }
    }
  }
  return config;
}

inline void Simulator::initialize() {
  as_before([&] {
    active_ = settings_;
    static_cast<void>(camera());  // refuses an invalid size
    close();
    if (active_.batch_size > 0) enfilade::sim::validate(config());
    const std::size_t all = pixels() * active_.batch_size;
    colour_ = std::make_shared<unsigned char[]>(all * 3);
    depth_ = std::make_shared<unsigned char[]>(all * 2);
    for (std::size_t i = 0; i < active_.batch_size; ++i) {
      states_.push_back(std::make_shared<SimState>());
      show(*states_.back(), i);
    }
    begun_ = true;
    if (active_.rendering && active_.preloading && active_.batch_size > 0) preload();
  });
}

inline void Simulator::close() {
  begun_ = camera_changed_ = false;
  states_.clear();
  walk_.reset();
  renderer_.reset();
  faces_.reset();
  graphs_.reset();
}

inline void Simulator::ensure_graphs() {
  if (!graphs_) graphs_ = enfilade::graph::GraphSet::open_shared(active_.nav_graph_path);
}

inline void Simulator::check_length(const char* name, std::size_t found) const {
  if (found >= active_.batch_size) return;
  throw std::out_of_range(std::string(name) + ": " + std::to_string(found) +
                          " elements for a batch of " + std::to_string(active_.batch_size));
}

inline enfilade::ScanIndex Simulator::scan_of(const std::string& scan) const {
  if (const auto found = graphs_->find(scan)) return *found;
  throw std::out_of_range("scan " + scan + " is not in " + active_.nav_graph_path + "/scans.txt");
}

inline enfilade::graph::Location Simulator::locate(const std::string& scan,
                                                   const std::string& viewpoint) const {
  scan_of(scan);
  return graphs_->locate(scan, viewpoint);
}

inline void Simulator::newEpisode(const std::vector<std::string>& scanId,
                                  const std::vector<std::string>& viewpointId,
                                  const std::vector<double>& heading,
                                  const std::vector<double>& elevation) {
  if (!begun_) initialize();
  check_length("scanId", scanId.size());
  check_length("viewpointId", viewpointId.size());
  check_length("heading", heading.size());
  check_length("elevation", elevation.size());
  as_before([&] {
    ensure_graphs();
    Starts starts;
    for (std::size_t i = 0; i < active_.batch_size; ++i) {
      starts.push_back({locate(scanId[i], viewpointId[i]), enfilade::Radians(heading[i]),
                        enfilade::Radians(elevation[i])});
    }
    start(starts);
  });
}

inline void Simulator::newRandomEpisode(const std::vector<std::string>& scanId) {
  if (!begun_) initialize();
  check_length("scanId", scanId.size());
  as_before([&] {
    ensure_graphs();
    enfilade::sim::MatterSimRandom viewpoints = random_;
    enfilade::sim::MatterSimRandom headings;  // new at every call, as in the old simulator
    Starts starts;
    for (std::size_t i = 0; i < active_.batch_size; ++i) {
      const enfilade::ScanIndex scan = scan_of(scanId[i]);
      const enfilade::graph::NavGraph& graph = graphs_->graph(scan);
      if (graph.included_count() == 0) {
        throw std::runtime_error("scan " + scanId[i] + " has no included viewpoint");
      }
      std::size_t v = viewpoints.below(static_cast<std::uint32_t>(graph.size()));
      while (!graph.included(enfilade::ViewpointIndex(v))) v = (v + 1) % graph.size();
      starts.push_back({{scan, enfilade::ViewpointIndex(v)}, headings.heading(), {}});
    }
    start(starts);
    random_ = viewpoints;
  });
}

inline void Simulator::start(const Starts& starts) {
  if (starts.empty()) return;
  enfilade::sim::SimulatorConfig wanted = config();
  for (const enfilade::sim::EpisodeStart& start : starts) {
    const std::size_t rows = graphs_->graph(start.location.scan).max_degree() + 1;
    wanted.max_navigable = std::max(wanted.max_navigable, rows);
  }
  std::unique_ptr<enfilade::sim::Simulator> fresh;
  if (!walk_ || camera_changed_ || walk_->config().max_navigable < wanted.max_navigable) {
    fresh = std::make_unique<enfilade::sim::Simulator>(graphs_, wanted);
  }
  enfilade::sim::Simulator& walk = fresh ? *fresh : *walk_;
  carry_out(
      walk, [&] { walk.new_episodes(starts); }, !fresh);
  if (fresh) walk_ = std::move(fresh);
  camera_changed_ = false;
  write_states(nullptr);
}

// Moves and draws; if drawing fails, the agents go back.
template <class Step>
void Simulator::carry_out(enfilade::sim::Simulator& walk, const Step& step, bool may_go_back) {
  const auto begin = std::chrono::steady_clock::now();
  const enfilade::sim::StateSpans& now = walk.state();
  Starts before;
  if (active_.rendering && may_go_back) {
    for (std::size_t i = 0; i < walk.batch_size(); ++i) {
      before.push_back({{now.scan[i], now.viewpoint[i]},
                        enfilade::Radians(now.heading[i]),
                        enfilade::Radians(now.elevation[i])});
    }
  }
  step();
  if (active_.rendering) {
    try {
      open_pictures();
      draw(now);
    } catch (...) {
      if (!before.empty()) walk.new_episodes(before);
      throw;
    }
    frames_ += walk.batch_size();
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

inline void Simulator::makeAction(const std::vector<unsigned int>& index,
                                  const std::vector<double>& heading,
                                  const std::vector<double>& elevation) {
  if (!walk_) {
    if (begun_ && active_.batch_size == 0) return;
    throw std::runtime_error("MatterSim: newEpisode must be called before makeAction");
  }
  check_length("index", index.size());
  check_length("heading", heading.size());
  check_length("elevation", elevation.size());
  std::vector<enfilade::sim::Action> actions;
  for (std::size_t i = 0; i < active_.batch_size; ++i) {
    if (index[i] >= walk_->state().navigable_count[i]) {
      throw std::domain_error("MatterSim: Invalid action index: " + std::to_string(index[i]) +
                              " in environment " + std::to_string(i) + ": 0 to " +
                              std::to_string(walk_->state().navigable_count[i] - 1) +
                              " are allowed");
    }
    actions.push_back({index[i], enfilade::Radians(heading[i]), enfilade::Radians(elevation[i])});
  }
  as_before([&] {
    if (camera_changed_) {
      const Starts starts = after(actions);
      auto fresh = std::make_unique<enfilade::sim::Simulator>(graphs_, config());
      carry_out(
          *fresh, [&] { fresh->new_episodes(starts); }, false);
      walk_ = std::move(fresh);
      camera_changed_ = false;
    } else {
      carry_out(
          *walk_, [&] { walk_->step(actions); }, true);
    }
  });
  write_states(&index);
}

// The poses after the actions, as starts of a simulator with another camera.
inline Simulator::Starts Simulator::after(const std::vector<enfilade::sim::Action>& actions) const {
  constexpr double kStep = enfilade::kPi / 6;
  const auto turn = [this](enfilade::Radians by) {
    if (!active_.discretized || !std::isfinite(by.value)) return by.value;  // refused later
    return by.value > 0 ? kStep : by.value < 0 ? -kStep : 0.0;
  };
  const enfilade::sim::StateSpans& now = walk_->state();
  Starts starts;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const std::size_t row = i * now.max_navigable() + actions[i].index;
    starts.push_back({{now.scan[i], now.navigable_viewpoint[row]},
                      enfilade::Radians(now.heading[i] + turn(actions[i].heading_change)),
                      enfilade::Radians(now.elevation[i] + turn(actions[i].elevation_change))});
  }
  return starts;
}

inline void Simulator::open_pictures() {
  if (renderer_) return;
  namespace render = enfilade::render;
  // A decoded panorama of 512 texels, with and without depth.
  const std::size_t panorama = 6 * std::size_t{1'060'000} + (active_.depth ? 3'180'000 : 0);
  const std::size_t bytes = active_.preloading
                                ? std::numeric_limits<std::size_t>::max()
                                : std::max<std::size_t>(active_.cache_panoramas, 1) * panorama;
  faces_ = std::make_shared<render::FaceCache>(
      enfilade::scan::PanoramaSet::open({{active_.dataset_path}, active_.nav_graph_path},
                                        graphs_->scans()),
      render::FaceCacheConfig{.bytes = bytes, .prefetch_thread = false});
  render::RendererConfig config;
  config.legacy.clamped_edges = true;  // features depend on it
  renderer_ = render::make_renderer(faces_, config);
}

inline void Simulator::preload() {
  namespace scan = enfilade::scan;
  ensure_graphs();
  open_pictures();
  std::vector<enfilade::render::FaceKey> keys;
  for (std::size_t s = 0; s < graphs_->size(); ++s) {
    const enfilade::graph::NavGraph& graph = graphs_->graph(enfilade::ScanIndex(s));
    keys.clear();
    for (std::size_t v = 0; v < graph.size(); ++v) {
      const enfilade::ViewpointIndex at(v);
      if (!graph.included(at)) continue;
      for (std::size_t k = 0; k < enfilade::kCubeFaces; ++k) {
        const enfilade::CubeFace face = enfilade::cube_face(k);
        keys.push_back({enfilade::ScanIndex(s), at, scan::Layer::kColour, face});
        if (active_.depth) {
          keys.push_back({enfilade::ScanIndex(s), at, scan::Layer::kDepth, face});
        }
      }
    }
    std::vector<enfilade::render::Face> faces(keys.size());
    faces_->acquire(keys, faces);
    faces_->release(keys);
  }
}

inline void Simulator::draw(const enfilade::sim::StateSpans& state) {
  namespace render = enfilade::render;
  const std::size_t all = pixels() * active_.batch_size;
  std::shared_ptr<unsigned char[]> colour = colour_, depth = depth_;
  if (camera_changed_) {  // of another size, perhaps; the states keep theirs if drawing fails
    colour = std::make_shared<unsigned char[]>(all * 3);
    depth = std::make_shared<unsigned char[]>(all * 2);
  }
  views_.resize(active_.batch_size);
  enfilade::sim::views_of(state, views_);
  render::Outputs outputs;
  outputs.colour = {
      render::ColourFormat::kBgr8, {}, std::as_writable_bytes(std::span(colour.get(), all * 3))};
  if (active_.depth) {
    outputs.depth = {render::DepthFormat::kQuarterMillimetresUint16, render::DepthMeasure::kZ,
                     std::as_writable_bytes(std::span(depth.get(), all * 2))};
  }
  renderer_->render(camera(), views_, outputs);
  colour_ = std::move(colour);
  depth_ = std::move(depth);
}

inline void Simulator::show(SimState& state, std::size_t agent) const {
  unsigned char* const colour = colour_.get() + agent * pixels() * 3;
  unsigned char* const depth = depth_.get() + agent * pixels() * 2;
#ifdef MATTERSIM_WITH_OPENCV
  state.rgb = cv::Mat(active_.height, active_.width, CV_8UC3, colour);
  state.depth = cv::Mat(active_.height, active_.width, CV_16UC1, depth);
#else
  state.rgb = {active_.height, active_.width, 3, 1, colour, colour_};
  state.depth = {active_.height, active_.width, 1, 2, depth, depth_};
#endif
}

inline ViewpointPtr Simulator::viewpoint(enfilade::ScanIndex scan,
                                         enfilade::ViewpointIndex v) const {
  const enfilade::graph::NavGraph& graph = graphs_->graph(scan);
  const enfilade::Vec3f at = graph.position(v);
  return std::make_shared<Viewpoint>(Viewpoint{graph.id(v), v.value, at.x, at.y, at.z, 0, 0, 0});
}

// `moves`: the indices of the actions; null after the start of episodes.
inline void Simulator::write_states(const std::vector<unsigned int>* moves) {
  const enfilade::sim::StateSpans& now = walk_->state();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    SimState& state = *states_[i];
    if (moves != nullptr) {  // the same object as in the previous list
      state.location = state.navigableLocations[(*moves)[i]];
      state.location->rel_heading = state.location->rel_elevation = 0;
      state.location->rel_distance = 0;
    } else {
      state.location = viewpoint(now.scan[i], now.viewpoint[i]);
      state.scanId = graphs_->scans()[now.scan[i].at()];
    }
    state.step = moves != nullptr ? state.step + 1 : 0;
    state.heading = now.heading[i];
    state.elevation = now.elevation[i];
    state.viewIndex = now.view_index[i];
    state.navigableLocations.assign(1, state.location);
    for (std::uint32_t k = 1; k < now.navigable_count[i]; ++k) {
      const std::size_t row = i * now.max_navigable() + k;
      ViewpointPtr there = viewpoint(now.scan[i], now.navigable_viewpoint[row]);
      there->rel_heading = now.navigable_rel_heading[row];
      there->rel_elevation = now.navigable_rel_elevation[row];
      there->rel_distance = now.navigable_distance[row];
      state.navigableLocations.push_back(std::move(there));
    }
    if (active_.rendering) show(state, i);
  }
}

inline std::string Simulator::timingInfo() const {
  const double each = frames_ > 0 ? 1e3 * seconds_ / static_cast<double>(frames_) : 0;
  return "frames: " + std::to_string(frames_) +
         "\nmoving and drawing: " + std::to_string(seconds_) + " s, " + std::to_string(each) +
         " ms a frame\n";
}

}  // namespace mattersim
