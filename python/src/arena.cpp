// ArenaPlay: what enfilade.arena() is made of.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/arena/play.h"
#include "enfilade/arena/subsets.h"
#include "enfilade/core/errors.h"
#include "enfilade/dataset/dataset.h"
#include "python/src/bindings.h"
#include "python/src/busy.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;

std::optional<arena::Answers> answers_named(const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto names = names_of(arena::Answers());
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k] == name) return static_cast<arena::Answers>(k);
  }
  throw ArgumentError("answers '" + name + "': one of tools, json, text");
}

/// An arena::Play that answers nobody while another thread is in it.
class ArenaPlay {
 public:
  ArenaPlay(std::shared_ptr<const tasks::EpisodeSet> episodes, const dataset::Dataset& data,
            const std::string& subset, const std::string& prompt, arena::PlayConfig config)
      : data_(data), episodes_(std::move(episodes)) {
    config.episodes = arena::subset_named(*episodes_, subset);
    play_ = std::make_unique<arena::Play>(episodes_, &data_, arena::Prompt::open(prompt),
                                          std::move(config));
  }

  bool begin() {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    return play_->begin();
  }
  std::string start_text() {
    return with_session([&] { return play_->start_text(); });
  }
  std::string step_text() {
    return with_session([&] { return play_->step_text(); });
  }
  std::string observation() {
    return with_session([&] { return to_json(play_->session()->observation()); });
  }
  std::string functions() {
    return with_session([&] { return functions_json(play_->session()->observation()); });
  }
  std::string schema() {
    return with_session([&] { return answer_schema(play_->session()->observation()); });
  }
  std::string episode() {
    return with_session([&] { return play_->session()->episode_id(); });
  }
  nb::list draw() {
    const std::vector<std::string> drawn = with_session([&] { return play_->draw(); });
    nb::list pictures;
    for (const std::string& one : drawn) pictures.append(nb::bytes(one.data(), one.size()));
    return pictures;
  }

  // (carried out, how the episode ended or None, what came of it)
  nb::tuple answer(const std::string& text) {
    return told(with_session([&] { return play_->call(play_->read(text)); }));
  }
  nb::tuple call(const std::string& tool, const std::string& arguments) {
    return told(with_session([&] { return play_->call(arena::read_call(tool, arguments)); }));
  }

  std::string results() const { return play_->results(); }
  std::size_t done() const { return play_->done(); }
  std::size_t size() const { return play_->size(); }

 private:
  template <class Work>
  std::invoke_result_t<const Work&> with_session(const Work& work) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    if (play_->session() == nullptr) throw WrongOrder("no episode is being walked");
    return work();
  }
  static nb::tuple told(const arena::Outcome& outcome) {
    nb::object ending = nb::none();
    if (outcome.ending) {
      const std::string name(name_of(*outcome.ending));
      ending = nb::str(name.c_str());
    }
    return nb::make_tuple(outcome.carried_out, ending, outcome.told);
  }

  dataset::Dataset data_;  // Play draws from it
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  std::unique_ptr<arena::Play> play_;
  std::atomic_flag busy_;
};

std::unique_ptr<ArenaPlay> open_play(const dataset::Dataset& data, nb::handle episodes,
                                     const std::string& subset, const std::string& prompt,
                                     const std::string& answers, std::uint32_t steps,
                                     std::uint32_t mistakes, std::uint32_t picture_size,
                                     const std::optional<std::filesystem::path>& folder) {
  arena::PlayConfig config;
  config.limits = {steps, mistakes};
  config.answers = answers_named(answers);
  config.picture_size = picture_size;
  if (folder) config.folder = *folder;
  auto set = episode_set(episodes);
  const nb::gil_scoped_release unlocked;
  return std::make_unique<ArenaPlay>(std::move(set), data, subset, prompt, std::move(config));
}

}  // namespace

void bind_arena(nb::module_& m) {
  nb::class_<ArenaPlay>(m, "ArenaPlay", "What enfilade.arena() is made of.")
      .def(nb::new_(&open_play), "dataset"_a, "episodes"_a, "subset"_a, "prompt"_a, "answers"_a,
           "steps"_a, "mistakes"_a, "picture_size"_a, "folder"_a.none())
      .def("begin", &ArenaPlay::begin)
      .def("start_text", &ArenaPlay::start_text)
      .def("step_text", &ArenaPlay::step_text)
      .def("observation", &ArenaPlay::observation)
      .def("functions", &ArenaPlay::functions)
      .def("schema", &ArenaPlay::schema)
      .def("episode", &ArenaPlay::episode)
      .def("draw", &ArenaPlay::draw, nb::sig("def draw(self) -> list[bytes]"))
      .def("answer", &ArenaPlay::answer, "text"_a,
           nb::sig("def answer(self, text: str) -> tuple[bool, str | None, str]"))
      .def("call", &ArenaPlay::call, "tool"_a, "arguments"_a,
           nb::sig("def call(self, tool: str, arguments: str) -> tuple[bool, str | None, str]"))
      .def("results", &ArenaPlay::results)
      .def_prop_ro("done", &ArenaPlay::done)
      .def("__len__", &ArenaPlay::size);
}

}  // namespace enfilade::python
