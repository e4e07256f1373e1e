// ArenaPlay: the core of enfilade.arena().
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/run.h"
#include "enfilade/arena/play.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/score_table.h"
#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;

std::optional<arena::Answers> answers_named(const std::string& name) {
  if (name.empty()) return std::nullopt;
  if (const auto answers = find_enum<arena::Answers>(name)) return answers;
  throw ArgumentError("answers '" + name + "': one of tools, json, text");
}

/// An arena::Play that refuses calls while another thread uses it.
class ArenaPlay {
 public:
  ArenaPlay(std::unique_ptr<arena::World> world, arena::ViewSources sights,
            const std::string& subset, const std::string& prompt, arena::PlayConfig config,
            std::uint32_t steps, std::uint32_t mistakes)
      : world_(world->another()) {
    config.episodes = arena::subset_named(*world, subset);
    config.limits = arena::usual_limits(world->task());
    config.limits.mistakes = mistakes;
    if (steps > 0) config.limits.steps = steps;
    play_ = std::make_unique<arena::Play>(std::move(world), std::move(sights),
                                          arena::Prompt::open(prompt), std::move(config));
  }

  bool begin() {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    return play_->begin();
  }
  void begin_at(const std::string& episode) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    play_->begin_at(index_of(episode));
  }
  std::vector<std::string> ids() const {
    std::vector<std::string> ids;
    for (const std::size_t one : play_->episodes()) ids.push_back(world_->episodes().id(one));
    return ids;
  }
  // What `read` finds in the play, which has an episode.
  template <class Read>
  static auto in_session(const Read& read) {
    return [read](ArenaPlay& self) { return self.with_session([&] { return read(*self.play_); }); };
  }
  // (scan, viewpoint or None, eye or None, heading, elevation)
  nb::tuple standpoint() {
    const auto here = with_session([&] { return play_->session()->standpoint(); });
    nb::object viewpoint = nb::none(), eye = nb::none();
    if (const auto* point = std::get_if<Vec3d>(&here.eye)) {
      eye = nb::make_tuple(point->x, point->y, point->z);
    } else {
      viewpoint = nb::cast(here.place);
    }
    return nb::make_tuple(here.scan, viewpoint, eye, here.heading.value, here.elevation.value);
  }
  nb::list draw() {
    const std::vector<std::string> drawn = with_session([&] { return play_->draw(); });
    nb::list pictures;
    for (const std::string& one : drawn) pictures.append(nb::bytes(one.data(), one.size()));
    return pictures;
  }

  // (valid, the episode's ending or None, feedback)
  nb::tuple answer(const std::string& text) {
    return told(with_session([&] { return play_->call(play_->read(text)); }));
  }
  nb::tuple call(const std::string& tool, const std::string& arguments) {
    return told(with_session([&] { return play_->call(arena::read_call(tool, arguments)); }));
  }

  nb::tuple use(const std::string& tool, const std::string& argument) {
    const arena::Reading reading{arena::Call{tool, argument}, {}, {}};
    return told(with_session([&] { return play_->call(reading); }));
  }

  // A results file of one episode, or of all completed ones.
  std::string results(const std::optional<std::string>& episode) const {
    return episode ? play_->result(index_of(*episode)) : play_->results();
  }
  // Scores of continuous episodes: ({measure: (mean, low, high)}, {episode: {measure: value}})
  nb::tuple free_score(const std::optional<std::string>& episode) {
    const Busy busy(busy_);
    const auto& world = dynamic_cast<const arena::FloorWorld&>(*world_);
    const tasks::Split& split = world.episodes();
    tasks::Trajectories trajectories;
    tasks::ScoreTable scores;
    {
      const nb::gil_scoped_release unlocked;
      trajectories =
          tasks::parse_trajectories(results(episode), "results", split, tasks::Coverage::kPart);
      scores = agents::compute_score(trajectories, split, world.buildings().get(),
                                     split.benchmark().scorer({}));
    }
    nb::dict means, by_id;
    const auto metrics = scores.scorer->metrics;
    for (std::size_t m = 0; m < metrics.size(); ++m) {
      const auto& [mean, low, high] = scores.means[m];
      means[metrics[m].name] = nb::make_tuple(mean, low, high);
    }
    for (std::size_t k = 0; k < scores.ids.size(); ++k) {
      nb::dict one;
      for (std::size_t m = 0; m < metrics.size(); ++m) one[metrics[m].name] = scores.row(k)[m];
      by_id[nb::cast(scores.ids[k])] = one;
    }
    return nb::make_tuple(means, by_id);
  }
  std::size_t done() const { return play_->done(); }
  std::size_t size() const { return play_->size(); }

 private:
  std::size_t index_of(const std::string& episode) const {
    const auto found = world_->find(episode);
    if (!found) throw LookupError("episode '" + episode + "': the split has no such id");
    return *found;
  }
  template <class Work>
  std::invoke_result_t<const Work&> with_session(const Work& work) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    if (play_->session() == nullptr) throw WrongOrder("no episode is being walked");
    return work();
  }
  static nb::tuple told(const arena::PlayOutcome& outcome) {
    nb::object ending = nb::none();
    if (outcome.ending) {
      const std::string name(name_of(*outcome.ending));
      ending = nb::str(name.c_str());
    }
    return nb::make_tuple(outcome.carried_out, ending, outcome.told);
  }

  std::unique_ptr<arena::World> world_;  // for scores
  std::unique_ptr<arena::Play> play_;
  std::atomic_flag busy_;
};

arena::PlayConfig config_of(const std::string& answers, std::uint32_t picture_size,
                            const std::optional<std::filesystem::path>& folder) {
  arena::PlayConfig config;
  config.answers = answers_named(answers);
  config.picture_size = picture_size;
  if (folder) config.folder = *folder;
  return config;
}

std::unique_ptr<ArenaPlay> open_play(const dataset::Dataset& data, nb::handle episodes,
                                     const std::string& subset, const std::string& prompt,
                                     const std::string& answers, std::uint32_t steps,
                                     std::uint32_t mistakes, std::uint32_t picture_size,
                                     const std::optional<std::filesystem::path>& folder,
                                     bool words) {
  auto set = episode_set(episodes);
  const nb::gil_scoped_release unlocked;
  arena::ViewSources sights;
  sights.data = std::make_shared<const dataset::Dataset>(data);
  auto world = std::make_unique<arena::GraphWorld>(
      std::move(set), words ? arena::label_words(sights) : arena::WordsSource());
  return std::make_unique<ArenaPlay>(std::move(world), std::move(sights), subset, prompt,
                                     config_of(answers, picture_size, folder), steps, mistakes);
}

// A session of continuous episodes; Python draws them with enfilade.eyes.
std::unique_ptr<ArenaPlay> open_free_play(const std::filesystem::path& data,
                                          const std::string& task, const std::string& split,
                                          const std::string& subset, const std::string& prompt,
                                          const std::string& answers, std::uint32_t steps,
                                          std::uint32_t mistakes,
                                          const std::optional<std::filesystem::path>& folder) {
  const nb::gil_scoped_release unlocked;
  constexpr std::uint32_t kNoPictures = 64;  // a valid size, although no images are drawn
  arena::PlayConfig config = config_of(answers, kNoPictures, folder);
  config.pictures = arena::PictureKind::kNone;
  auto world = std::make_unique<arena::FloorWorld>(
      dataset::Dataset(data).split(tasks::benchmark(task, tasks::WorldKind::kContinuous), split),
      data);
  return std::make_unique<ArenaPlay>(std::move(world), arena::ViewSources(), subset, prompt,
                                     std::move(config), steps, mistakes);
}

}  // namespace

void bind_arena(nb::module_& m) {
  nb::class_<ArenaPlay>(m, "ArenaPlay", "The core of enfilade.arena().")
      .def(nb::new_(&open_play), "dataset"_a, "episodes"_a, "subset"_a, "prompt"_a, "answers"_a,
           "steps"_a, "mistakes"_a, "picture_size"_a, "folder"_a.none(), "words"_a)
      .def_static("free", &open_free_play, "data"_a, "task"_a, "split"_a, "subset"_a, "prompt"_a,
                  "answers"_a, "steps"_a, "mistakes"_a, "folder"_a.none())
      .def("standpoint", &ArenaPlay::standpoint,
           nb::sig("def standpoint(self) -> tuple[str, str | None, tuple[float, float, float] | "
                   "None, float, float]"))
      .def("free_score", &ArenaPlay::free_score, "episode"_a.none(),
           nb::sig("def free_score(self, episode: str | None) -> tuple[dict[str, tuple[float, "
                   "float, float]], "
                   "dict[str, dict[str, float]]]"))
      .def("begin", &ArenaPlay::begin)
      .def("begin_at", &ArenaPlay::begin_at, "episode"_a)
      .def_prop_ro("ids", &ArenaPlay::ids)
      .def("start_text", ArenaPlay::in_session([](auto& play) { return play.start_text(); }))
      .def("step_text", ArenaPlay::in_session([](auto& play) { return play.step_text(); }))
      .def("observation",
           ArenaPlay::in_session([](auto& play) { return to_json(play.session()->observation()); }))
      .def("functions", ArenaPlay::in_session([](auto& play) {
             return functions_json(play.session()->observation());
           }))
      .def("schema", ArenaPlay::in_session(
                         [](auto& play) { return answer_schema(play.session()->observation()); }))
      .def("episode",
           ArenaPlay::in_session([](auto& play) { return play.session()->episode_id(); }))
      .def("draw", &ArenaPlay::draw, nb::sig("def draw(self) -> list[bytes]"))
      .def("answer", &ArenaPlay::answer, "text"_a,
           nb::sig("def answer(self, text: str) -> tuple[bool, str | None, str]"))
      .def("call", &ArenaPlay::call, "tool"_a, "arguments"_a,
           nb::sig("def call(self, tool: str, arguments: str) -> tuple[bool, str | None, str]"))
      .def("use", &ArenaPlay::use, "tool"_a, "argument"_a,
           nb::sig("def use(self, tool: str, argument: str) -> tuple[bool, str | None, str]"))
      .def("results", &ArenaPlay::results, "episode"_a.none())
      .def_prop_ro("done", &ArenaPlay::done)
      .def("__len__", &ArenaPlay::size);
}

}  // namespace enfilade::python
