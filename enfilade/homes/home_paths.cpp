#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/benchmarks/described_home.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/instructions/speaker.h"
#include "enfilade/homes/sets/home_list.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/path_sampling.h"
#include "enfilade/tasks/pose_trace.h"
#include "enfilade/tasks/r4r.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;
using benchmarks::DescribedHome;
using tasks::Annotations;
using tasks::PathAnnotation;
using tasks::Task;

class Writer;

// A folder of a set of homes.
struct Part {
  std::string_view name;  // of the folder, and in options
  std::string_view says;  // in its README
  void (Writer::*write)();
};

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

// Test entries of REVERIE go by the number of the path, so that there is one for each. Those with
// their goals do so too: results name them by it, and it does not name the object.
void keep_one_request(std::vector<PathAnnotation>& entries, std::string_view split) {
  if (split != "test") return;
  const auto same = [](const PathAnnotation& a, const PathAnnotation& b) {
    return a.path_id == b.path_id;
  };
  entries.erase(std::unique(entries.begin(), entries.end(), same), entries.end());
  for (PathAnnotation& entry : entries) entry.id = fmt::to_string(entry.path_id);
}

PathAnnotation hide_request(PathAnnotation request) {
  request = start_of(std::move(request));
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

// The texts of one path of Room-to-Room.
struct Said {
  std::vector<std::vector<instructions::SpokenPart>> parts;  // of each instruction
  benchmarks::GuidedPath guided;
  std::vector<PathAnnotation> requests, dialogue, descriptions, again;
};

// The texts of all homes.
class Texts {
 public:
  // \throws ArgumentError for a name in options.tasks that home_tasks() has not
  explicit Texts(const HomePathOptions& options) : options_(options) {
    const std::vector<std::string> known = home_tasks();
    for (const std::string& name : options.tasks) {
      if (name == "r2r" || std::ranges::count(known, name) > 0) continue;
      throw ArgumentError(fmt::format("tasks: {:?} is none of {}", name, fmt::join(known, ", ")));
    }
  }

  const HomePathOptions& options() const { return options_; }
  bool wants(std::string_view task) const { return std::ranges::count(options_.tasks, task) > 0; }
  const Said& of(const PathAnnotation& path) const { return said_.at(path.path_id); }
  const tasks::ObjectBoxes& boxes() const { return boxes_; }
  // How many instructions of Room-to-Room add_home() has written.
  std::size_t instructions() const { return instructions_; }

  // Adds a home's paths, which get their three instructions of Room-to-Room.
  void add_home(const BuiltHome& built, const graph::NavGraph& graph,
                std::span<PathAnnotation> paths) {
    const instructions::ThingsInView sights(built.home, *built.tracer, graph, 8192,
                                            options_.threads);
    const instructions::SpokenHome home{built.home, graph, sights};
    for (PathAnnotation& path : paths) {
      std::vector<ViewpointIndex> viewpoints;
      for (const std::string& id : path.path) viewpoints.push_back(graph.find(id).value());
      Said& said = said_[path.path_id];
      for (const instructions::SpeakerKind speaker : instructions::kSpeakers) {
        Rng rng(options_.seed, static_cast<std::uint64_t>(path.path_id),
                static_cast<std::uint64_t>(speaker));
        instructions::Spoken spoken =
            describe(home, viewpoints, path.heading.value, speaker, rng.next());
        path.instructions.push_back(std::move(spoken.text));
        said.parts.push_back(std::move(spoken.parts));
        ++instructions_;
      }
    }
    const auto looks = {"rxr", "reverie", "cvdn", "soon"};
    if (std::ranges::none_of(looks, [this](const char* task) { return wants(task); })) return;
    const DescribedHome site(built, graph, sights, options_.threads);
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

 private:
  const HomePathOptions& options_;
  std::map<std::int64_t, Said> said_;  // by path_id
  tasks::ObjectBoxes boxes_;
  std::size_t instructions_ = 0;
};

// Writes the files of one part.
class Writer {
 public:
  // \param splits  of Room-to-Room, as tasks::split_by_building() gives them, with instructions
  Writer(const Texts& texts, sets::WrittenFiles& files,
         const std::map<std::string, Annotations>& splits, const graph::GraphSet& graphs)
      : texts_(texts), files_(files), splits_(splits), graphs_(graphs) {}

  // Writes `<name>/` of a part, and hidden goals below `hidden/<name>/`. \throws FileError
  void write(const Part& part) {
    part_ = part.name;
    put("", "README.md", readme(part));
    (this->*part.write)();
  }

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

  void write_last() {
    write(Form{.task = Task::kR2rLast, .file = "R2R_{}.json", .of = [](const auto& path, auto&) {
                 return std::vector{benchmarks::last_sentences(path)};
               }});
  }
  void write_back() {
    write(Form{.task = Task::kR2rBack, .file = "R2R_{}.json", .of = [](const auto& path, auto&) {
                 return std::vector{benchmarks::there_and_back(path)};
               }});
  }
  void write_joined() {
    for (const char* split : kOpenSplits) {
      const auto joined =
          tasks::join_paths(splits_.at(split), graphs_, {.threads = texts_.options().threads});
      put("", fmt::format("R4R_{}.json", split), to_json(joined));
    }
  }
  void write_pieces() {
    write(Form{
        .task = Task::kR2r,
        .file = "FGR2R_{}.json",
        .of = [](const auto& path,
                 const Said& said) { return std::vector{benchmarks::in_pieces(path, said.parts)}; },
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
        const auto& own = texts_.of(path).guided;
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
    put("", "BBoxes.json", texts_.boxes().to_json(false));
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

 private:
  // Splits without a name here are left out.
  void write(const Form& form) const {
    constexpr std::array<const char*, 4> kSplits{"train", "val_seen", "val_unseen", "test_hidden"};
    for (std::size_t s = 0; s < kSplits.size(); ++s) {
      const bool hidden = s == 3;
      if (form.names.at(s).empty() || (hidden && !texts_.options().test_split)) continue;
      Annotations annotations{std::string(form.names.at(s)), "", {}, form.task};
      for (const PathAnnotation& path : splits_.at(kSplits.at(s)).paths) {
        for (PathAnnotation& one : form.of(path, texts_.of(path))) {
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

  static constexpr std::array<const char*, 3> kOpenSplits{"train", "val_seen", "val_unseen"};

  const Texts& texts_;
  sets::WrittenFiles& files_;
  const std::map<std::string, Annotations>& splits_;
  const graph::GraphSet& graphs_;
  std::string_view part_;  // that is being written
};

constexpr auto kParts = std::to_array<Part>({
    {"r2r-last", "R2R-Last: the last sentences of the instructions in `r2r/`.",
     &Writer::write_last},
    {"r2r-back", "R2R-Back: the paths of `r2r/` and their way back; `midstop` is where they turn.",
     &Writer::write_back},
    {"r4r", "R4R: pairs of paths of `r2r/`, joined by the published rule, as `enfilade r4r` does.",
     &Writer::write_joined},
    {"fgr2r",
     "Fine-grained R2R: which piece of an instruction in `r2r/` describes which piece of "
     "the path.",
     &Writer::write_pieces},
    {"rxr",
     "RxR: long instructions with timed words, of two guides a path, their pose traces, and "
     "followers.",
     &Writer::write_guided},
    {"reverie",
     "REVERIE: requests that name a room and an object; `BBoxes.json` has the objects "
     "within 3 m of each viewpoint, by view, in boxes exact to 6 pixels in mid-view.",
     &Writer::write_requested},
    {"cvdn",
     "CVDN: dialogues of a navigator who looks for a thing and an oracle who sees the next "
     "5 steps of a shortest path.",
     &Writer::write_talked},
    {"soon",
     "SOON: descriptions of an object, with its outline on the sphere of each viewpoint "
     "that shows it: as released (`.json`), and as lines (`.jsonl`, without token ids).",
     &Writer::write_described},
});

void write_splits(sets::WrittenFiles& files,
                  const std::map<std::string, tasks::Annotations>& splits, bool test_split) {
  const auto write = [&](const char* part, const char* name, const char* split) {
    files.write(fs::path(part) / fmt::format("R2R_{}.json", name), to_json(splits.at(split)));
  };
  for (const char* split : {"train", "val_seen", "val_unseen"}) write("r2r", split, split);
  if (!test_split) return;
  write("r2r", "test", "test");
  write("hidden", "test", "test_hidden");
}

}  // namespace

std::vector<std::string> home_tasks() {
  std::vector<std::string> names;
  for (const Part& part : kParts) names.emplace_back(part.name);
  return names;
}

HomePathReport write_home_paths(const fs::path& folder, const HomePathOptions& options,
                                const SetProgress& progress) {
  const std::vector<HomeEntry> homes = read_home_list(folder);
  const std::size_t least = options.test_split ? kLeastHomes : kLeastHomes - 1;
  if (homes.size() < least) {
    throw FileError(fmt::format("{}: {} homes, but splits by building need {} at least",
                                folder.string(), homes.size(), least));
  }
  const auto graphs = graph::GraphSet::open(folder / "connectivity");
  const tasks::SamplingOptions sampling{.per_building = options.per_home,
                                        .seed = options.seed,
                                        .draws_of = sets::draws_of,
                                        .threads = options.threads};
  const auto regions = scan::RegionMap::load(folder / "regions" / "region_to_panorama.json");
  std::vector<tasks::PathAnnotation> paths = tasks::sample_paths(*graphs, regions, sampling);
  Texts texts(options);
  for (std::size_t i = 0; i < homes.size(); ++i) {
    if (progress) progress(homes[i].scan, i, homes.size());
    const HomeEntry& home = homes[i];
    const auto own = std::ranges::equal_range(paths, home.scan, {}, &PathAnnotation::scan);
    if (own.empty()) continue;
    // The home is built again for its instructions.
    texts.add_home(build_home(home.plan, HomeSurfaces::kPlain), graphs->graph(home.scan),
                   std::span(own.begin(), own.end()));
  }
  if (progress) progress("", homes.size(), homes.size());
  tasks::SplitOptions split{.val_seen_share = options.val_seen_share, .seed = options.seed};
  if (!options.test_split) split.test_scans = 0;
  const auto splits = tasks::split_by_building(paths, split);
  sets::WrittenFiles files(folder);
  write_splits(files, splits, options.test_split);
  Writer writer(texts, files, splits, *graphs);
  for (const Part& part : kParts) {
    if (texts.wants(part.name)) writer.write(part);
  }
  files.finish();
  return {paths.size(), texts.instructions()};
}

}  // namespace enfilade::homes
