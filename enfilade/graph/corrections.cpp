#include "enfilade/graph/corrections.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/gzip.h"

namespace enfilade::graph {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Action = Correction::Action;

bool is_of_edge(Action action) {
  return action == Action::kAddEdge || action == Action::kRemoveEdge;
}

// Optional; empty if absent.
std::string read_id(const std::optional<Element>& element, const Path& path, Faults& faults) {
  return element ? std::string(json::id(*element, path, faults).value_or("")) : "";
}
std::string read_text(const std::optional<Element>& element, const Path& path, Faults& faults) {
  if (!element) return "";
  const auto text = json::string(*element, path, faults);
  return text ? std::string(*text) : "";
}

std::string read_needed(const std::optional<Element>& element, const Path& path, Faults& faults) {
  if (!element) return "";
  const auto text = json::string(*element, path, faults);
  if (text && text->empty()) faults.error(path, "empty-field", "is empty, and must be filled in");
  return text ? std::string(*text) : "";
}

Action read_action(Element element, const Path& path, Faults& faults) {
  const auto text = json::string(element, path, faults);
  if (!text) return {};
  if (const auto action = find_enum<Action>(*text)) return *action;
  faults.error(path, "bad-action",
               json::describe(element) + ", not add-edge, remove-edge, exclude or include");
  return {};
}

Correction read_correction(Element element, const Path& path, Faults& faults) {
  constexpr std::array<json::Field, 6> kFields{
      {{"action"}, {"from"}, {"who"}, {"why"}, {"to", false}, {"when", false}}};
  std::array<std::optional<Element>, 6> found;
  Correction c;
  if (!json::refuse_others(element, kFields, path, faults) ||
      !json::fields(element, kFields, found, path, faults)) {
    return c;
  }
  c.action = read_action(*found[0], Path(path, "action"), faults);
  c.from = read_id(found[1], Path(path, "from"), faults);
  c.who = read_needed(found[2], Path(path, "who"), faults);
  c.why = read_needed(found[3], Path(path, "why"), faults);
  c.to = read_id(found[4], Path(path, "to"), faults);
  c.when = read_text(found[5], Path(path, "when"), faults);
  if (is_of_edge(c.action) && c.to.empty()) {
    faults.error(path, "missing-field", fmt::format("{} needs \"to\"", enum_name(c.action)));
  } else if (!is_of_edge(c.action) && !c.to.empty()) {
    faults.error(path, "unused-field",
                 fmt::format("{} is of one viewpoint; it has no \"to\"", enum_name(c.action)));
  } else if (!c.to.empty() && c.to == c.from) {
    faults.error(path, "self-edge", fmt::format("an edge from {} to itself", quote(c.from)));
  }
  return c;
}

std::string where(std::size_t i) { return fmt::format("$.corrections[{}]", i); }

std::optional<std::size_t> find(const scan::Connectivity& graph, const std::string& id) {
  const auto at = std::ranges::find(graph.entries, id, &scan::ConnectivityEntry::id);
  if (at == graph.entries.end()) return std::nullopt;
  return static_cast<std::size_t>(at - graph.entries.begin());
}

// Adds or removes one direction of an edge. Returns false if nothing changed.
bool set_edge(scan::Connectivity& graph, std::size_t from, std::size_t to, bool wanted) {
  std::vector<ViewpointIndex>& row = graph.entries[from].unobstructed;
  const ViewpointIndex v(to);
  const auto at = std::ranges::lower_bound(row, v);
  const bool is = at != row.end() && *at == v;
  if (is == wanted) return false;
  if (wanted) {
    row.insert(at, v);
  } else {
    row.erase(at);
  }
  return true;
}

// Returns false if nothing changed. \pre check_ids()
bool apply_one(scan::Connectivity& graph, const Correction& correction) {
  const std::size_t from = find(graph, correction.from).value();
  if (!is_of_edge(correction.action)) {
    const bool wanted = correction.action == Action::kInclude;
    return std::exchange(graph.entries[from].included, wanted) != wanted;
  }
  const std::size_t to = find(graph, correction.to).value();
  const bool wanted = correction.action == Action::kAddEdge;
  const bool there = set_edge(graph, from, to, wanted), back = set_edge(graph, to, from, wanted);
  return there || back;
}

void check_ids(const Corrections& corrections, const scan::Connectivity& graph,
               const std::string& file) {
  std::vector<Diagnostic> faults;
  if (corrections.scan != graph.scan) {
    faults.push_back(
        {Severity::kError, file, "$.scan", "other-scan",
         fmt::format("{}, and the graph is of {}", quote(corrections.scan), quote(graph.scan))});
  }
  for (std::size_t i = 0; i < corrections.list.size(); ++i) {
    const Correction& c = corrections.list[i];
    for (const auto& [name, id] : {std::pair("from", &c.from), std::pair("to", &c.to)}) {
      if (id->empty() || find(graph, *id)) continue;
      faults.push_back({Severity::kError, file, where(i) + "." + name, "unknown-viewpoint",
                        fmt::format("{} is no viewpoint of {}", quote(*id), graph.scan)});
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

}  // namespace

Corrections load_corrections(const std::filesystem::path& file) {
  return parse_corrections(read_text_file(file), file.string());
}

Corrections parse_corrections(std::string_view json, const std::string& file) {
  const json::Document document = json::Document::parse(json, file);
  Faults faults(file);
  const Path root;
  constexpr std::array<json::Field, 2> kFields{{{"scan"}, {"corrections"}}};
  std::array<std::optional<Element>, 2> found;
  Corrections corrections;
  json::refuse_others(document.root(), kFields, root, faults);
  if (json::fields(document.root(), kFields, found, root, faults)) {
    corrections.scan = read_id(found[0], Path(root, "scan"), faults);
    const Path path(root, "corrections");
    if (const auto list = json::array(*found[1], path, faults)) {
      std::size_t i = 0;
      for (const Element element : *list) {
        corrections.list.push_back(read_correction(element, Path(path, i++), faults));
      }
    }
  }
  faults.throw_if_errors();
  return corrections;
}

std::string to_json(const Corrections& corrections) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Correction& c : corrections.list) {
    nlohmann::ordered_json one{{"action", enum_name(c.action)}, {"from", c.from}};
    if (is_of_edge(c.action)) one["to"] = c.to;
    one["who"] = c.who;
    one["why"] = c.why;
    if (!c.when.empty()) one["when"] = c.when;
    list.push_back(std::move(one));
  }
  const nlohmann::ordered_json all{{"scan", corrections.scan}, {"corrections", std::move(list)}};
  return all.dump(1) + "\n";
}

Corrected apply(const scan::Connectivity& connectivity, const Corrections& corrections,
                const std::string& file) {
  Corrected out{connectivity, {}};
  check_ids(corrections, connectivity, file);
  for (std::size_t i = 0; i < corrections.list.size(); ++i) {
    const Correction& c = corrections.list[i];
    if (apply_one(out.connectivity, c)) continue;
    out.notes.push_back({Severity::kWarning, file, where(i), "no-change",
                         fmt::format("{} {}{}{} changes nothing: it is so already",
                                     enum_name(c.action), c.from, c.to.empty() ? "" : " ", c.to)});
  }
  return out;
}

}  // namespace enfilade::graph
