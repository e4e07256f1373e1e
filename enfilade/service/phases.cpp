#include "enfilade/service/phases.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/file.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service {
namespace {

constexpr std::size_t kShown = 40;  // of a value that a message repeats
constexpr std::int64_t kMostPerDay = 1000;

/// Reads one entry of "phases".
class PhaseReader {
 public:
  PhaseReader(const json::Path& path, json::Faults& faults) : path_(path), faults_(faults) {}

  std::optional<Phase> read(json::Element element) {
    static constexpr std::array<json::Field, 6> kFields{{{"name"},
                                                         {"split"},
                                                         {"title", false},
                                                         {"annotations", false},
                                                         {"scores", false},
                                                         {"per_day", false}}};
    std::array<std::optional<json::Element>, kFields.size()> found;
    if (!json::fields(element, kFields, found, path_, faults_)) return std::nullopt;
    const std::size_t before = faults_.errors();
    Phase phase;
    phase.name = name("name", *found[0]);
    phase.split = name("split", *found[1]);
    phase.title = found[2] ? text("title", *found[2]) : phase.name;
    if (found[3]) phase.annotations = text("annotations", *found[3]);
    if (found[4]) phase.scores = scores(*found[4]);
    if (found[5]) phase.per_day = per_day(*found[5]);
    if (faults_.errors() != before) return std::nullopt;
    return phase;
  }

 private:
  std::string text(std::string_view field, json::Element element) {
    const json::Path here(path_, field);
    const auto value = json::string(element, here, faults_);
    if (value && value->empty()) faults_.error(here, "empty-text", "must not be empty");
    return std::string(value.value_or(""));
  }

  std::string name(std::string_view field, json::Element element) {
    const json::Path here(path_, field);
    const auto value = json::string(element, here, faults_);
    if (value && !detail::is_name(*value)) {
      faults_.error(
          here, "bad-name",
          fmt::format("{:?}, not 1 to 40 of a-z, 0-9, - and _", value->substr(0, kShown)));
    }
    return std::string(value.value_or(""));
  }

  Scores scores(json::Element element) {
    const json::Path here(path_, "scores");
    const auto value = json::string(element, here, faults_);
    if (value && *value != "public" && *value != "hidden") {
      faults_.error(here, "bad-scores",
                    fmt::format("{:?}, not \"public\" or \"hidden\"", value->substr(0, kShown)));
    }
    return value == "hidden" ? Scores::kHidden : Scores::kPublic;
  }

  int per_day(json::Element element) {
    const json::Path here(path_, "per_day");
    const auto value = json::integer(element, here, faults_);
    if (value && (*value < 1 || *value > kMostPerDay)) {
      faults_.error(here, "out-of-range", fmt::format("{}, not from 1 to {}", *value, kMostPerDay));
    }
    return static_cast<int>(std::clamp<std::int64_t>(value.value_or(1), 1, kMostPerDay));
  }

  const json::Path& path_;
  json::Faults& faults_;
};

}  // namespace

std::vector<Phase> parse_phases(std::string_view text, const std::string& file) {
  const json::Document document = json::Document::parse(text, file);
  json::Faults faults(file);
  const json::Path root;
  const std::array<json::Field, 1> wanted{{{"phases"}}};
  std::array<std::optional<json::Element>, 1> found;
  std::vector<Phase> phases;
  std::set<std::string> names;
  const json::Path list_path(root, "phases");
  if (json::fields(document.root(), wanted, found, root, faults)) {
    if (const auto list = json::array(*found[0], list_path, faults)) {
      std::size_t k = 0;
      for (const json::Element element : *list) {
        const json::Path path(list_path, k++);
        auto phase = PhaseReader(path, faults).read(element);
        if (!phase) continue;
        if (!names.insert(phase->name).second) {
          faults.error(path, "repeated-name", fmt::format("{:?} is there twice", phase->name));
        }
        phases.push_back(std::move(*phase));
      }
    }
  }
  faults.throw_if_errors();
  return phases;
}

std::vector<Phase> load_phases(const std::filesystem::path& file) {
  std::vector<Phase> phases = parse_phases(read_file(file), file.string());
  for (Phase& phase : phases) {
    if (phase.goals_secret()) phase.annotations = file.parent_path() / phase.annotations;
  }
  return phases;
}

}  // namespace enfilade::service
