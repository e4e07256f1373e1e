// Reads a new collection. It may have megabytes of paths, so its faults are reported at once.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/service/collecting/assignments.h"
#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/collecting/kinds/targets.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::service::collecting {
namespace {

using detail::Fields;
using json::Element;
using json::Path;

constexpr const char* kCollectionFile = "collection";
constexpr std::size_t kLongestTitle = 80;
constexpr std::size_t kLongestText = 20'000;
constexpr std::size_t kLongestPay = 200;
constexpr std::size_t kMostItems = 100'000;
constexpr std::size_t kMostQuestions = 20;
constexpr std::size_t kMostChoices = 12;
constexpr int kMostObjects = 20;  // of a path
// RxR's; the readers of its files know no others.
constexpr std::array<std::string_view, 4> kLanguages{"en-IN", "en-US", "hi-IN", "te-IN"};
bool is_language(std::string_view text) {
  return std::ranges::find(kLanguages, text) != kLanguages.end();
}
constexpr int kMostSeed = std::numeric_limits<int>::max();

constexpr const char* kNameRule = "1 to 40 of a-z, 0-9, - and _";
bool is_title(std::string_view text) { return detail::is_prose(text, kLongestTitle); }
bool is_long_text(std::string_view text) { return detail::is_prose(text, kLongestText); }
bool is_pay(std::string_view text) { return text.empty() || detail::is_label(text, kLongestPay); }
bool is_question(std::string_view text) { return detail::is_prose(text, 1000); }
bool is_choice(std::string_view text) { return detail::is_label(text, 200); }
constexpr const char* kTitleRule = "1 to 80 printable characters";
constexpr const char* kTextRule = "1 to 20000 characters";

/// So many different workers have an item, unless it is said.
int usual_places(WorkKind kind) {
  if (is_written(kind)) return 3;
  return kind == WorkKind::kDialogue ? 2 : 1;
}

/// Two have each dialogue.
void check_places(const Collection& about, const Fields& fields, json::Faults& faults) {
  if (about.kind != WorkKind::kDialogue || about.per_item % 2 == 0) return;
  faults.error(fields.path("per_item"), "odd-number",
               fmt::format("{}, and two workers have each dialogue", about.per_item));
}

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

/// Codes of a study; those that are absent leave what the platform has.
void read_codes(Platform& platform, const Fields& fields) {
  for (const auto& [name, code] : {std::pair("completion_code", &platform.completion_code),
                                   std::pair("screen_out_code", &platform.screen_out_code)}) {
    if (fields.has(name)) *code = fields.text(name, detail::is_external_id, "a study's code");
  }
}

std::int64_t random_seed() {
  constexpr std::size_t kDigits = 7;  // hexadecimal ones: below kMostSeed
  return std::stol(detail::new_secret("").substr(0, kDigits), nullptr, 16);
}

bool is_state(std::string_view text) { return find_enum<CollectionState>(text).has_value(); }
/// \param name of a CollectionState, or what isn't one
void set_state(Collection& collection, std::string_view name, std::int64_t now) {
  const auto state = find_enum<CollectionState>(name);
  if (!state) return;
  collection.open = state == CollectionState::kOpen;
  const bool archived = state == CollectionState::kArchived;
  collection.archived = archived ? std::optional(collection.archived.value_or(now)) : std::nullopt;
}

/// Null: the data set has none.
const scan::RegionMap* rooms_of(const Site& site) {
  try {
    return &site.data().regions();
  } catch (const FileError&) {
    return nullptr;
  }
}

class Reader {
 public:
  Reader(const Site& site, store::Database& db, json::Faults& faults)
      : site_(site), db_(db), faults_(faults) {}

  NewCollection read(const Fields& fields) {
    NewCollection added;
    Collection& about = added.about;
    about.name = fields.text("name", detail::is_name, kNameRule);
    about.title = fields.text("title", is_title, kTitleRule);
    about.kind = kind_ = one_of<WorkKind>(fields, "kind");
    about.consent = fields.text("consent", is_long_text, kTextRule);
    about.instructions = fields.text("instructions", is_long_text, kTextRule);
    if (fields.has("platform")) {
      about.platform = read_platform(fields["platform"], fields.path("platform"));
    }
    about.per_item = usual_places(kind_);
    about.tasks_per_visit = about.platform.kind == PlatformKind::kSelf ? 0 : 1;
    read_rules(about, fields);
    check_places(about, fields, faults_);
    if (fields.has("language")) {
      about.language =
          fields.text("language", is_language, fmt::format("{}", fmt::join(kLanguages, ", ")),
                      "unknown-language");
    }
    about.seed = fields.has("seed") ? fields.integer("seed", 0, kMostSeed, 0) : random_seed();
    read_questions(fields, "screening", QuestionStage::kScreening, added.questions);
    read_questions(fields, "checks", QuestionStage::kCheck, added.questions);
    read_sources(fields["sources"], fields.path("sources"));
    added.items = std::move(items_);
    assign_blocks(about.seed, added.items);
    return added;
  }

 private:
  void read_questions(const Fields& fields, std::string_view name, QuestionStage stage,
                      std::vector<Question>& questions) {
    if (!fields.has(name)) return;
    fields.list(name, kMostQuestions, "", [&](Element one, const Path& path) {
      questions.push_back(read_question(one, path, stage));
    });
  }

  Question read_question(Element element, const Path& path, QuestionStage stage) {
    const Fields fields(element, path, faults_, {"question", "choices", "accept"});
    Question question;
    question.stage = stage;
    if (!fields.refuse_others() || !fields.complete()) return question;
    question.text = fields.text("question", is_question, "1 to 1000 characters");
    constexpr const char* kRule = "1 to 200 printable characters";
    question.choices = fields.texts("choices", kMostChoices, is_choice, kRule);
    question.accepted = fields.texts("accept", kMostChoices, is_choice, kRule);
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

  /// One of the enumeration's names; the first value for any other text.
  template <class Enum>
  static Enum one_of(const Fields& fields, std::string_view name) {
    const auto known = [](std::string_view text) { return find_enum<Enum>(text).has_value(); };
    const std::string text =
        fields.text(name, known, fmt::format("{}", fmt::join(names_of(Enum{}), " or ")));
    return find_enum<Enum>(text).value_or(Enum{});
  }

  Platform read_platform(Element element, const Path& path) {
    const Fields fields(element, path, faults_, {"kind"},
                        {"origins", "completion_code", "screen_out_code"});
    Platform platform;
    if (!fields.refuse_others() || !fields.complete()) return platform;
    platform.kind = one_of<PlatformKind>(fields, "kind");
    if (platform.kind == PlatformKind::kMturk) {
      platform.origins = fields.has("origins")
                             ? fields.texts("origins", detail::kAnyNumber, is_origin,
                                            "an origin such as https://host")
                             : mturk_origins();
    } else if (platform.kind == PlatformKind::kProlific) {
      read_codes(platform, fields);
      if (!fields.has("completion_code")) {
        faults_.error(fields.path("completion_code"), "missing-field",
                      "Prolific pays by it, and it is not there");
      }
    }
    return platform;
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
    const bool no_work = std::ranges::all_of(items_, &WorkItem::practice);
    if (no_work && faults_.errors() == 0) {
      const bool chosen = kind_ == WorkKind::kDescribe || kind_ == WorkKind::kDialogue;
      faults_.error(path, "no-paths",
                    chosen ? "at the end of no path is an object that people would ask for, the "
                             "only one of its name in the room"
                           : "there is nothing to do in it");
    }
  }

  static bool is_practice(Element source) {
    bool practice = false;
    return source["practice"].get(practice) == simdjson::SUCCESS && practice;
  }

  void read_source(Element element, const Path& path) {
    simdjson::dom::element named;
    if (kind_ == WorkKind::kFind && element["collection"].get(named) == simdjson::SUCCESS) {
      return take_texts(element, path);
    }
    const Fields fields(element, path, faults_, {"split"},
                        {"paths", "most", "practice", "objects"});
    if (!fields.refuse_others() || !fields.complete()) return;
    practice_ = fields.boolean("practice");
    const std::string split = fields.text("split", detail::is_name, kNameRule);
    most_ = static_cast<std::size_t>(fields.integer("most", 1, kMostItems, kMostItems));
    objects_ = static_cast<std::size_t>(fields.integer("objects", 1, kMostObjects, 1));
    if (practice_ && kind_ == WorkKind::kDialogue) {
      faults_.error(fields.path("practice"), "no-practice", "dialogues have none");
      return;
    }
    if (fields.has("paths")) {
      read_paths(fields["paths"], fields.path("paths"), split);
    } else {
      take_split(fields.path("split"), split);
    }
  }

  /// What workers wrote in a collection of descriptions: {"collection", "state", "most"}.
  void take_texts(Element element, const Path& path) {
    const Fields fields(element, path, faults_, {"collection"}, {"state", "most"});
    if (!fields.refuse_others() || !fields.complete()) return;
    const std::string name = fields.text("collection", detail::is_name, kNameRule);
    const auto is_choice = [](std::string_view text) {
      return text == "accepted" || text == "all";
    };
    const std::string state =
        fields.has("state") ? fields.text("state", is_choice, "accepted or all") : "accepted";
    most_ = static_cast<std::size_t>(fields.integer("most", 1, kMostItems, kMostItems));
    const auto from = find_collection(db_, name);
    if (!from || from->kind != WorkKind::kDescribe) {
      faults_.error(fields.path("collection"), "unknown-collection",
                    fmt::format("{:?} is no collection of descriptions", name));
      return;
    }
    std::size_t taken = 0;
    for (const SplitSize& split : splits_of(db_, from->id)) {
      for (const Assignment& task : work_of(db_, {*from, split.split, state == "all"})) {
        if (taken++ == most_ || items_.size() > kMostItems) return;
        WorkItem item = task.item;
        item.number = numbers_[item.path_id]++;
        item.instruction = task.content;
        item.of = task.id;
        items_.push_back(std::move(item));
      }
    }
  }

  void read_paths(Element element, const Path& path, const std::string& split) {
    try {
      const std::string text = simdjson::minify(element);
      const tasks::Annotations annotations =
          has_target(kind_) ? kinds::parse_any(text, kCollectionFile, split)
                            : tasks::parse_annotations(text, kCollectionFile, split);
      const auto found = tasks::look_up_paths(annotations, site_.graphs());
      // How near a worker comes to a secret goal is not told, whoever brought the path.
      const GoalKeys keys = goal_keys(found, annotations.task, site_.graphs());
      add_annotations(annotations, path,
                      is_followed(kind_) && site_.find_shared(keys).keys.tells());
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
      return one.split == split && one.benchmark == &tasks::benchmark(tasks::Task::kR2r) &&
             one.goals_secret();
    });
    const PublicSplit* open = site_.find_split(split);
    if (kind_ == WorkKind::kWalk && phase != site_.phases().end()) {
      add_annotations(annotations_of(*site_.secret_episodes(*phase).split.on_graph()), path, true);
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
      const auto* object = std::get_if<tasks::NamedObject>(&one.goal);
      const std::pair id(one.path_id, object != nullptr ? object->id : -1);
      if (one.goal_hidden()) {
        faults_.error(here, "hidden-goal", "a path of one viewpoint has no goal");
      } else if (!practice_ && practice_ids_.contains(id)) {
        continue;
      } else if (!(practice_ ? practice_ids_ : path_ids_).insert(id).second) {
        faults_.error(here, "repeated-path-id", fmt::format("{} was there before", one.path_id));
      } else if (is_followed(kind_) && one.instructions.empty()) {
        faults_.error(here, "no-instruction", "there is nothing to walk by");
      } else if (has_target(kind_)) {
        add_targets(annotations.split, one, here);
      } else {
        add_items(annotations.split, one, secret);
      }
    }
  }

  static WorkItem item_of(const std::string& split, const tasks::PathAnnotation& one, bool secret,
                          bool practice) {
    WorkItem item{0,        split,        one.path_id, 0,      one.scan, one.heading,
                  one.path, one.distance, "",          secret, practice};
    if (practice && !one.instructions.empty()) item.instruction = one.instructions.front();
    return item;
  }

  void add_items(const std::string& split, const tasks::PathAnnotation& one, bool secret) {
    WorkItem item = item_of(split, one, secret, practice_);
    if (shows_path(kind_) || practice_) {
      items_.push_back(std::move(item));
      return;
    }
    for (; item.number < std::min(tasks::kScoredInstructions, one.instructions.size());
         ++item.number) {
      item.instruction = one.instructions[item.number];
      items_.push_back(item);
    }
  }

  kinds::KnownObjects& known_objects() {
    if (!known_objects_) known_objects_.emplace(site_.objects(), site_.graphs(), rooms_of(site_));
    return *known_objects_;
  }

  /// Paths whose end shows no object that people would ask for are left out where the annotation
  /// names none.
  void add_targets(const std::string& split, const tasks::PathAnnotation& one, const Path& path) {
    kinds::KnownObjects& known = known_objects();
    const bool region = std::holds_alternative<tasks::NamedRegion>(one.goal);
    if (!known.has_boxes() && (!region || kind_ != WorkKind::kDialogue)) {
      faults_.error(path, "no-objects", "the data set has no boxes of objects (REVERIE's)");
      return;
    }
    const bool object = std::holds_alternative<tasks::NamedObject>(one.goal);
    if ((kind_ != WorkKind::kDialogue && region) || (kind_ == WorkKind::kFind && !object)) {
      faults_.error(path, "no-objects",
                    "names no object; entries of REVERIE do, and what people described here");
      return;
    }
    const std::vector<kinds::PathTarget> targets = known.targets_of(one, practice_ ? 1 : objects_);
    if (targets.empty() && !std::holds_alternative<tasks::NearEnd>(one.goal)) {
      faults_.error(path, "unseen-object", "no viewpoint sees its goal by the data set's boxes");
    }
    for (const kinds::PathTarget& target : targets) {
      WorkItem item = item_of(split, one, false, practice_);
      item.object = target.object;
      item.target = target.name;
      item.region = target.region;
      item.outlines = target.outlines;
      item.number = kind_ == WorkKind::kFind ? numbers_[one.path_id]
                                             : static_cast<std::size_t>(target.object.value_or(0));
      if (kind_ != WorkKind::kFind || practice_) {
        items_.push_back(std::move(item));
        if (kind_ == WorkKind::kFind) ++numbers_[one.path_id];
        continue;
      }
      for (const std::string& instruction : one.instructions) {
        item.instruction = instruction;
        item.number = numbers_[one.path_id]++;
        items_.push_back(item);
      }
    }
  }

  const Site& site_;
  store::Database& db_;
  json::Faults& faults_;
  WorkKind kind_ = WorkKind::kWrite;
  std::size_t most_ = kMostItems;
  bool practice_ = false;    // of the source that is being read
  std::size_t objects_ = 1;  // of a path whose annotation names none
  std::set<std::pair<std::int64_t, std::int64_t>> path_ids_, practice_ids_;  // with the object
  std::optional<kinds::KnownObjects> known_objects_;
  std::map<std::int64_t, std::size_t> numbers_;  // kFind: the next text of a path
  std::vector<WorkItem> items_;
};

}  // namespace

NewCollection read_new_collection(const Site& site, store::Database& db, std::string_view body) {
  NewCollection added;
  detail::read_body(
      body, kCollectionFile, detail::kCollectionLimits,
      {"name", "title", "kind", "consent", "instructions", "sources"},
      {"per_item", "lease_minutes", "tasks_per_visit", "pay", "minutes", "check_every", "platform",
       "seed", "screening", "checks", "language"},
      [&](const Fields& fields, json::Faults& faults) {
        added = Reader(site, db, faults).read(fields);
      },
      detail::Others::kRefused);
  return added;
}

Collection read_changed_collection(const Collection& collection, std::string_view body,
                                   std::int64_t now) {
  Collection changed = collection;
  const auto read = [&](const Fields& fields, json::Faults& faults) {
    if (fields.has("title")) changed.title = fields.text("title", is_title, kTitleRule);
    if (fields.has("consent")) changed.consent = fields.text("consent", is_long_text, kTextRule);
    if (fields.has("instructions")) {
      changed.instructions = fields.text("instructions", is_long_text, kTextRule);
    }
    read_codes(changed.platform, fields);
    if (fields.has("state")) {
      set_state(changed, fields.text("state", is_state, "open, closed or archived"), now);
    }
    read_rules(changed, fields);
    check_places(changed, fields, faults);
  };
  detail::read_body(
      body, kCollectionFile, detail::kFormLimits, {},
      {"state", "title", "consent", "instructions", "completion_code", "screen_out_code",
       "per_item", "lease_minutes", "tasks_per_visit", "pay", "minutes", "check_every"},
      read, detail::Others::kRefused);
  return changed;
}

Collection read_copied_collection(const Collection& collection, std::string_view body) {
  Collection copy = collection;
  detail::read_body(
      body, kCollectionFile, detail::kFormLimits, {"name"}, {"title"},
      [&copy](const Fields& fields, json::Faults& /*faults*/) {
        copy.name = fields.text("name", detail::is_name, kNameRule);
        if (fields.has("title")) {
          copy.title = fields.text("title", is_title, kTitleRule);
        }
      },
      detail::Others::kRefused);
  copy.open = true;
  copy.archived.reset();
  copy.consent_changed = 0;
  copy.seed = random_seed();
  return copy;
}

}  // namespace enfilade::service::collecting
