#include "enfilade/neural/duet/episode_state.h"

#include <ATen/ATen.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/check.h"

namespace enfilade::neural::duet {
namespace {

constexpr double kPictureWidth = 640, kPictureHeight = 480;

// A tensor that is filled element by element.
template <class T>
class Filled {
 public:
  Filled(const std::vector<std::int64_t>& shape, at::ScalarType type)
      : tensor_(at::zeros(shape, type)),
        data_(tensor_.data_ptr<T>()),
        strides_(tensor_.strides().vec()) {}
  T* at(std::int64_t i, std::int64_t j) { return data_ + i * strides_[0] + j * strides_[1]; }
  at::Tensor tensor() const { return tensor_; }

 private:
  at::Tensor tensor_;
  T* data_;
  std::vector<std::int64_t> strides_;
};

// Rows of different lengths as one tensor, zeros behind the shorter.
at::Tensor padded(const std::vector<at::Tensor>& rows) {
  std::int64_t longest = 0;
  for (const at::Tensor& row : rows) longest = std::max(longest, row.size(0));
  std::vector<at::Tensor> all;
  for (const at::Tensor& row : rows) {
    const std::int64_t missing = longest - row.size(0);
    all.push_back(missing == 0 ? row
                               : at::cat({row, at::zeros({missing, row.size(1)}, row.options())}));
  }
  return at::stack(all);
}

// Angle feature relative to a pose, then the box.
void write_location(float* to, Radians heading, Radians elevation, const ViewpointPose& pose,
                    float height, float width) {
  const agents::AngleFeature angles =
      agents::angle_feature(heading - pose.heading(), elevation - pose.elevation());
  std::ranges::copy(angles, to);
  to[4] = height;
  to[5] = width;
  to[6] = height * width;
}

// Angle features and kinds of one panorama's tokens.
void write_tokens(const Stand& stand, std::int64_t i, Filled<float>& locations,
                  Filled<std::int64_t>& types) {
  std::int64_t j = 0;
  for (const sim::Candidate& c : stand.place->panorama->candidates) {
    *types.at(i, j) = 1;
    write_location(locations.at(i, j++), c.heading, c.elevation, stand.pose, 1, 1);
  }
  const auto& all = stand.place->panorama->token_views;
  for (const std::uint32_t view : std::span(all).subspan(static_cast<std::size_t>(j))) {
    const ViewpointPose centre{{}, view};
    write_location(locations.at(i, j++), centre.heading(), centre.elevation(), stand.pose, 1, 1);
  }
  for (const features::ObjectView& object : stand.place->objects) {
    *types.at(i, j) = 2;
    write_location(locations.at(i, j++), object.heading, object.elevation, stand.pose,
                   static_cast<float>(object.height / kPictureHeight),
                   static_cast<float>(object.width / kPictureWidth));
  }
}

// Features of views in the order of the tokens, zeros behind the shorter panoramas.
at::Tensor views_of(std::span<const Stand> stands, std::int64_t longest, std::int64_t columns) {
  Filled<float> views({std::ssize(stands), longest, columns}, at::kFloat);
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const float* const from = stands[i].place->views.data_ptr<float>();
    float* to = longest > 0 ? views.at(static_cast<std::int64_t>(i), 0) : nullptr;
    for (const std::uint32_t view : stands[i].place->panorama->token_views) {
      to = std::copy_n(from + view * columns, columns, to);
    }
  }
  return views.tensor();
}

// All but the views.
PanoramaInput tokens_of(std::span<const Stand> stands, const DuetConfig& config) {
  std::int64_t longest = 0;
  std::vector<std::int64_t> views, objects;
  std::vector<at::Tensor> object_features;
  for (const Stand& stand : stands) {
    views.push_back(std::ssize(stand.place->panorama->token_views));
    objects.push_back(std::ssize(stand.place->objects));
    if (config.object != 0) object_features.push_back(stand.place->object_features);
    longest = std::max(longest, views.back() + objects.back());
  }
  PanoramaInput input;
  input.view_counts = at::tensor(views, at::kLong);
  if (config.object != 0) {
    input.objects = padded(object_features);
    input.object_counts = at::tensor(objects, at::kLong);
  }
  Filled<float> locations({std::ssize(stands), longest, kLocation}, at::kFloat);
  Filled<std::int64_t> types({std::ssize(stands), longest}, at::kLong);
  for (std::size_t i = 0; i < stands.size(); ++i) {
    write_tokens(stands[i], static_cast<std::int64_t>(i), locations, types);
  }
  input.locations = locations.tensor();
  input.types = types.tensor();
  return input;
}

std::int64_t most_views(std::span<const Stand> stands) {
  std::int64_t most = 0;
  for (const Stand& stand : stands) {
    most = std::max(most, std::ssize(stand.place->panorama->token_views));
  }
  return most;
}

std::vector<Stand> stands_of(std::span<DuetEpisodeState* const> states) {
  std::vector<Stand> stands;
  for (const DuetEpisodeState* state : states) stands.push_back({state->place, state->pose});
  return stands;
}

// Where a node is for an agent.
agents::MapFeature feature_of(const DuetEpisodeState& state, TopologicalMap::Node node) {
  return agents::map_feature(state.map, *state.map.find(state.pose.viewpoint), node,
                             state.pose.heading(), state.pose.elevation());
}

// Rows of the map of one state.
struct MapRows {
  Filled<std::int64_t>& steps;
  Filled<float>& positions;
  Filled<float>& distances;
  Filled<bool>& mask;
  Filled<bool>& visited;

  void write(std::int64_t i, const DuetEpisodeState& state,
             std::span<const TopologicalMap::Node> rows) {
    std::ranges::copy(agents::kStopFeature, positions.at(i, 0));
    *mask.at(i, 0) = true;
    for (std::size_t a = 0; a < rows.size(); ++a) {
      const auto row = static_cast<std::int64_t>(a) + 1;
      std::ranges::copy(feature_of(state, rows[a]), positions.at(i, row));
      *steps.at(i, row) = state.map.step_id(rows[a]);
      *mask.at(i, row) = true;
      *visited.at(i, row) = state.map.visited(rows[a]);
      for (std::size_t b = 0; b < rows.size(); ++b) {
        distances.at(i, row)[b + 1] = static_cast<float>(state.map.distance(rows[a], rows[b]));
      }
    }
  }
};

// Embeddings of the maps' rows, zeros for stop and padding: a few large operations in place of many
// small ones, which autograd would have to follow back one by one.
at::Tensor node_embeddings(std::span<DuetEpisodeState* const> states,
                           std::span<const std::vector<TopologicalMap::Node>> rows,
                           std::int64_t longest, const at::Tensor& pool) {
  std::vector<std::int64_t> from, to;
  std::vector<float> share;
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (std::size_t a = 0; a < rows[i].size(); ++a) {
      const auto& parts = states[i]->embeddings[rows[i][a]];
      for (const std::int64_t part : parts) {
        from.push_back(part);
        to.push_back(static_cast<std::int64_t>(i) * longest + static_cast<std::int64_t>(a) + 1);
        share.push_back(1 / static_cast<float>(parts.size()));
      }
    }
  }
  const auto n = std::ssize(states);
  const c10::Device device = pool.device();
  const at::Tensor picked = pool.index_select(0, at::tensor(from, at::kLong).to(device)) *
                            at::tensor(share).to(device).unsqueeze(1);
  return at::zeros({n * longest, pool.size(1)}, picked.options())
      .index_add(0, at::tensor(to, at::kLong).to(device), picked)
      .view({n, longest, pool.size(1)});
}

// Tokens of the viewpoint of one state, stop before them.
struct TokenRows {
  Filled<float>& positions;
  Filled<bool>& choices;
  Filled<bool>& objects;
  Filled<std::int64_t>& nodes;

  void write(std::int64_t i, std::int64_t length, const DuetEpisodeState& state,
             std::span<const TopologicalMap::Node> rows) {
    const agents::MapFeature start = feature_of(state, 0);
    for (std::int64_t j = 0; j < length; ++j) {
      std::ranges::copy(start, positions.at(i, j));
      *nodes.at(i, j) = -1;
    }
    *choices.at(i, 0) = true;
    std::int64_t j = 1;
    for (const sim::Candidate& candidate : state.place->panorama->candidates) {
      const TopologicalMap::Node node = *state.map.find(candidate.viewpoint);
      std::ranges::copy(feature_of(state, node), positions.at(i, j) + kPosition);
      *choices.at(i, j) = true;
      *nodes.at(i, j++) = std::ranges::find(rows, node) - rows.begin() + 1;
    }
    const auto first = static_cast<std::int64_t>(state.place->panorama->token_views.size()) + 1;
    for (std::int64_t k = 0; k < std::ssize(state.place->objects); ++k) {
      *objects.at(i, first + k) = true;
    }
  }
};

}  // namespace

DuetEpisodeState::DuetEpisodeState(const RolloutEpisode& walked, std::size_t place_in_batch,
                                   const graph::NavGraph& scan)
    : episode(&walked),
      number(place_in_batch),
      graph(&scan),
      pose{walked.start, walked.start_view} {
  walk.path = {{walked.start}};
}

void DuetEpisodeState::look(const RolloutRunner::SeenViewpoint& seen, std::size_t step) {
  place = &seen;
  map.arrive(*graph, pose.viewpoint, seen.panorama->candidates, static_cast<std::uint32_t>(step));
  embeddings.resize(map.size());
  objects.resize(map.size());
}

void DuetEpisodeState::embed(std::int64_t mean, std::int64_t first) {
  embeddings[node()] = {mean};
  for (std::size_t i = 0; i < place->panorama->candidates.size(); ++i) {
    const TopologicalMap::Node seen = *map.find(place->panorama->candidates[i].viewpoint);
    if (!map.visited(seen)) embeddings[seen].push_back(first + static_cast<std::int64_t>(i));
  }
}

void DuetEpisodeState::go(TopologicalMap::Node to, RolloutRunner& runner,
                          const DuetConfig& config) {
  std::vector<ViewpointIndex> way;
  map.path(node(), to, way);
  const ViewpointIndex before = way.size() > 1 ? way[way.size() - 2] : pose.viewpoint;
  const RolloutRunner::SeenViewpoint& last = runner.place(config, {episode->scan, before});
  const auto view = agents::arrival_view(*last.panorama, way.back());
  EN_CHECK(view.has_value());
  pose = {way.back(), *view};
  walk.path.push_back(way);
}

void DuetEpisodeState::remember(ViewpointIndex viewpoint, double stop_probability,
                                std::string best_object) {
  const TopologicalMap::Node visited = *map.find(viewpoint);
  walk.stop_probabilities.emplace_back(viewpoint, stop_probability);
  stops.remember(visited, stop_probability);
  objects[visited] = std::move(best_object);
}

void DuetEpisodeState::finish(agents::FinalStop rule) {
  const TopologicalMap::Node stop = rule == agents::FinalStop::kAlways ? *stops.best() : node();
  walk.stop = map.viewpoint(stop);
  walk.object = objects[stop];
  std::vector<ViewpointIndex> way;
  agents::final_walk(map, node(), stops, agents::LastAction::kStop, rule, way);
  if (!way.empty()) walk.path.push_back(std::move(way));
}

std::vector<ViewpointIndex> DuetEpisodeState::walked() const {
  std::vector<ViewpointIndex> all;
  for (const auto& part : walk.path) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::pair<at::Tensor, at::Tensor> words_of(std::span<const RolloutEpisode> episodes,
                                           const DuetConfig& config) {
  std::vector<at::Tensor> rows;
  std::vector<std::int64_t> lengths;
  for (const RolloutEpisode& episode : episodes) {
    const auto n =
        std::min(std::ssize(episode.words), static_cast<std::ptrdiff_t>(config.max_words));
    lengths.push_back(n);
    rows.push_back(at::tensor(episode.words, at::kLong).narrow(0, 0, n).unsqueeze(1));
  }
  return {padded(rows).squeeze(2), at::tensor(lengths, at::kLong)};
}

PanoramaInput panorama_of(std::span<const Stand> stands, const DuetConfig& config) {
  PanoramaInput input = tokens_of(stands, config);
  input.views = views_of(stands, most_views(stands), config.image);
  return input;
}

PanoramaInput panorama_of(std::span<DuetEpisodeState* const> states, const DuetConfig& config) {
  return panorama_of(stands_of(states), config);
}

PanoramaInput panorama_of(std::span<DuetEpisodeState* const> states, const DuetConfig& config,
                          core::ResidentViews& views) {
  const std::vector<Stand> stands = stands_of(states);
  PanoramaInput input = tokens_of(stands, config);
  const std::int64_t n = std::ssize(states), longest = most_views(stands);
  std::vector<std::int64_t> rows(static_cast<std::size_t>(n * longest),
                                 core::ResidentViews::kNothing);
  for (std::int64_t i = 0; i < n; ++i) {
    const DuetEpisodeState& state = *states[static_cast<std::size_t>(i)];
    const std::int64_t first = views.first_row({state.episode->scan, state.pose.viewpoint});
    std::ranges::transform(state.place->panorama->token_views, rows.begin() + i * longest,
                           [first](std::uint32_t view) { return first + view; });
  }
  input.views = views.gather(rows).view({n, longest, config.image});
  return input;
}

NavigationInput places_of(std::span<DuetEpisodeState* const> states,
                          std::span<const std::vector<TopologicalMap::Node>> rows,
                          std::int64_t longest, const DuetConfig& config) {
  const auto n = std::ssize(states);
  std::int64_t g = 1;
  for (const auto& list : rows) g = std::max(g, std::ssize(list) + 1);
  const std::int64_t v = longest + 1;
  Filled<std::int64_t> steps({n, g}, at::kLong), nodes({n, v}, at::kLong);
  Filled<float> positions({n, g, kPosition}, at::kFloat), distances({n, g, g}, at::kFloat);
  Filled<float> token_positions({n, v, 2 * kPosition}, at::kFloat);
  Filled<bool> mask({n, g}, at::kBool), visited({n, g}, at::kBool);
  Filled<bool> choices({n, v}, at::kBool), objects({n, v}, at::kBool);
  MapRows map{steps, positions, distances, mask, visited};
  TokenRows tokens{token_positions, choices, objects, nodes};
  for (std::int64_t i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    map.write(i, *states[at], rows[at]);
    tokens.write(i, v, *states[at], rows[at]);
  }
  NavigationInput input;
  input.steps = steps.tensor();
  input.node_positions = positions.tensor();
  input.node_mask = mask.tensor();
  input.visited = visited.tensor();
  input.distances = distances.tensor();
  input.token_positions = token_positions.tensor();
  input.choices = choices.tensor();
  if (config.object != 0) input.objects = objects.tensor();
  input.node_of_token = nodes.tensor();
  return input;
}

NavigationInput navigation_of(std::span<DuetEpisodeState* const> states,
                              std::span<const std::vector<TopologicalMap::Node>> rows,
                              const Tokens& panorama, const at::Tensor& pool,
                              const DuetConfig& config) {
  const auto n = std::ssize(states);
  NavigationInput input = places_of(states, rows, panorama.values.size(1), config);
  input.nodes = node_embeddings(states, rows, input.steps.size(1), pool);
  input.tokens = at::cat({at::zeros({n, 1, pool.size(1)}, pool.options()), panorama.values}, 1);
  input.token_mask = at::cat({at::ones({n, 1}, panorama.mask.options()), panorama.mask}, 1);
  return input;
}

}  // namespace enfilade::neural::duet
