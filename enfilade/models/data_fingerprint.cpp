#include "enfilade/models/data_fingerprint.h"

#include <fmt/format.h>
#include <set>
#include <type_traits>

#include "enfilade/models/detail/hash.h"

namespace enfilade::models {
namespace {

template <class T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_arithmetic_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// With its length, so that "ab", "c" differs from "a", "bc".
void append(std::string& bytes, const std::string& text) {
  append(bytes, text.size());
  bytes += text;
}

std::string hash_of_graph(const graph::NavGraph& graph) {
  std::string bytes;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    append(bytes, graph.id(v));
    append(bytes, graph.included(v));
    const Vec3f at = graph.position(v);
    append(bytes, at.x);
    append(bytes, at.y);
    append(bytes, at.z);
    for (const graph::Edge& edge : graph.edges(v)) append(bytes, edge.target.value);
  }
  return detail::hash_of(bytes);
}

std::string text_of(const Camera& camera) {
  return fmt::format("{}x{}, {:g} degrees", camera.width, camera.height,
                     to_degrees(camera.vertical_field_of_view));
}

}  // namespace

void DataFingerprint::add(const tasks::Annotations& split) {
  annotations[split.split] = detail::hash_of(to_json(split));
}

void DataFingerprint::add(const tasks::ContinuousEpisodes& split) {
  annotations[split.split] = detail::hash_of(to_json(split));
}

void DataFingerprint::add_graphs(const tasks::EpisodeSet& episodes) {
  std::set<ScanIndex> scans;
  for (const tasks::ReferencePath& path : episodes.paths) scans.insert(path.scan);
  for (const ScanIndex scan : scans) {
    std::string& hash = graphs[episodes.graphs->scans()[scan.at()]];
    if (hash.empty()) hash = hash_of_graph(episodes.graphs->graph(scan));
  }
}

std::vector<Diagnostic> differences(const DataFingerprint& trained, const DataFingerprint& now,
                                    const std::string& file) {
  std::vector<Diagnostic> found;
  const auto compare = [&](const std::string& where, const char* code, const std::string& before,
                           const std::string& here) {
    if (before == here) return;
    found.push_back({Severity::kWarning, file, "$.data." + where, code,
                     fmt::format("trained on {}, here it is {}", before, here)});
  };
  const auto compare_hashes = [&](const std::string& kind, const char* code, const auto& before,
                                  const auto& here) {
    for (const auto& [name, hash] : before) {
      const auto other = here.find(name);
      if (other != here.end()) compare(fmt::format("{}.{}", kind, name), code, hash, other->second);
    }
  };
  compare_hashes("annotations", "other-annotations", trained.annotations, now.annotations);
  compare_hashes("graphs", "other-graph", trained.graphs, now.graphs);
  if (!trained.features || !now.features) return found;
  const features::FeatureInfo &before = *trained.features, &here = *now.features;
  constexpr const char* kCode = "other-features";
  compare("features.encoder", kCode, before.encoder, here.encoder);
  compare("features.preprocessing", kCode, before.preprocessing, here.preprocessing);
  compare("features.weights", kCode, before.weights, here.weights);
  compare("features.camera", kCode, text_of(before.camera), text_of(here.camera));
  return found;
}

}  // namespace enfilade::models
