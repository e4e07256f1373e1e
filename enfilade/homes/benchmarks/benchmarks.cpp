#include "enfilade/homes/benchmarks/benchmarks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/homes/benchmarks/derived.h"
#include "enfilade/homes/benchmarks/descriptions.h"
#include "enfilade/homes/benchmarks/dialogues.h"
#include "enfilade/homes/benchmarks/requests.h"
#include "enfilade/homes/benchmarks/site.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/pose_trace.h"
#include "enfilade/tasks/r4r.h"

namespace enfilade::homes::benchmarks {
namespace {

namespace fs = std::filesystem;
using tasks::Annotations;
using tasks::PathAnnotation;
using tasks::Task;

// A folder of a set of homes.
struct Part {
  std::string_view name;  // of the folder, and in options
  std::string_view says;  // in its README
};
constexpr auto kParts = std::to_array<Part>({
    {"r2r-last", "R2R-Last: the last sentences of the instructions in `r2r/`."},
    {"r2r-back", "R2R-Back: the paths of `r2r/` and their way back; `midstop` is where they turn."},
    {"r4r", "R4R: pairs of paths of `r2r/`, joined by the published rule, as `enfilade r4r` does."},
    {"fgr2r",
     "Fine-grained R2R: which piece of an instruction in `r2r/` describes which piece of "
     "the path."},
    {"rxr",
     "RxR: long instructions with timed words, of two guides a path, their pose traces, and "
     "followers."},
    {"reverie",
     "REVERIE: requests that name a room and an object; `BBoxes.json` has the objects "
     "within 3 m of each viewpoint, by view, in boxes exact to 6 pixels in mid-view."},
    {"cvdn",
     "CVDN: dialogues of a navigator who looks for a thing and an oracle who sees the next "
     "5 steps of a shortest path."},
    {"soon",
     "SOON: descriptions of an object, with its outline on the sphere of each viewpoint "
     "that shows it: as released (`.json`), and as lines (`.jsonl`, without token ids)."},
});

std::string readme(const Part& part) {
  return fmt::format(
      "# {}: SYNTHETIC\n\n{}\n\nNothing here is real: a program wrote it about made-up homes, in "
      "the form of the\nbenchmark's own files. Numbers from it are not comparable with any of that "
      "benchmark.\n",
      part.name, part.says);
}

// The path of a test split: its start alone.
PathAnnotation start_of(PathAnnotation path) {
  path.path.resize(std::min<std::size_t>(path.path.size(), 1));
  path.distance.reset();
  if (!std::holds_alternative<tasks::NearEnd>(path.goal)) path.goal = tasks::HiddenGoal{};
  return path;
}

// A test entry of fine-grained R2R does not say which piece of the path is meant.
PathAnnotation hide_pieces(PathAnnotation entry) {
  entry = start_of(std::move(entry));
  for (tasks::InstructionDetails& details : entry.details) {
    for (tasks::SubInstruction& part : details.parts) part.places.reset();
  }
  return entry;
}

// Test entries of RxR have no path_id.
PathAnnotation hide_guide(PathAnnotation guide) {
  guide = start_of(std::move(guide));
  std::string& id = guide.details.at(0).id;
  id.erase(0, id.find('_') + 1);
  guide.id = id;
  guide.path_id = std::stoll(id);
  guide.group.reset();
  return guide;
}

// Test entries of REVERIE go by the number of the path, so that there is one for each.
void keep_one_request(std::vector<PathAnnotation>& entries, std::string_view split) {
  if (split != "test") return;
  const auto same = [](const PathAnnotation& a, const PathAnnotation& b) {
    return a.path_id == b.path_id;
  };
  entries.erase(std::unique(entries.begin(), entries.end(), same), entries.end());
}

PathAnnotation hide_request(PathAnnotation request) {
  request = start_of(std::move(request));
  request.id = fmt::to_string(request.path_id);
  request.group.reset();
  return request;
}

std::size_t number_of_soon_split(std::string_view split) {
  constexpr std::array<std::string_view, 5> kSplits{"train", "val_seen_instrs", "val_unseen_instrs",
                                                    "val_unseen_house", "test"};
  return static_cast<std::size_t>(std::ranges::find(kSplits, split) - kSplits.begin());
}

void number_descriptions(std::vector<PathAnnotation>& entries, std::string_view split) {
  std::int64_t number = 0, group = -1;
  std::optional<std::int64_t> of;
  for (PathAnnotation& entry : entries) {
    if (entry.group != of) ++group;
    of = entry.group;
    entry.group = group;
    entry.path_id = number;
    entry.id = fmt::format("{}-{}", number_of_soon_split(split), number++);
  }
}

// Without what ties alternatives together, which lines do not have.
std::string soon_lines(Annotations annotations) {
  for (PathAnnotation& entry : annotations.paths) entry.group.reset();
  return tasks::to_text(annotations);
}

}  // namespace

// Writes the files of one part.
class Benchmarks::Writer {
 public:
  Writer(const Benchmarks& all, sets::WrittenFiles& files,
         const std::map<std::string, Annotations>& splits, const graph::GraphSet& graphs)
      : all_(all), files_(files), splits_(splits), graphs_(graphs) {}

  void write(const Part& part) {
    part_ = part.name;
    put("", "README.md", readme(part));
    (this->*writer_of(part.name))();
  }

 private:
  // How the files of a part come about.
  struct Form {
    Task task;
    // `{}` stands for the split.
    std::string_view file;
    // The entries of a path of R2R.
    std::function<std::vector<PathAnnotation>(const PathAnnotation& path, const Said& said)> of;
    // The names of R2R's four splits here.
    std::array<std::string_view, 4> names{"train", "val_seen", "val_unseen", "test"};
    // Numbers the entries of a split.
    std::function<void(std::vector<PathAnnotation>& entries, std::string_view split)> finish = {};
    // Makes a test entry of a whole one.
    std::function<PathAnnotation(PathAnnotation)> hide = start_of;
    std::function<std::string(const Annotations&)> text = [](const Annotations& annotations) {
      return tasks::to_text(annotations);
    };
  };

  static void (Writer::*writer_of(std::string_view part))() {
    static const std::map<std::string_view, void (Writer::*)()> kWriters{
        {"r2r-last", &Writer::write_last}, {"r2r-back", &Writer::write_back},
        {"r4r", &Writer::write_joined},    {"fgr2r", &Writer::write_pieces},
        {"rxr", &Writer::write_guided},    {"reverie", &Writer::write_requested},
        {"cvdn", &Writer::write_talked},   {"soon", &Writer::write_described}};
    return kWriters.at(part);
  }

  void write_last() {
    write(Form{.task = Task::kR2rLast, .file = "R2R_{}.json", .of = [](const auto& path, auto&) {
                 return std::vector{last_sentences(path)};
               }});
  }
  void write_back() {
    write(Form{.task = Task::kR2rBack, .file = "R2R_{}.json", .of = [](const auto& path, auto&) {
                 return std::vector{there_and_back(path)};
               }});
  }
  void write_joined() {
    for (const char* split : kOpenSplits) {
      const auto joined =
          tasks::join_paths(splits_.at(split), graphs_, {.threads = all_.options_.threads});
      put("", fmt::format("R4R_{}.json", split), to_json(joined));
    }
  }
  void write_pieces() {
    write(Form{.task = Task::kR2r,
               .file = "FGR2R_{}.json",
               .of = [](const auto& path,
                        const Said& said) { return std::vector{in_pieces(path, said.parts)}; },
               .hide = hide_pieces});
  }
  void write_guided() {
    write(Form{.task = Task::kRxr,
               .file = "rxr_{}_guide.jsonl",
               .of = [](const auto&, const Said& said) { return said.guided.guides; },
               .hide = hide_guide});
    for (const char* split : kOpenSplits) {
      std::vector<tasks::Demonstration> walks;
      for (const PathAnnotation& path : splits_.at(split).paths) {
        const auto& own = said(path).guided;
        walks.insert(walks.end(), own.walks.begin(), own.walks.end());
        for (std::size_t k = 0; k < own.traces.size(); ++k) {
          const std::string name =
              tasks::pose_trace_name(tasks::TraceRole::kGuide, own.walks[k].instruction_id);
          put("", fmt::format("pose_traces/rxr_{}/{}", split, name), tasks::to_npz(own.traces[k]));
        }
      }
      put("", fmt::format("rxr_{}_follower.jsonl", split), tasks::to_text(walks));
    }
  }
  void write_requested() {
    write(Form{.task = Task::kReverie,
               .file = "REVERIE_{}.json",
               .of = [](const auto&, const Said& said) { return said.requests; },
               .finish = keep_one_request,
               .hide = hide_request});
    put("", "BBoxes.json", all_.boxes_.to_json(false));
  }
  void write_talked() {
    std::int64_t instance = 0;
    write(Form{.task = Task::kCvdn,
               .file = "{}.json",
               .of = [](const auto&, const Said& said) { return said.dialogue; },
               .names = {"train", "val_seen", "val_unseen", "test_cleaned"},
               .finish =
                   [&instance](std::vector<PathAnnotation>& entries, std::string_view) {
                     for (PathAnnotation& entry : entries) {
                       entry.path_id = instance++;
                       entry.id = entry.details.at(0).id = fmt::to_string(entry.path_id);
                     }
                   }});
  }
  // Both forms; what R2R calls val seen are new goals in known homes.
  void write_described() {
    Form form{.task = Task::kSoon,
              .file = "{}.json",
              .of = [](const auto&, const Said& said) { return said.descriptions; },
              .names = {"train", "val_unseen_instrs", "val_unseen_house", "test"},
              .finish = number_descriptions,
              .text = tasks::to_released_soon};
    const auto write_both = [this, &form] {
      form.file = "{}.json";
      form.text = tasks::to_released_soon;
      write(form);
      form.file = "{}.jsonl";
      form.text = soon_lines;
      write(form);
    };
    write_both();
    form.of = [](const auto&, const Said& said) { return said.again; };
    form.names = {"val_seen_instrs", "", "", ""};
    write_both();
  }

  // Splits without a name here are left out.
  void write(const Form& form) const {
    constexpr std::array<const char*, 4> kSplits{"train", "val_seen", "val_unseen", "test_hidden"};
    for (std::size_t s = 0; s < kSplits.size(); ++s) {
      const bool hidden = s == 3;
      if (form.names.at(s).empty() || (hidden && !all_.options_.test_split)) continue;
      Annotations annotations{std::string(form.names.at(s)), "", {}, form.task};
      for (const PathAnnotation& path : splits_.at(kSplits.at(s)).paths) {
        for (PathAnnotation& one : form.of(path, said(path))) {
          annotations.paths.push_back(std::move(one));
        }
      }
      if (form.finish) form.finish(annotations.paths, annotations.split);
      const std::string file = fmt::format(fmt::runtime(form.file), annotations.split);
      if (hidden) {
        put("hidden", file, form.text(annotations));
        for (PathAnnotation& entry : annotations.paths) entry = form.hide(std::move(entry));
      }
      put("", file, form.text(annotations));
    }
  }

  // \param before  "hidden", or nothing
  void put(const std::string& before, const std::string& file, const std::string& text) const {
    files_.write(fs::path(before) / part_ / file, text);
  }

  const Said& said(const PathAnnotation& path) const { return all_.said_.at(path.path_id); }

  static constexpr std::array<const char*, 3> kOpenSplits{"train", "val_seen", "val_unseen"};

  const Benchmarks& all_;
  sets::WrittenFiles& files_;
  const std::map<std::string, Annotations>& splits_;
  const graph::GraphSet& graphs_;
  std::string_view part_;  // that is being written
};

Benchmarks::Benchmarks(const HomePathOptions& options) : options_(options) {
  const std::vector<std::string> known = home_tasks();
  for (const std::string& name : options.tasks) {
    if (name == "r2r" || std::ranges::count(known, name) > 0) continue;
    throw ArgumentError(fmt::format("tasks: {:?} is none of {}", name, fmt::join(known, ", ")));
  }
}

bool Benchmarks::wants(std::string_view task) const {
  return std::ranges::count(options_.tasks, task) > 0;
}

void Benchmarks::add_home(const BuiltHome& built, const graph::NavGraph& graph,
                          std::span<PathAnnotation> paths) {
  const instructions::Sights sights(built.home, *built.tracer, graph, 8192, options_.threads);
  const instructions::SpokenHome home{built.home, graph, sights};
  for (PathAnnotation& path : paths) {
    std::vector<ViewpointIndex> viewpoints;
    for (const std::string& id : path.path) viewpoints.push_back(graph.find(id).value());
    Said& said = said_[path.path_id];
    for (const instructions::Speaker speaker : instructions::kSpeakers) {
      Rng rng(options_.seed, static_cast<std::uint64_t>(path.path_id),
              static_cast<std::uint64_t>(speaker));
      instructions::Spoken spoken =
          describe_in_parts(home, viewpoints, path.heading.value, speaker, rng.next());
      path.instructions.push_back(std::move(spoken.text));
      said.parts.push_back(std::move(spoken.parts));
      ++instructions_;
    }
  }
  const auto looks = {"rxr", "reverie", "cvdn", "soon"};
  if (std::ranges::none_of(looks, [this](const char* task) { return wants(task); })) return;
  const Site site(built, graph, sights, options_.threads);
  if (wants("reverie")) site.add_boxes(boxes_);
  for (const PathAnnotation& path : paths) {
    Said& said = said_[path.path_id];
    if (wants("rxr")) said.guided = write_guides(site, path, options_.seed);
    if (wants("reverie")) said.requests = write_requests(site, path, options_.seed);
    if (wants("cvdn")) said.dialogue = write_dialogue(site, path, options_.seed);
    if (!wants("soon")) continue;
    said.descriptions = write_descriptions(site, path, options_.seed);
    // In training homes, some paths get other descriptions, to be held out.
    if (path.path_id % 6 == 0) said.again = write_descriptions(site, path, options_.seed + 1);
  }
}

void Benchmarks::write(sets::WrittenFiles& files, const std::map<std::string, Annotations>& splits,
                       const graph::GraphSet& graphs) const {
  Writer writer(*this, files, splits, graphs);
  for (const Part& part : kParts) {
    if (wants(part.name)) writer.write(part);
  }
}

}  // namespace enfilade::homes::benchmarks

namespace enfilade::homes {

std::vector<std::string> home_tasks() {
  std::vector<std::string> names;
  for (const benchmarks::Part& part : benchmarks::kParts) names.emplace_back(part.name);
  return names;
}

}  // namespace enfilade::homes
