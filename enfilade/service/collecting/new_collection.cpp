// Reads a new collection. It may have megabytes of paths, so its faults are reported at once.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <limits>
#include <set>

#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/collecting/order.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/json_limits.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/score.h"

namespace enfilade::service::collecting {
namespace {

using detail::Fields;
using json::Element;
using json::Path;

constexpr const char* kFileName = "collection";
constexpr std::size_t kLongestTitle = 80;
constexpr std::size_t kLongestText = 20'000;
constexpr std::size_t kLongestPay = 200;
constexpr std::size_t kMostItems = 100'000;
constexpr std::size_t kMostQuestions = 20;
constexpr std::size_t kMostChoices = 12;
constexpr int kMostSeed = std::numeric_limits<int>::max();

constexpr const char* kNameRule = "1 to 40 of a-z, 0-9, - and _";
bool is_title(std::string_view text) { return detail::is_prose(text, kLongestTitle); }
bool is_long_text(std::string_view text) { return detail::is_prose(text, kLongestText); }
bool is_pay(std::string_view text) { return text.empty() || detail::is_label(text, kLongestPay); }
bool is_question(std::string_view text) { return detail::is_prose(text, 1000); }
bool is_choice(std::string_view text) { return detail::is_label(text, 200); }
constexpr const char* kTitleRule = "1 to 80 printable characters";
constexpr const char* kTextRule = "1 to 20000 characters";

/// Fields that are absent leave what `about` has.
void read_rules(Collection& about, const Fields& fields) {
  about.per_item = fields.integer("per_item", 1, 100, about.per_item);
  about.lease_seconds =
      60L * fields.integer("lease_minutes", 1, 1440, static_cast<int>(about.lease_seconds / 60));
  about.tasks_per_visit = fields.integer("tasks_per_visit", 0, 1000, about.tasks_per_visit);
  about.check_every = fields.integer("check_every", 1, 1000, about.check_every);
  if (fields.has("pay")) {
    about.pay = fields.text("pay", is_pay, "up to 200 printable characters on one line");
  }
  if (fields.has("minutes")) about.minutes = fields.number("minutes", 0, 600);
}

std::int64_t random_seed() {
  constexpr std::size_t kDigits = 7;  // hexadecimal ones: below kMostSeed
  return std::stol(detail::new_secret("").substr(0, kDigits), nullptr, 16);
}

bool is_state(std::string_view text) {
  return detail::find_named<CollectionState>(text).has_value();
}
/// \param name of a CollectionState, or what isn't one
void set_state(Collection& collection, std::string_view name, std::int64_t now) {
  const auto state = detail::find_named<CollectionState>(name);
  if (!state) return;
  collection.open = state == CollectionState::kOpen;
  if (state != CollectionState::kArchived) {
    collection.archived.reset();
  } else if (!collection.archived) {
    collection.archived = now;
  }
}

class Reader {
 public:
  explicit Reader(const Site& site) : site_(site) {}

  NewCollection read(Element root) {
    const Fields fields(root, root_, faults_,
                        {"name", "title", "kind", "consent", "instructions", "sources"},
                        {"per_item", "lease_minutes", "tasks_per_visit", "pay", "minutes",
                         "check_every", "platform", "seed", "screening", "checks"});
    NewCollection added;
    if (fields.complete()) {
      Collection& about = added.about;
      about.name = fields.text("name", detail::is_name, kNameRule);
      about.title = fields.text("title", is_title, kTitleRule);
      about.kind = kind_ = one_of<Kind>(fields, "kind");
      about.consent = fields.text("consent", is_long_text, kTextRule);
      about.instructions = fields.text("instructions", is_long_text, kTextRule);
      if (fields.has("platform")) {
        about.platform = read_platform(fields["platform"], fields.path("platform"));
      }
      about.per_item = kind_ == Kind::kWrite ? 3 : 1;
      about.tasks_per_visit = about.platform.kind == PlatformKind::kSelf ? 0 : 1;
      read_rules(about, fields);
      about.seed = fields.has("seed") ? fields.integer("seed", 0, kMostSeed, 0) : random_seed();
      read_questions(fields, "screening", Stage::kScreening, added.questions);
      read_questions(fields, "checks", Stage::kCheck, added.questions);
      read_sources(fields["sources"], fields.path("sources"));
      added.items = std::move(items_);
      assign_blocks(about.seed, added.items);
    }
    faults_.throw_if_errors();
    return added;
  }

 private:
  void read_questions(const Fields& fields, std::string_view name, Stage stage,
                      std::vector<Question>& questions) {
    if (!fields.has(name)) return;
    const Path path = fields.path(name);
    const auto list = json::array(fields[name], path, faults_);
    if (!list) return;
    std::size_t k = 0;
    for (const Element one : *list) {
      if (faults_.full()) return;
      if (k == kMostQuestions) {
        faults_.error(path, "too-many", fmt::format("more than {}", kMostQuestions));
        return;
      }
      questions.push_back(read_question(one, Path(path, k++), stage));
    }
  }

  Question read_question(Element element, const Path& path, Stage stage) {
    const Fields fields(element, path, faults_, {"question", "choices", "accept"});
    Question question;
    question.stage = stage;
    if (!fields.complete()) return question;
    question.text = fields.text("question", is_question, "1 to 1000 characters");
    question.choices = read_choices(fields["choices"], fields.path("choices"));
    question.accepted = read_choices(fields["accept"], fields.path("accept"));
    if (question.choices.size() < 2) {
      faults_.error(fields.path("choices"), "too-few", "two choices are the least");
    }
    const auto known = [&](const std::string& one) {
      return std::ranges::find(question.choices, one) != question.choices.end();
    };
    if (question.accepted.empty() || !std::ranges::all_of(question.accepted, known)) {
      faults_.error(fields.path("accept"), "unknown-choice", "one or more of the choices");
    }
    return question;
  }

  std::vector<std::string> read_choices(Element element, const Path& path) {
    std::vector<std::string> choices;
    const auto list = json::array(element, path, faults_);
    if (!list) return choices;
    for (const Element one : *list) {
      if (choices.size() == kMostChoices) {
        faults_.error(path, "too-many", fmt::format("more than {}", kMostChoices));
        break;
      }
      choices.push_back(detail::read_text(one, Path(path, choices.size()), is_choice,
                                          "1 to 200 printable characters", faults_));
    }
    return choices;
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
    const Fields fields(element, path, faults_, {"kind"},
                        {"origins", "completion_code", "screen_out_code"});
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
      if (fields.has("screen_out_code")) {
        platform.screen_out_code =
            fields.text("screen_out_code", detail::is_external_id, "a study's code");
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
    // Practice first: its paths are not given out as work.
    for (const bool practice : {true, false}) {
      std::size_t k = 0;
      for (const Element source : *list) {
        const Path here(path, k++);
        if (faults_.full() || items_.size() > kMostItems) break;
        if (is_practice(source) == practice) read_source(source, here);
      }
    }
    if (items_.size() > kMostItems) {
      faults_.error(path, "too-many",
                    fmt::format("{} items; {} are allowed", items_.size(), kMostItems));
    }
    const bool no_work = std::ranges::all_of(items_, &Item::practice);
    if (no_work && faults_.errors() == 0) {
      faults_.error(path, "no-paths", "there is nothing to do in it");
    }
  }

  static bool is_practice(Element source) {
    bool practice = false;
    return source["practice"].get(practice) == simdjson::SUCCESS && practice;
  }

  void read_source(Element element, const Path& path) {
    const Fields fields(element, path, faults_, {"split"}, {"paths", "most", "practice"});
    if (!fields.complete()) return;
    practice_ = fields.has("practice") &&
                json::boolean(fields["practice"], fields.path("practice"), faults_).value_or(false);
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
      tasks::Annotations annotations =
          tasks::parse_annotations(simdjson::minify(element), kFileName, split);
      tasks::look_up_paths(annotations, site_.graphs());
      add_annotations(annotations, path, false);
    } catch (const InvalidInput& error) {
      for (Diagnostic fault : error.diagnostics()) {  // their JSON paths begin at the list of paths
        fault.where =
            path.text() + fault.where.substr(std::min<std::size_t>(1, fault.where.size()));
        faults_.add(std::move(fault));
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

  static tasks::Annotations annotations_of(const tasks::EpisodeSet& episodes) {
    tasks::Annotations annotations{episodes.split, "", {}};
    for (const tasks::ReferencePath& path : episodes.paths) {
      const graph::NavGraph& graph = episodes.graphs->graph(path.scan);
      tasks::PathAnnotation one{path.path_id, graph.scan(), path.heading, {}, std::nullopt, {}};
      for (const ViewpointIndex v : path.viewpoints) one.path.push_back(graph.id(v));
      annotations.paths.push_back(std::move(one));
    }
    for (const tasks::Episode& episode : episodes.episodes) {
      annotations.paths[episode.path].instructions.push_back(episode.text);
    }
    return annotations;
  }

  void add_annotations(const tasks::Annotations& annotations, const Path& path, bool secret) {
    for (std::size_t k = 0; k < std::min(most_, annotations.paths.size()); ++k) {
      const tasks::PathAnnotation& one = annotations.paths[k];
      const Path here(path, k);
      if (faults_.full() || items_.size() > kMostItems) break;
      if (one.goal_hidden()) {
        faults_.error(here, "hidden-goal", "a path of one viewpoint has no goal");
      } else if (!practice_ && practice_ids_.contains(one.path_id)) {
        continue;
      } else if (!(practice_ ? practice_ids_ : path_ids_).insert(one.path_id).second) {
        faults_.error(here, "repeated-path-id", fmt::format("{} was there before", one.path_id));
      } else if (kind_ == Kind::kWalk && one.instructions.empty()) {
        faults_.error(here, "no-instruction", "there is nothing to walk by");
      } else {
        add_items(annotations.split, one, secret);
      }
    }
  }

  void add_items(const std::string& split, const tasks::PathAnnotation& one, bool secret) {
    Item item{0,        split,        one.path_id, 0,      one.scan, one.heading,
              one.path, one.distance, "",          secret, practice_};
    if (practice_ && !one.instructions.empty()) item.instruction = one.instructions.front();
    if (kind_ == Kind::kWrite || practice_) {
      items_.push_back(std::move(item));
      return;
    }
    for (; item.number < std::min(tasks::kScoredInstructions, one.instructions.size());
         ++item.number) {
      item.instruction = one.instructions[item.number];
      items_.push_back(item);
    }
  }

  const Site& site_;
  const Path root_;
  json::Faults faults_{kFileName};
  Kind kind_ = Kind::kWrite;
  std::size_t most_ = kMostItems;
  bool practice_ = false;  // of the source that is being read
  std::set<std::int64_t> path_ids_, practice_ids_;
  std::vector<Item> items_;
};

}  // namespace

NewCollection read_new_collection(const Site& site, std::string_view body) {
  detail::check_limits(body, kFileName, detail::kCollectionLimits);
  const json::Document document = json::Document::parse(body, kFileName);
  return Reader(site).read(document.root());
}

Collection read_changed_collection(const Collection& collection, std::string_view body,
                                   std::int64_t now) {
  detail::check_limits(body, kFileName, detail::kFormLimits);
  const json::Document document = json::Document::parse(body, kFileName);
  json::Faults faults(kFileName);
  const Path root;
  const Fields fields(
      document.root(), root, faults, {},
      {"state", "title", "consent", "instructions", "completion_code", "screen_out_code",
       "per_item", "lease_minutes", "tasks_per_visit", "pay", "minutes", "check_every"});
  Collection changed = collection;
  if (fields.complete()) {
    if (fields.has("title")) changed.title = fields.text("title", is_title, kTitleRule);
    if (fields.has("consent")) changed.consent = fields.text("consent", is_long_text, kTextRule);
    if (fields.has("instructions")) {
      changed.instructions = fields.text("instructions", is_long_text, kTextRule);
    }
    for (const auto& [name, code] :
         {std::pair("completion_code", &changed.platform.completion_code),
          std::pair("screen_out_code", &changed.platform.screen_out_code)}) {
      if (fields.has(name)) *code = fields.text(name, detail::is_external_id, "a study's code");
    }
    if (fields.has("state")) {
      set_state(changed, fields.text("state", is_state, "open, closed or archived"), now);
    }
    read_rules(changed, fields);
  }
  faults.throw_if_errors();
  return changed;
}

Collection read_copied_collection(const Collection& collection, std::string_view body) {
  detail::check_limits(body, kFileName, detail::kFormLimits);
  const json::Document document = json::Document::parse(body, kFileName);
  json::Faults faults(kFileName);
  const Path root;
  const Fields fields(document.root(), root, faults, {"name"}, {"title"});
  Collection copy = collection;
  if (fields.complete()) {
    copy.name = fields.text("name", detail::is_name, kNameRule);
    if (fields.has("title")) copy.title = fields.text("title", is_title, kTitleRule);
  }
  faults.throw_if_errors();
  copy.open = true;
  copy.archived.reset();
  copy.consent_changed = 0;
  copy.seed = random_seed();
  return copy;
}

}  // namespace enfilade::service::collecting
