#include "enfilade/service/phases.h"

#include <fmt/format.h>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service {
namespace {

constexpr int kMostPerDay = 1000;

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
    detail::Found<kFields.size()> found;
    if (!json::fields(element, kFields, found, path_, faults_)) return std::nullopt;
    const std::size_t before = faults_.errors();
    Phase phase;
    phase.name = name("name", *found[0]);
    phase.split = name("split", *found[1]);
    phase.title = found[2] ? text("title", *found[2]) : phase.name;
    if (found[3]) phase.annotations = text("annotations", *found[3]);
    if (found[4]) phase.scores = scores(*found[4]);
    if (found[5]) {
      phase.per_day =
          detail::integer_within(*found[5], {path_, "per_day"}, 1, kMostPerDay, faults_);
    }
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
    return detail::text_that(detail::is_name, element, {path_, field},
                             "1 to 40 of a-z, 0-9, - and _", faults_, "bad-name");
  }

  Scores scores(json::Element element) {
    const auto known = [](std::string_view text) { return text == "public" || text == "hidden"; };
    const std::string text = detail::text_that(known, element, {path_, "scores"},
                                               "\"public\" or \"hidden\"", faults_, "bad-scores");
    return text == "hidden" ? Scores::kHidden : Scores::kPublic;
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
  detail::Found<1> found;
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
