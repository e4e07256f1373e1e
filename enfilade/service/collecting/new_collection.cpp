// Reads a new collection. It may have megabytes of paths, so all faults are reported at once.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <iterator>
#include <set>

#include "enfilade/r2r/score.h"
#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using detail::Fields;
using json::Element;
using json::Path;

constexpr const char* kFileName = "collection";
constexpr std::size_t kLongestTitle = 80;
constexpr std::size_t kLongestText = 20'000;
constexpr std::size_t kMostItems = 100'000;

constexpr const char* kNameRule = "1 to 40 of a-z, 0-9, - and _";
bool is_title(std::string_view text) { return detail::is_prose(text, kLongestTitle); }
bool is_long_text(std::string_view text) { return detail::is_prose(text, kLongestText); }

class Reader {
 public:
  explicit Reader(const Site& site) : site_(site) {}

  NewCollection read(Element root) {
    const Fields fields(root, root_, faults_,
                        {"name", "title", "kind", "consent", "instructions", "sources"},
                        {"per_item", "lease_minutes", "tasks_per_visit", "platform"});
    NewCollection added;
    if (fields.complete()) {
      Collection& about = added.about;
      about.name = fields.text("name", detail::is_name, kNameRule);
      about.title = fields.text("title", is_title, "1 to 80 printable characters");
      about.kind = kind_ = one_of<Kind>(fields, "kind");
      about.consent = fields.text("consent", is_long_text, "1 to 20000 characters");
      about.instructions = fields.text("instructions", is_long_text, "1 to 20000 characters");
      read_rules(about, fields);
      read_sources(fields["sources"], fields.path("sources"));
      added.items = std::move(items_);
    }
    throw_if_faulty();
    return added;
  }

 private:
  void read_rules(Collection& about, const Fields& fields) {
    if (fields.has("platform")) {
      about.platform = read_platform(fields["platform"], fields.path("platform"));
    }
    about.per_item = fields.integer("per_item", 1, 100, about.kind == Kind::kWrite ? 3 : 1);
    about.lease_seconds = 60L * fields.integer("lease_minutes", 1, 1440, 30);
    about.tasks_per_visit = fields.integer("tasks_per_visit", 0, 1000,
                                           about.platform.kind == PlatformKind::kSelf ? 0 : 1);
  }

  /// One of the enumeration's names; the first value if it is none of them.
  template <class Enum>
  static Enum one_of(const Fields& fields, std::string_view name) {
    const auto known = [](std::string_view text) {
      return detail::find_named<Enum>(text).has_value();
    };
    const std::string text =
        fields.text(name, known, fmt::format("{}", fmt::join(names_of(Enum{}), " or ")));
    return detail::find_named<Enum>(text).value_or(Enum{});
  }

  Platform read_platform(Element element, const Path& path) {
    const Fields fields(element, path, faults_, {"kind"}, {"origins", "completion_code"});
    Platform platform;
    if (!fields.complete()) return platform;
    platform.kind = one_of<PlatformKind>(fields, "kind");
    if (platform.kind == PlatformKind::kMturk) {
      platform.origins = fields.has("origins")
                             ? read_origins(fields["origins"], fields.path("origins"))
                             : mturk_origins();
    } else if (platform.kind == PlatformKind::kProlific) {
      if (fields.has("completion_code")) {
        platform.completion_code =
            fields.text("completion_code", detail::is_external_id, "a study's code");
      } else {
        faults_.error(fields.path("completion_code"), "missing-field",
                      "Prolific pays by it, and it is not there");
      }
    }
    return platform;
  }

  std::vector<std::string> read_origins(Element element, const Path& path) {
    std::vector<std::string> origins;
    const auto list = json::array(element, path, faults_);
    if (!list) return origins;
    for (const Element one : *list) {
      origins.push_back(detail::read_text(one, Path(path, origins.size()), is_origin,
                                          "an origin such as https://host", faults_));
    }
    return origins;
  }

  void read_sources(Element element, const Path& path) {
    const auto list = json::array(element, path, faults_);
    if (!list) return;
    std::size_t k = 0;
    for (const Element source : *list) read_source(source, Path(path, k++));
    if (items_.size() > kMostItems) {
      faults_.error(path, "too-many",
                    fmt::format("{} items; {} are allowed", items_.size(), kMostItems));
    }
    if (items_.empty() && faults_.errors() == 0 && more_.empty()) {
      faults_.error(path, "no-paths", "there is nothing to do in it");
    }
  }

  void read_source(Element element, const Path& path) {
    const Fields fields(element, path, faults_, {"split"}, {"paths", "most"});
    if (!fields.complete()) return;
    const std::string split = fields.text("split", detail::is_name, kNameRule);
    most_ = static_cast<std::size_t>(fields.integer("most", 1, kMostItems, kMostItems));
    if (fields.has("paths")) {
      read_paths(fields["paths"], fields.path("paths"), split);
    } else {
      take_split(fields.path("split"), split);
    }
  }

  void read_paths(Element element, const Path& path, const std::string& split) {
    try {
      r2r::Annotations annotations =
          r2r::parse_annotations(simdjson::minify(element), kFileName, split);
      r2r::look_up_paths(annotations, site_.graphs());
      add_annotations(annotations, path, false);
    } catch (const InvalidInput& error) {
      for (Diagnostic fault : error.diagnostics()) {  // their JSON paths begin at the list of paths
        fault.where =
            path.text() + fault.where.substr(std::min<std::size_t>(1, fault.where.size()));
        more_.push_back(std::move(fault));
      }
    }
  }

  void take_split(const Path& path, const std::string& split) {
    const auto phase = std::ranges::find_if(site_.phases(), [&split](const Phase& one) {
      return one.split == split && one.goals_secret();
    });
    const PublicSplit* open = site_.find_split(split);
    if (kind_ == Kind::kWalk && phase != site_.phases().end()) {
      add_annotations(annotations_of(site_.secret_episodes(*phase)), path, true);
    } else if (open != nullptr && !open->goals_hidden) {
      add_annotations(open->annotations, path, false);
    } else {
      faults_.error(path, open == nullptr ? "unknown-split" : "hidden-goal",
                    fmt::format("{:?}: the data set has {}", split.substr(0, detail::kQuoted),
                                open == nullptr ? "no such split" : "its starts only"));
    }
  }

  static r2r::Annotations annotations_of(const r2r::EpisodeSet& episodes) {
    r2r::Annotations annotations{episodes.split, "", {}};
    for (const r2r::ReferencePath& path : episodes.paths) {
      const graph::NavGraph& graph = episodes.graphs->graph(path.scan);
      r2r::PathAnnotation one{path.path_id, graph.scan(), path.heading, {}, std::nullopt, {}};
      for (const ViewpointIndex v : path.viewpoints) one.path.push_back(graph.id(v));
      annotations.paths.push_back(std::move(one));
    }
    for (const r2r::Episode& episode : episodes.episodes) {
      annotations.paths[episode.path].instructions.push_back(episode.text);
    }
    return annotations;
  }

  void add_annotations(const r2r::Annotations& annotations, const Path& path, bool secret) {
    for (std::size_t k = 0; k < std::min(most_, annotations.paths.size()); ++k) {
      const r2r::PathAnnotation& one = annotations.paths[k];
      const Path here(path, k);
      if (one.goal_hidden()) {
        faults_.error(here, "hidden-goal", "a path of one viewpoint has no goal");
      } else if (!path_ids_.insert(one.path_id).second) {
        faults_.error(here, "repeated-path-id", fmt::format("{} was there before", one.path_id));
      } else if (kind_ == Kind::kWalk && one.instructions.empty()) {
        faults_.error(here, "no-instruction", "there is nothing to walk by");
      } else {
        add_items(annotations.split, one, secret);
      }
    }
  }

  void add_items(const std::string& split, const r2r::PathAnnotation& one, bool secret) {
    Item item{0, split, one.path_id, 0, one.scan, one.heading, one.path, one.distance, "", secret};
    if (kind_ == Kind::kWrite) {
      items_.push_back(std::move(item));
      return;
    }
    for (; item.number < std::min(r2r::kScoredInstructions, one.instructions.size());
         ++item.number) {
      item.instruction = one.instructions[item.number];
      items_.push_back(item);
    }
  }

  void throw_if_faulty() {
    if (more_.empty()) {
      faults_.throw_if_errors();
      return;
    }
    std::vector<Diagnostic> all = faults_.take();
    std::ranges::move(more_, std::back_inserter(all));
    throw InvalidInput(std::move(all));
  }

  const Site& site_;
  const Path root_;
  json::Faults faults_{kFileName};
  std::vector<Diagnostic> more_;  // faults of annotations, which r2r reads
  Kind kind_ = Kind::kWrite;
  std::size_t most_ = kMostItems;
  std::set<std::int64_t> path_ids_;
  std::vector<Item> items_;
};

}  // namespace

NewCollection read_new_collection(const Site& site, std::string_view body) {
  const json::Document document = json::Document::parse(body, kFileName);
  return Reader(site).read(document.root());
}

}  // namespace enfilade::service::collecting
