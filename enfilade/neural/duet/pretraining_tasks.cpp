#include "enfilade/neural/duet/pretraining_tasks.h"

#include <ATen/ATen.h>
#include <ATen/core/Reduction.h>
#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/core/transformer_ops.h"
#include "enfilade/neural/duet/episode_state.h"

namespace enfilade::neural::duet {
namespace {

constexpr double kLeastNorm = 1e-6;

using Ids = std::vector<std::int64_t>;

at::Tensor tensor_of(const Ids& values) { return at::tensor(values, at::kLong); }

// A path on which each step leads to a neighbour. Other benchmarks than R2R leave viewpoints out.
std::vector<ViewpointIndex> walkable(const graph::NavGraph& graph, const RolloutEpisode& episode) {
  std::vector<ViewpointIndex> path{episode.reference.front()};
  for (const ViewpointIndex next : std::span(episode.reference).subspan(1)) {
    const ViewpointIndex here = path.back();
    if (next == here) continue;
    if (graph.edge(here, next) != nullptr) {
      path.push_back(next);
      continue;
    }
    const auto way = graph.path(here, next);
    if (!way) {
      throw ArgumentError(fmt::format("episode {}: no way leads from {:?} to {:?} of its path",
                                      episode.id, graph.id(here), graph.id(next)));
    }
    path.insert(path.end(), way->begin() + 1, way->end());
  }
  return path;
}

// A batch in the making.
class Builder {
 public:
  Builder(RolloutRunner& runner, const DuetConfig& config, const models::InstructionWords& words,
          std::span<const RolloutEpisode> episodes, PretrainingTask task,
          const PretrainingDraws& draws)
      : runner_(runner), config_(config), words_(words), episodes_(episodes), draws_(draws) {
    batch_.task = task;
    states_.reserve(episodes.size());
  }

  PretrainingBatch build() {
    for (std::size_t i = 0; i < episodes_.size(); ++i) {
      random_.emplace_back(draws_.seed, draws_.stream, i);
      walk(i);
    }
    std::tie(batch_.ids, batch_.lengths) = words_of(episodes_, config_);
    batch_.panoramas = panorama_of(stands_, config_);
    longest_ = batch_.panoramas.locations.size(1);
    std::vector<DuetEpisodeState*> states;
    for (DuetEpisodeState& state : states_) {
      states.push_back(&state);
      nodes_.emplace_back(state.map.rows().begin(), state.map.rows().end());
    }
    batch_.navigation = places_of(states, nodes_, longest_, config_);
    write_rows();
    write_labels();
    if (batch_.task == PretrainingTask::kWords) mask_words();
    if (batch_.task == PretrainingTask::kViews) mask_views();
    return std::move(batch_);
  }

 private:
  // How many viewpoints of a path of `length` are walked.
  std::size_t visits(std::size_t length, Rng& rng) const {
    std::size_t walked = length;
    if (batch_.task == PretrainingTask::kViews) walked = 1 + rng.below(length);
    if (batch_.task == PretrainingTask::kAction && length > 1 &&
        rng.uniform() >= draws_.whole_path) {
      walked = 1 + rng.below(length - 1);
    }
    return std::min(walked, static_cast<std::size_t>(config_.steps - 1));  // the table has a 0 too
  }

  void walk(std::size_t i) {
    const RolloutEpisode& episode = episodes_[i];
    EN_CHECK(!episode.reference.empty());
    const graph::NavGraph& graph = runner_.graph(episode.scan);
    const std::vector<ViewpointIndex> path = walkable(graph, episode);
    const std::size_t walked = visits(path.size(), random_[i]);
    DuetEpisodeState& state = states_.emplace_back(episode, i, graph);
    first_.push_back(stands_.size());
    for (std::size_t t = 0; t < walked; ++t) {
      if (t > 0) state.go(*state.map.find(path[t]), runner_, config_);
      state.look(runner_.place(config_, {episode.scan, state.pose.viewpoint}), t);
      stands_.push_back({state.place, state.pose});
    }
    next_.push_back(walked < path.size() ? std::optional(path[walked]) : std::nullopt);
  }

  std::size_t end(std::size_t i) const {
    return i + 1 < first_.size() ? first_[i + 1] : stands_.size();
  }

  void write_rows() {
    std::size_t most = 0;
    for (std::size_t i = 0; i < states_.size(); ++i) most = std::max(most, end(i) - first_[i]);
    const auto n = std::ssize(states_), g = batch_.navigation.steps.size(1);
    Ids rows(states_.size() * most, 0), last;
    batch_.shares = at::zeros({n, g, static_cast<std::int64_t>(most) * longest_});
    auto* const shares = batch_.shares.data_ptr<float>();
    for (std::size_t i = 0; i < states_.size(); ++i) {
      for (std::size_t s = first_[i]; s < end(i); ++s) {
        rows[i * most + s - first_[i]] = static_cast<std::int64_t>(s);
      }
      last.push_back(static_cast<std::int64_t>(end(i)) - 1);
      for (std::size_t a = 0; a < nodes_[i].size(); ++a) {
        const std::size_t row = i * static_cast<std::size_t>(g) + a + 1;
        write_node(i, nodes_[i][a], shares + row * most * static_cast<std::size_t>(longest_));
      }
    }
    batch_.rows = tensor_of(rows);
    batch_.last = tensor_of(last);
  }

  // A visited node is the mean of what was seen there last, an open one that of its views.
  void write_node(std::size_t i, TopologicalMap::Node node, float* shares) const {
    const DuetEpisodeState& state = states_[i];
    const ViewpointIndex viewpoint = state.map.viewpoint(node);
    if (state.map.visited(node)) {
      std::size_t s = end(i) - 1;
      while (stands_[s].pose.viewpoint != viewpoint) --s;
      const RolloutRunner::SeenViewpoint& place = *stands_[s].place;
      const std::size_t tokens = place.panorama->token_views.size() + place.objects.size();
      std::fill_n(shares + (s - first_[i]) * static_cast<std::size_t>(longest_), tokens,
                  1 / static_cast<float>(tokens));
      return;
    }
    std::vector<float*> shown;
    for (std::size_t s = first_[i]; s < end(i); ++s) {
      const auto& candidates = stands_[s].place->panorama->candidates;
      const auto found = std::ranges::find(candidates, viewpoint, &sim::Candidate::viewpoint);
      if (found == candidates.end()) continue;
      shown.push_back(shares + (s - first_[i]) * static_cast<std::size_t>(longest_) +
                      (found - candidates.begin()));
    }
    for (float* const share : shown) *share = 1 / static_cast<float>(shown.size());
  }

  void write_labels() {
    Ids nodes, tokens, objects;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      nodes.push_back(next_[i] ? kNoLabel : 0);
      tokens.push_back(nodes.back());
      if (next_[i]) label(i, *next_[i], nodes.back(), tokens.back());
      objects.push_back(kNoLabel);
      const RolloutRunner::SeenViewpoint& place = *states_[i].place;
      const auto found =
          std::ranges::find(place.objects, episodes_[i].object, &features::ObjectView::id);
      if (episodes_[i].object.empty() || found == place.objects.end()) continue;
      objects.back() =
          1 + std::ssize(place.panorama->token_views) + (found - place.objects.begin());
    }
    batch_.node_labels = tensor_of(nodes);
    batch_.token_labels = tensor_of(tokens);
    batch_.object_labels = tensor_of(objects);
  }

  // A path that comes back to a viewpoint has no node to go to there: visited ones are closed.
  void label(std::size_t i, ViewpointIndex next, std::int64_t& node, std::int64_t& token) const {
    const DuetEpisodeState& state = states_[i];
    const TopologicalMap::Node goes_to = *state.map.find(next);
    if (!state.map.visited(goes_to)) {
      node = std::ranges::find(nodes_[i], goes_to) - nodes_[i].begin() + 1;
    }
    const auto& candidates = state.place->panorama->candidates;
    token =
        std::ranges::find(candidates, next, &sim::Candidate::viewpoint) - candidates.begin() + 1;
  }

  bool special(std::int64_t id) const {
    return id == words_.begin() || id == words_.end() || id == words_.pad() || id == words_.mask();
  }

  std::int64_t other_word(Rng& rng) const {
    std::int64_t id = words_.begin();
    while (special(id)) id = static_cast<std::int64_t>(rng.below(words_.size()));
    return id;
  }

  void mask_words() {
    if (!words_.mask())
      throw ArgumentError("the vocabulary has no mask, so no word can be guessed");
    const std::int64_t longest = batch_.ids.size(1);
    auto* const ids = batch_.ids.data_ptr<std::int64_t>();
    Ids places, words;
    for (std::int64_t i = 0; i < std::ssize(states_); ++i) {
      Ids can;
      for (std::int64_t k = 0; k < batch_.lengths[i].item<std::int64_t>(); ++k) {
        if (!special(ids[i * longest + k])) can.push_back(i * longest + k);
      }
      for (const std::int64_t place : drawn(can, draws_.words, i)) {
        places.push_back(place);
        words.push_back(ids[place]);
        Rng& rng = random_[static_cast<std::size_t>(i)];
        const double kind = rng.uniform();
        if (kind < 0.8) {
          ids[place] = *words_.mask();
        } else if (kind < 0.9) {
          ids[place] = other_word(rng);
        }
      }
    }
    batch_.masked = tensor_of(places);
    batch_.words = tensor_of(words);
  }

  // A random share, but one at least.
  Ids drawn(const Ids& all, double share, std::int64_t i) {
    Rng& rng = random_[static_cast<std::size_t>(i)];
    Ids some;
    for (const std::int64_t one : all) {
      if (rng.uniform() < share) some.push_back(one);
    }
    if (some.empty() && !all.empty()) some.push_back(all[rng.below(all.size())]);
    return some;
  }

  void mask_views() {
    const std::int64_t most = batch_.panoramas.views.size(1), columns = config_.image;
    auto* const views = batch_.panoramas.views.data_ptr<float>();
    Ids places, shown, all;
    for (std::int64_t view = 0; view < 36; ++view) all.push_back(view);
    std::vector<float> numbers;
    for (std::int64_t i = 0; i < std::ssize(states_); ++i) {
      const std::size_t row = end(static_cast<std::size_t>(i)) - 1;
      const Ids which = drawn(all, draws_.views, i);
      const auto& tokens = stands_[row].place->panorama->token_views;
      const auto viewpoint = static_cast<std::int64_t>(
          (std::uint64_t{episodes_[static_cast<std::size_t>(i)].scan.value} << 32U) +
          stands_[row].pose.viewpoint.value);
      for (std::int64_t j = 0; j < std::ssize(tokens); ++j) {
        // Neighbours may share a view, which is then there several times.
        const auto view = static_cast<std::int64_t>(tokens[static_cast<std::size_t>(j)]);
        if (std::ranges::find(which, view) == which.end()) continue;
        float* const feature = views + (static_cast<std::int64_t>(row) * most + j) * columns;
        numbers.insert(numbers.end(), feature, feature + columns);
        std::fill_n(feature, columns, 0.0F);
        places.push_back(i * (longest_ + 1) + 1 + j);
        shown.push_back(viewpoint * 64 + view);
      }
    }
    batch_.masked = tensor_of(places);
    batch_.shown = tensor_of(shown);
    batch_.views = at::tensor(numbers).view({-1, columns});
  }

  RolloutRunner& runner_;
  const DuetConfig& config_;
  const models::InstructionWords& words_;
  std::span<const RolloutEpisode> episodes_;
  PretrainingDraws draws_;
  PretrainingBatch batch_;
  std::vector<Rng> random_;               // by episode
  std::vector<DuetEpisodeState> states_;  // likewise
  std::vector<std::vector<TopologicalMap::Node>> nodes_;
  std::vector<std::optional<ViewpointIndex>> next_;  // of its path; none at its end
  std::vector<std::size_t> first_;                   // its first stand
  std::vector<Stand> stands_;
  std::int64_t longest_ = 0;  // tokens of a panorama
};

// The mean over rows with a label.
at::Tensor labelled(const at::Tensor& logits, const at::Tensor& labels) {
  if (!labels.ne(kNoLabel).any().item<bool>()) return {};
  return at::cross_entropy_loss(logits, labels.to(logits.device()), {}, at::Reduction::Mean,
                                kNoLabel);
}

// Compares each prediction with the directions of all masked views' features.
at::Tensor contrast(const at::Tensor& guesses, const PretrainingBatch& batch) {
  const at::Tensor views = batch.views.to(guesses.device()), shown = batch.shown.to(views.device());
  const at::Tensor directions = views / views.norm(2, {1}, true).clamp_min(kLeastNorm);
  const at::Tensor scores = at::mm(guesses, directions.t());
  const std::int64_t k = scores.size(0);
  const at::Tensor same = shown.unsqueeze(0).eq(shown.unsqueeze(1));
  const at::Tensor others = same.logical_and(at::eye(k, same.options()).logical_not());
  return at::cross_entropy_loss(
      scores.masked_fill(others, -std::numeric_limits<double>::infinity()),
      at::arange(k, shown.options()));
}

constexpr const char* kBranches[] = {"local_encoder", "global_encoder"};

// Published code saves its pretraining's language layers below "bert.", not "vln_bert.".
std::string language_layer(std::string_view branch, std::int64_t i) {
  return fmt::format("bert.{}.encoder.x_layers.{}", branch, i);
}

bool no_head(std::string_view name) {
  return !name.starts_with("bert.") && !name.starts_with("mlm_head.") &&
         !name.starts_with("image_classifier.");
}

core::Weights heads_of(const DuetConfig& config, const features::TensorFile& file,
                       std::uint64_t seed) {
  const std::vector<core::ArraySpec> specs = pretraining_arrays_of(config);
  const bool any = std::ranges::any_of(
      specs, [&](const core::ArraySpec& spec) { return file.find(spec.name) != nullptr; });
  if (!any) return random_weights(specs, Rng(seed, 1));
  return core::read_weights(file, specs, no_head);
}

core::Weights together(const DuetNetwork& network, core::Weights heads) {
  core::make_trainable(heads, network.device());
  heads.insert(network.weights().begin(), network.weights().end());
  return heads;
}

at::Tensor rows_of(const at::Tensor& values, const at::Tensor& which) {
  return values.reshape({-1, values.size(2)}).index_select(0, which.to(values.device()));
}

}  // namespace

std::vector<PretrainingTask> pretraining_tasks(const DuetConfig& config,
                                               const models::Inputs& inputs) {
  std::vector<PretrainingTask> tasks;
  if (inputs.language) tasks.push_back(PretrainingTask::kWords);
  if (inputs.vision && config.image > 0) tasks.push_back(PretrainingTask::kViews);
  tasks.push_back(PretrainingTask::kAction);
  if (config.object > 0) tasks.push_back(PretrainingTask::kObject);
  return tasks;
}

PretrainingBatch pretraining_batch(RolloutRunner& runner, const DuetConfig& config,
                                   const models::InstructionWords& words,
                                   std::span<const RolloutEpisode> episodes, PretrainingTask task,
                                   const PretrainingDraws& draws) {
  return Builder(runner, config, words, episodes, task, draws).build();
}

NavigationInput navigation_of(const DuetNetwork& network, const PretrainingBatch& batch,
                              RateDropout* dropout) {
  const c10::Device device = network.device();
  PanoramaInput panoramas = batch.panoramas.on(device);
  if (dropout != nullptr) {
    const double rate = network.config().feature_dropout;
    panoramas.views = (*dropout)(panoramas.views, rate);
    if (panoramas.objects.defined()) panoramas.objects = (*dropout)(panoramas.objects, rate);
  }
  const Tokens seen = network.encode_panorama(panoramas, dropout);
  const std::int64_t n = batch.last.size(0), hidden = network.config().hidden;
  const at::Tensor rows = batch.rows.to(device), last = batch.last.to(device);
  NavigationInput input = batch.navigation.on(device);
  input.nodes = at::bmm(batch.shares.to(device),
                        seen.values.index_select(0, rows).view({n, batch.shares.size(2), hidden}));
  input.tokens = at::cat(
      {at::zeros({n, 1, hidden}, seen.values.options()), seen.values.index_select(0, last)}, 1);
  input.token_mask =
      at::cat({at::ones({n, 1}, seen.mask.options()), seen.mask.index_select(0, last)}, 1);
  return input;
}

at::Tensor pretraining_loss(const PretrainingNetwork& network, const PretrainingBatch& batch,
                            RateDropout* dropout) {
  const bool masks = batch.masked.defined();
  if (masks && batch.masked.numel() == 0) return {};
  const DuetNetwork& agent = network.agent();
  const Tokens text = agent.encode_text(batch.ids, batch.lengths, dropout);
  const NavigationInput input = navigation_of(agent, batch, dropout);
  if (batch.task == PretrainingTask::kWords) {
    return at::cross_entropy_loss(network.guess_words(text, input, batch.masked, dropout),
                                  batch.words.to(agent.device()));
  }
  const NavigationOutput output = agent.navigate(text, input, dropout);
  if (batch.task == PretrainingTask::kViews) {
    return contrast(network.guess_views(output, batch.masked), batch);
  }
  if (batch.task == PretrainingTask::kObject) {
    return labelled(output.object_logits, batch.object_labels);
  }
  at::Tensor loss = labelled(output.local_logits, batch.token_labels);
  for (const at::Tensor& logits : {output.global_logits, output.fused_logits}) {
    const at::Tensor part = labelled(logits, batch.node_labels);
    if (part.defined()) loss = loss + part;
  }
  return loss;
}

std::vector<core::ArraySpec> pretraining_arrays_of(const DuetConfig& config) {
  const std::int64_t hidden = config.hidden;
  std::vector<core::ArraySpec> specs;
  for (const char* branch : kBranches) {
    for (std::int64_t i = 0; i < config.cross_layers; ++i) {
      const std::string layer = language_layer(branch, i);
      for (const char* part : {".self.query", ".self.key", ".self.value", ".output.dense"}) {
        core::add_layer(specs, layer + ".lang_self_att" + part, {hidden, hidden});
      }
      core::add_layer(specs, layer + ".lang_self_att.output.LayerNorm", {hidden});
      core::add_layer(specs, layer + ".lang_inter.dense", {config.feed_forward, hidden});
      core::add_layer(specs, layer + ".lang_output.dense", {hidden, config.feed_forward});
      core::add_layer(specs, layer + ".lang_output.LayerNorm", {hidden});
    }
  }
  const std::string words = "mlm_head.predictions";
  core::add_layer(specs, words + ".transform.dense", {hidden, hidden});
  core::add_layer(specs, words + ".transform.LayerNorm", {hidden});
  specs.push_back({words + ".bias", {config.vocabulary}});
  if (config.image > 0) {
    core::add_layer(specs, "image_classifier.net.0", {hidden, hidden});
    core::add_layer(specs, "image_classifier.net.2", {hidden});
    core::add_layer(specs, "image_classifier.net.3", {config.image, hidden});
  }
  return specs;
}

PretrainingNetwork::PretrainingNetwork(const DuetConfig& config, std::uint64_t seed,
                                       c10::Device device)
    : agent_(config, seed, device),
      weights_(together(agent_, random_weights(pretraining_arrays_of(config), Rng(seed, 1)))) {}

PretrainingNetwork::PretrainingNetwork(const DuetConfig& config, const features::TensorFile& file,
                                       std::uint64_t seed, c10::Device device)
    : agent_(config, file, device), weights_(together(agent_, heads_of(config, file, seed))) {}

at::Tensor PretrainingNetwork::text_side(const Layers& layers, const Tokens& text,
                                         const at::Tensor& vision, const at::Tensor& mask,
                                         const char* branch) const {
  const at::Tensor words = bias_of(text.mask, kSoftMask), seen = bias_of(mask, kSoftMask);
  at::Tensor x = text.values;
  for (std::int64_t i = 0; i < config().cross_layers; ++i) {
    // The same weights that take vision to the text.
    const std::string cross =
        fmt::format("vln_bert.{}.encoder.x_layers.{}.visual_attention", branch, i);
    const std::string own = language_layer(branch, i);
    x = layers.attention(x, vision, seen, cross + ".att", cross + ".output");
    x = layers.attention(x, x, words, own + ".lang_self_att.self", own + ".lang_self_att.output");
    x = layers.feed_forward(x, own + ".lang_inter", own + ".lang_output");
  }
  return x;
}

at::Tensor PretrainingNetwork::guess_words(const Tokens& text, const NavigationInput& input,
                                           const at::Tensor& masked, RateDropout* dropout) const {
  const Layers layers(weights_, config().heads, dropout);
  const at::Tensor both =
      text_side(layers, text, agent_.embed_nodes(input), input.node_mask, "global_encoder") +
      text_side(layers, text, agent_.embed_tokens(input), input.token_mask, "local_encoder");
  const std::string head = "mlm_head.predictions";
  const at::Tensor inner =
      core::gelu(layers.linear(rows_of(both, masked), head + ".transform.dense"));
  return at::linear(layers.norm(inner, head + ".transform.LayerNorm"),
                    layers.weight("vln_bert.embeddings.word_embeddings.weight"),
                    layers.weight(head + ".bias"));
}

at::Tensor PretrainingNetwork::guess_views(const NavigationOutput& output,
                                           const at::Tensor& masked) const {
  EN_CHECK(config().image > 0);
  const Layers layers(weights_, config().heads, nullptr);
  const std::string head = "image_classifier.net";
  const at::Tensor inner = core::gelu(layers.linear(rows_of(output.tokens, masked), head + ".0"));
  return layers.linear(layers.norm(inner, head + ".2"), head + ".3");
}

}  // namespace enfilade::neural::duet
