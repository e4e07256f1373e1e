// The extension module enfilade._learn: trained agents. Separate from _core: it needs libtorch.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/agents/pilot.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/trained_agent.h"
#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;
using Set = std::shared_ptr<const tasks::EpisodeSet>;

agents::ActionSpace action_space(const std::string& name) {
  if (const auto found = find_enum<agents::ActionSpace>(name)) return *found;
  throw ArgumentError(fmt::format("actions {:?}: one of viewpoint, six, panoramic, map", name));
}

/// A trained agent, its episodes, and the episodes that it runs in an environment of Python.
class LearntAgent {
 public:
  LearntAgent(const std::filesystem::path& folder, const std::string& device)
      : agent_(neural::load_trained_agent(folder, device)) {}

  // `episodes`: the result of _core's EpisodeSet.shared().
  void enter(const nb::capsule& episodes, const std::optional<std::filesystem::path>& features) {
    const Busy busy(busy_);
    Set set = *static_cast<const Set*>(episodes.data("enfilade.EpisodeSet"));
    const nb::gil_scoped_release unlocked;
    std::optional<features::FeatureSet> file;
    if (features) file = features::FeatureSet::open(*features);
    pilot_.reset();
    agent_->enter(*set, file ? &*file : nullptr);
    set_ = std::move(set);
    features_ = std::move(file);
  }

  // A results file's text.
  std::string walk(std::size_t batch_size, const std::optional<std::filesystem::path>& results,
                   const std::optional<std::filesystem::path>& attention) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    require_episodes();
    pilot_.reset();
    const neural::SplitRollout options{batch_size, results.value_or(""), attention.value_or("")};
    return to_json(agent_->walk(options), *set_);
  }

  void begin(const Row<std::uint32_t>& episodes, const std::string& actions) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    require_episodes();
    auto pilot = std::make_unique<agents::Pilot>(*agent_, *set_, action_space(actions));
    const auto span = span_of(episodes);
    pilot->begin(std::vector<std::size_t>(span.begin(), span.end()));
    pilot_ = std::move(pilot);
  }

  // Per slot (stop, viewpoint, number of the six, object); the object is that of its last answer.
  nb::list next(const Row<std::uint32_t>& viewpoints, const Row<std::uint8_t>& asked) {
    const Busy busy(busy_);
    if (!pilot_) throw WrongOrder("act(): no episodes have begun");
    std::vector<agents::PilotMove> moves(pilot_->size());
    {
      const nb::gil_scoped_release unlocked;
      std::vector<ViewpointIndex> here;
      for (const std::uint32_t v : span_of(viewpoints)) here.emplace_back(v);
      pilot_->next(here, span_of(asked), moves);
    }
    nb::list all;
    for (const agents::PilotMove& move : moves) {
      all.append(nb::make_tuple(move.stop, move.to.value, static_cast<int>(move.action),
                                move.answer ? move.answer->object : std::string()));
    }
    return all;
  }

  std::string kind() const { return std::string(agent_->name()); }
  std::uint64_t iteration() const { return agent_->iteration(); }
  bool sees() const { return agent_->config().training.network.inputs.vision; }

 private:
  void require_episodes() const {
    if (!set_) throw WrongOrder("enter() has to come first: it says which episodes there are");
  }

  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
  std::unique_ptr<neural::TrainedAgent> agent_;
  Set set_;
  std::optional<features::FeatureSet> features_;
  std::unique_ptr<agents::Pilot> pilot_;
};

std::unique_ptr<LearntAgent> load(const std::filesystem::path& folder, const std::string& device) {
  const nb::gil_scoped_release unlocked;
  return std::make_unique<LearntAgent>(folder, device);
}

}  // namespace
}  // namespace enfilade::python

NB_MODULE(_learn, m) {
  using enfilade::python::LearntAgent;
  namespace nb = nanobind;
  using namespace nb::literals;
  nb::set_leak_warnings(false);
  enfilade::python::bind_errors();
  m.def("set_threads", &enfilade::neural::set_threads, "threads"_a);
  m.def("load", &enfilade::python::load, "folder"_a, "device"_a);
  nb::class_<LearntAgent>(m, "LearntAgent")
      .def("enter", &LearntAgent::enter, "episodes"_a, "features"_a.none(),
           nb::sig("def enter(self, episodes: typing.Any, features: str | None) -> None"))
      .def("walk", &LearntAgent::walk, "batch_size"_a, "results"_a.none(), "attention"_a.none())
      .def("begin", &LearntAgent::begin, "episodes"_a, "actions"_a,
           nb::sig("def begin(self, episodes: typing.Any, actions: str) -> None"))
      .def("next", &LearntAgent::next, "viewpoints"_a, "asked"_a,
           nb::sig("def next(self, viewpoints: typing.Any, asked: typing.Any) -> "
                   "list[tuple[bool, int, int, str]]"))
      .def_prop_ro("kind", &LearntAgent::kind)
      .def_prop_ro("iteration", &LearntAgent::iteration)
      .def_prop_ro("sees", &LearntAgent::sees);
}
