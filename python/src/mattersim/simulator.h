/// \file  MatterSim.Simulator: the old simulator's two interfaces over the native one.
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/sim/simulator.h"
#include "python/src/errors.h"
#include "python/src/mattersim/pictures.h"
#include "python/src/mattersim/types.h"

namespace enfilade::python::mattersim {

/// The interface that old code uses.
enum class Api : std::uint8_t { kUnknown, kV1, kV2 };

struct Settings {
  std::string dataset_path;  ///< empty: the default of the interface
  std::string nav_graph_path = "./connectivity";
  bool rendering = true;
  bool discretized = false;
  bool restricted = true;
  bool preloading = false;
  bool depth = false;
  std::int64_t width = 320, height = 240;
  double vertical_field_of_view = 0.8;  ///< radians
  sim::ElevationLimits limits;
  std::size_t batch_size = 1;
  std::size_t cache_panoramas = 200;
};

/// Defects of the old simulator to reproduce, and corrections to switch on: words in the
/// environment variable ENFILADE_MATTERSIM. See docs/python_mattersim.md.
struct Options {
  bool eight_bit_depth = false;   ///< "8bit-depth"
  bool smooth_edges = false;      ///< "smooth-edges"
  bool perspective_view = false;  ///< "perspective-fov"
  bool uniform_starts = false;    ///< "uniform-starts"
  bool one_stream = false;        ///< "one-stream"
  bool shared_cache = false;      ///< "shared-cache"

  /// \throws ArgumentError for an unknown word
  static Options from_environment();
};

/// A scan that is not in scans.txt: an IndexError, as in the old simulator.
class UnknownScan : public LookupError {
 public:
  using LookupError::LookupError;
};
/// The interface is v0.2 after initialize() or lists, v0.1 after init() or scalars. If an episode
/// or an action fails, nothing has changed. Functions need the GIL, and release it while they read
/// files, draw, or move many agents; a second thread that calls meanwhile gets a RuntimeError.
///
/// Errors are enfilade::Error, or nb::python_error: IndexError for an unknown scan
/// and for lists that are too short, RuntimeError for calls in a wrong order, TypeError for wrong
/// types, ValueError for everything else.
class Simulator {
 public:
  Simulator();
  ~Simulator();
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  // Camera, limits and seed take effect at the next episode or action; after init(), so do the
  // paths. Every other setting takes effect only at the next initialize() or init(). If it is set
  // in between, there is a RuntimeWarning; the old simulator was silent.
  void set_dataset_path(PyObject* path);
  void set_nav_graph_path(PyObject* path);
  void set_camera_resolution(int width, int height);
  void set_camera_vfov(double vfov);
  bool set_elevation_limits(double min, double max);
  void set_seed(int seed);
  /// Any other setting. \param setter its name, for the warning
  template <class T, class Value>
  void set(T Settings::*field, Value value, const char* setter) {
    const Busy busy(busy_);
    settings_.*field = value;
    warn_if_begun(setter);
  }

  void initialize();  ///< v0.2
  void init();        ///< v0.1
  void close();

  void new_episode(PyObject* scans, PyObject* viewpoints, PyObject* headings, PyObject* elevations);
  void new_random_episode(PyObject* scans);
  void make_action(PyObject* indices, PyObject* headings, PyObject* elevations);
  /// v0.2: a list of states that later actions change; v0.1: a copy of one.
  nb::object get_state();

  void reset_timers();
  std::string timing_info() const;

 private:
  /// A native simulator with its graphs; replaced when another configuration or other graphs are
  /// needed.
  struct Walk {
    Walk(std::shared_ptr<SharedGraphs> shared, const sim::SimulatorConfig& config);
    std::shared_ptr<SharedGraphs> graphs;
    sim::Simulator native;
  };
  void begin(Api api);
  void ensure_begun(Api api);
  void warn_if_begun(const char* setter) const;

  std::shared_ptr<SharedGraphs> open_graphs(const std::string& scan) const;
  sim::SimulatorConfig native_config(std::size_t max_navigable) const;
  sim::MatterSimRandom& stream();
  void ensure_pictures(const SharedGraphs& graphs);
  void preload();

  ScanIndex find_scan(const SharedGraphs& graphs, std::size_t agent, const std::string& scan) const;
  graph::Location locate(const SharedGraphs& graphs, std::size_t agent, const std::string& scan,
                         const std::string& viewpoint) const;
  void start_scalar(PyObject* scan, PyObject* viewpoint, PyObject* heading, PyObject* elevation);
  void start(const std::shared_ptr<SharedGraphs>& graphs,
             const std::vector<sim::EpisodeStart>& starts);
  void read_actions(PyObject* indices, PyObject* headings, PyObject* elevations);
  void check_started(Api api) const;
  std::vector<sim::EpisodeStart> after_action() const;
  template <class Step>
  void carry_out(Walk& walk, const Step& step);

  void seed_stream();
  void make_states();
  /// Points the states to the memory of pictures_, if they have that of earlier images.
  void show_pictures();
  void write_states(bool moved);
  void write_state(std::size_t agent, bool moved);

  Settings settings_;  ///< as set
  Settings active_;    ///< as they were at initialize(), and those that take effect at once
  Options options_;
  std::optional<int> seed_;
  Api api_ = Api::kUnknown;
  bool begun_ = false;
  bool camera_changed_ = false;
  bool path_changed_ = false;  // of v0.1's graphs
  bool started_ = false;       // an episode runs

  std::unique_ptr<Walk> walk_;
  std::optional<Pictures> pictures_;
  const SharedGraphs* pictured_ = nullptr;  // whose scans pictures_ draws
  bool shown_ = false;                      // the states have the memory of pictures_
  sim::MatterSimRandom random_;

  nb::object states_;  // list of SimState
  std::vector<std::int64_t> indices_;
  std::vector<double> headings_, elevations_;
  std::vector<sim::Action> actions_;

  std::uint64_t frames_ = 0;
  double step_seconds_ = 0, draw_seconds_ = 0, preload_seconds_ = 0;
  mutable std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

}  // namespace enfilade::python::mattersim
