#include "enfilade/models/data_fingerprint.h"

#include <fmt/format.h>
#include <set>
#include <type_traits>
#include <utility>

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

class Comparison {
 public:
  explicit Comparison(const std::string& file) : file_(file) {}

  void compare(const std::string& where, const char* code, const std::string& trained,
               const std::string& now) {
    if (trained == now) return;
    found.push_back({Severity::kWarning, file_, where, code,
                     fmt::format("trained on {}, here it is {}", trained, now)});
  }

  void compare(const std::string& kind, const char* code,
               const std::map<std::string, std::string>& trained,
               const std::map<std::string, std::string>& now) {
    for (const auto& [name, hash] : trained) {
      const auto here = now.find(name);
      if (here != now.end())
        compare(fmt::format("$.data.{}.{}", kind, name), code, hash, here->second);
    }
  }

  void compare(const features::FeatureInfo& trained, const features::FeatureInfo& now) {
    constexpr const char* kCode = "other-features";
    compare("$.data.features.encoder", kCode, trained.encoder, now.encoder);
    compare("$.data.features.preprocessing", kCode, trained.preprocessing, now.preprocessing);
    compare("$.data.features.weights", kCode, trained.weights, now.weights);
    compare("$.data.features.camera", kCode, text(trained.camera), text(now.camera));
  }

  std::vector<Diagnostic> found;

 private:
  static std::string text(const Camera& camera) {
    return fmt::format("{}x{}, {:g} degrees", camera.width, camera.height,
                       to_degrees(camera.vertical_field_of_view));
  }

  const std::string& file_;
};

}  // namespace

void DataFingerprint::add(const r2r::Annotations& split) {
  annotations[split.split] = detail::hash_of(to_json(split));
}

void DataFingerprint::add_graphs(const r2r::EpisodeSet& episodes) {
  std::set<ScanIndex> scans;
  for (const r2r::ReferencePath& path : episodes.paths) scans.insert(path.scan);
  for (const ScanIndex scan : scans) {
    std::string& hash = graphs[episodes.graphs->scans()[scan.at()]];
    if (hash.empty()) hash = hash_of_graph(episodes.graphs->graph(scan));
  }
}

std::vector<Diagnostic> differences(const DataFingerprint& trained, const DataFingerprint& now,
                                    const std::string& file) {
  Comparison comparison(file);
  comparison.compare("annotations", "other-annotations", trained.annotations, now.annotations);
  comparison.compare("graphs", "other-graph", trained.graphs, now.graphs);
  if (trained.features && now.features) comparison.compare(*trained.features, *now.features);
  return std::move(comparison.found);
}

}  // namespace enfilade::models
