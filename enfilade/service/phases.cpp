#include "enfilade/service/phases.h"

#include <fmt/format.h>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service {
namespace {

constexpr int kMostPerDay = 1000;

bool is_scores(std::string_view text) { return text == "public" || text == "hidden"; }

std::string nonempty(const detail::Fields& fields, std::string_view name, json::Faults& faults) {
  const auto value = json::string(fields[name], fields.path(name), faults);
  if (value && value->empty()) faults.error(fields.path(name), "empty-text", "must not be empty");
  return std::string(value.value_or(""));
}

/// Reads one entry of "phases"; none if it has faults.
std::optional<Phase> read_phase(json::Element element, const json::Path& path,
                                json::Faults& faults) {
  constexpr const char* kNames = "1 to 40 of a-z, 0-9, - and _";
  const std::size_t before = faults.errors();
  const detail::Fields fields(element, path, faults, {"name", "split"},
                              {"title", "annotations", "scores", "per_day"});
  if (!fields.complete()) return std::nullopt;
  Phase phase;
  phase.name = fields.text("name", detail::is_name, kNames, "bad-name");
  phase.split = fields.text("split", detail::is_name, kNames, "bad-name");
  phase.title = fields.has("title") ? nonempty(fields, "title", faults) : phase.name;
  if (fields.has("annotations")) phase.annotations = nonempty(fields, "annotations", faults);
  if (fields.has("scores") &&
      fields.text("scores", is_scores, "\"public\" or \"hidden\"", "bad-scores") == "hidden") {
    phase.scores = Scores::kHidden;
  }
  phase.per_day = fields.integer("per_day", 1, kMostPerDay, phase.per_day);
  if (faults.errors() != before) return std::nullopt;
  return phase;
}

}  // namespace

std::vector<Phase> parse_phases(std::string_view text, const std::string& file) {
  const json::Document document = json::Document::parse(text, file);
  json::Faults faults(file);
  const json::Path root;
  const detail::Fields fields(document.root(), root, faults, {"phases"});
  const json::Path list_path(root, "phases");
  const auto list =
      fields.complete() ? json::array(fields["phases"], list_path, faults) : std::nullopt;
  faults.throw_if_errors();
  std::vector<Phase> phases;
  std::set<std::string> names;
  std::size_t k = 0;
  for (const json::Element element : *list) {
    const json::Path path(list_path, k++);
    auto phase = read_phase(element, path, faults);
    if (!phase) continue;
    if (!names.insert(phase->name).second) {
      faults.error(path, "repeated-name", fmt::format("{:?} is there twice", phase->name));
    }
    phases.push_back(std::move(*phase));
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
