#include "enfilade/neural/duet/rollout.h"

#include <ATen/ATen.h>
#include <ATen/core/Reduction.h>
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/duet/episode_state.h"

namespace enfilade::neural::duet {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostObjects = 20;
constexpr std::int64_t kViews = 36;

std::size_t first_of_the_greatest(std::span<const float> values) {
  return static_cast<std::size_t>(std::ranges::max_element(values) - values.begin());
}

std::span<const float> row_of(const at::Tensor& values, std::int64_t i) {
  return {values.data_ptr<float>() + i * values.size(1), static_cast<std::size_t>(values.size(1))};
}

at::Tensor on_cpu(const at::Tensor& values) {
  return values.detach().to(at::kCPU, at::kFloat).contiguous();
}

// Place + 1 of the neighbour with the least way there and on to the goal, in the whole graph; the
// first of equals. 0 on the goal, kNoLabel without a neighbour.
std::int64_t neighbour_label(const graph::NavGraph& graph, ViewpointIndex here, ViewpointIndex goal,
                             std::span<const ViewpointIndex> neighbours) {
  if (here == goal) return 0;
  std::int64_t best = kNoLabel;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    // In this order, as agents::map_expert(): the last bit decides between nodes of one way.
    const double way = graph.distance(neighbours[i], goal) + graph.distance(here, neighbours[i]);
    if (way < least) {
      least = way;
      best = static_cast<std::int64_t>(i) + 1;
    }
  }
  return best;
}

// The viewpoint after the reference's number `step`; `here` itself at its end.
ViewpointIndex next_on_reference(const graph::NavGraph& graph, ViewpointIndex here,
                                 std::size_t step, std::span<const ViewpointIndex> reference) {
  if (step >= reference.size() || reference[step] != here) {
    throw ArgumentError(
        fmt::format("the agent is at {:?} at step {}, which is not where the annotated path is",
                    graph.id(here), step));
  }
  return reference[step + 1 == reference.size() ? step : step + 1];
}

// One rollout.
class Run {
 public:
  Run(RolloutRunner& runner, const graph::GraphSet& graphs, const DuetNetwork& network,
      std::span<const RolloutEpisode> episodes, const DuetRolloutOptions& options,
      const StepWatcher& watcher)
      : runner_(runner),
        network_(network),
        config_(network.config()),
        options_(options),
        watcher_(watcher) {
    for (const RolloutEpisode& episode : episodes) {
      states_.push_back(
          std::make_unique<DuetEpisodeState>(episode, states_.size(), graphs.graph(episode.scan)));
      look(*states_.back(), 0);
    }
    if (options.dropout) {
      Rng rng(options.seed, options.stream, 1);
      dropout_.emplace(rng.next(), config_.dropout, network.device());
    }
    const auto [ids, lengths] = words_of(episodes, config_);
    text_ = network_.prepare(network_.encode_text(ids, lengths, dropout()));
  }

  Rollout run() {
    Rollout result;
    // A watcher is told of one step after the other.
    if (options_.feedback == RolloutFeedback::kTeacher && options_.expert == Expert::kReference &&
        !watcher_) {
      follow(result);
    } else {
      for (std::size_t t = 0; t < most_steps() && find_active(); ++t) {
        step(t, result);
        ++result.steps;
      }
    }
    for (const auto& state : states_) result.episodes.push_back(std::move(state->walk));
    result.environment_seconds = std::chrono::duration<double>(spent_).count();
    return result;
  }

 private:
  using Nodes = std::vector<TopologicalMap::Node>;

  std::size_t most_steps() const { return static_cast<std::size_t>(config_.max_actions); }

  bool find_active() {
    active_.clear();
    for (const auto& state : states_) {
      if (!state->ended) active_.push_back(state.get());
    }
    return !active_.empty();
  }

  RateDropout* dropout() { return dropout_ ? &*dropout_ : nullptr; }

  void look(DuetEpisodeState& state, std::size_t t) {
    state.look(runner_.place(config_, {state.episode->scan, state.pose.viewpoint}), t);
  }

  PreparedText text_of_active() const {
    if (active_.size() == states_.size()) return text_;
    std::vector<std::int64_t> which;
    for (const DuetEpisodeState* state : active_) {
      which.push_back(static_cast<std::int64_t>(state->number));
    }
    return text_.rows(at::tensor(which, at::kLong).to(network_.device()));
  }

  // What the active ones see where they stand.
  Tokens encode() {
    const Clock::time_point begin = Clock::now();
    const PanoramaInput input = seen();
    spent_ += Clock::now() - begin;
    return network_.encode_panorama(input, dropout());
  }

  // On the network's device.
  PanoramaInput seen() {
    const c10::Device device = network_.device();
    PanoramaInput input;
    if (device.is_cpu() || config_.image == 0) {
      input = panorama_of(active_, config_).on(device);
    } else {
      input = panorama_of(active_, config_, runner_.views_on(device, config_)).on(device);
    }
    if (dropout_) {
      input.views = (*dropout_)(input.views, config_.feature_dropout);
      if (input.objects.defined()) {
        input.objects = (*dropout_)(input.objects, config_.feature_dropout);
      }
    }
    return input;
  }

  static at::Tensor means_of(const Tokens& seen) {
    const at::Tensor mask = seen.mask.unsqueeze(2).to(at::kFloat);
    return (seen.values * mask).sum(1) / mask.sum(1);
  }

  Tokens see() {
    Tokens seen = encode();
    const std::int64_t n = std::ssize(active_), longest = seen.values.size(1);
    const std::int64_t before = pool_.defined() ? pool_.size(0) : 0;
    std::vector<at::Tensor> parts{means_of(seen),
                                  seen.values.reshape({n * longest, seen.values.size(2)})};
    if (pool_.defined()) parts.insert(parts.begin(), pool_);
    pool_ = at::cat(parts, 0);
    for (std::int64_t i = 0; i < n; ++i) {
      active_[static_cast<std::size_t>(i)]->embed(before + i, before + n + i * longest);
    }
    return seen;
  }

  static Nodes nodes_of(const DuetEpisodeState& state) {
    return {state.map.rows().begin(), state.map.rows().end()};
  }

  void step(std::size_t t, Rollout& result) {
    const Tokens seen = see();
    const Clock::time_point begin = Clock::now();
    std::vector<Nodes> nodes;
    for (const DuetEpisodeState* state : active_) nodes.push_back(nodes_of(*state));
    const NavigationInput input = navigation_of(active_, nodes, seen, pool_, config_);
    spent_ += Clock::now() - begin;
    const NavigationOutput output = network_.navigate(text_of_active(), input, dropout());
    std::vector<StepRow> rows(active_.size());
    for (std::size_t i = 0; i < active_.size(); ++i) begin_row(*active_[i], nodes[i], rows[i]);
    remember(output, rows);
    if (options_.expert) {
      const Clock::time_point labelling = Clock::now();
      for (std::size_t i = 0; i < active_.size(); ++i) label(*active_[i], t, rows[i]);
      spent_ += Clock::now() - labelling;
      add_loss(output, rows, result.loss);
    }
    choose(t, rows);
    const bool last = t + 1 == most_steps();
    for (std::size_t i = 0; i < active_.size(); ++i) decide(*active_[i], last, rows[i]);
    if (watcher_) watcher_({t, rows, &seen, &input, &output});
    const Clock::time_point moving = Clock::now();
    for (std::size_t i = 0; i < active_.size(); ++i) {
      move(*active_[i], t, rows[i]);
      // A stop that was drawn off the goal ends a training walk without the walk to the best.
      if (rows[i].ends) finish(*active_[i], rows[i]);
    }
    spent_ += Clock::now() - moving;
  }

  // The annotated path is known before the network is asked, so all steps are rows of one batch:
  // products of many rows, and an eighth of the operations to follow back. The pool has for each
  // stand the mean of its tokens and then these.
  void follow(Rollout& result) {
    const Clock::time_point begin = Clock::now();
    const std::int64_t stride = longest_panorama() + 1;
    std::vector<std::unique_ptr<DuetEpisodeState>> stands;  // the states as they were at each step
    std::vector<Nodes> nodes;
    std::vector<StepRow> rows;
    for (std::size_t t = 0; t < most_steps() && find_active(); ++t) {
      for (DuetEpisodeState* state : active_) {
        state->embed(std::ssize(stands) * stride, std::ssize(stands) * stride + 1);
        const DuetEpisodeState& stand =
            *stands.emplace_back(std::make_unique<DuetEpisodeState>(*state));
        nodes.push_back(nodes_of(stand));
        StepRow& row = rows.emplace_back();
        begin_row(stand, nodes.back(), row);
        label(stand, t, row);
        row.choice = row.label;
        decide(stand, t + 1 == most_steps(), row);
        move(*state, t, row);
      }
      ++result.steps;
    }
    active_.clear();
    for (const auto& stand : stands) active_.push_back(stand.get());
    spent_ += Clock::now() - begin;
    const Tokens seen = encode();
    const std::int64_t missing = stride - 1 - seen.values.size(1);
    pool_ = at::constant_pad_nd(at::cat({means_of(seen).unsqueeze(1), seen.values}, 1),
                                {0, 0, 0, missing})
                .reshape({std::ssize(active_) * stride, seen.values.size(2)});
    const Clock::time_point writing = Clock::now();
    const NavigationInput input = navigation_of(active_, nodes, seen, pool_, config_);
    spent_ += Clock::now() - writing;
    const NavigationOutput output = network_.navigate(text_of_active(), input, dropout());
    remember(output, rows);
    add_loss(output, rows, result.loss);
    for (const StepRow& row : rows) {
      if (row.ends) finish(*states_[row.episode], row);
    }
  }

  // Tokens of the longest panorama on the annotated paths.
  std::int64_t longest_panorama() {
    std::size_t longest = 0;
    for (const auto& state : states_) {
      for (const ViewpointIndex viewpoint : state->episode->reference) {
        const RolloutRunner::SeenViewpoint& place =
            runner_.place(config_, {state->episode->scan, viewpoint});
        longest = std::max(longest, place.panorama->token_views.size() + place.objects.size());
      }
    }
    return static_cast<std::int64_t>(longest);
  }

  static void begin_row(const DuetEpisodeState& state,
                        const std::vector<TopologicalMap::Node>& nodes, StepRow& row) {
    row.episode = state.number;
    row.pose = state.pose;
    row.map = &state.map;
    row.nodes = nodes;
    row.candidates = state.place->panorama->candidates;
    row.views = state.place->panorama->token_views.size();
    row.objects = state.place->objects;
  }

  // The probability of stopping here, and the best object.
  void remember(const NavigationOutput& output, const std::vector<StepRow>& rows) {
    logits_ = on_cpu(output.fused_logits);
    probabilities_ = at::softmax(logits_, 1).contiguous();
    at::Tensor objects;
    if (output.object_logits.defined()) objects = on_cpu(output.object_logits);
    for (std::size_t i = 0; i < active_.size(); ++i) {
      const auto r = static_cast<std::int64_t>(i);
      std::string best;
      if (objects.defined() && !rows[i].objects.empty()) {
        const auto own = row_of(objects, r).subspan(rows[i].views + 1, rows[i].objects.size());
        best = rows[i].objects[first_of_the_greatest(own)].id;
      }
      states_[rows[i].episode]->remember(rows[i].pose.viewpoint, row_of(probabilities_, r)[0],
                                         std::move(best));
    }
  }

  static std::int64_t expert_label(const DuetEpisodeState& state, agents::ExpertRule rule) {
    const std::vector<ViewpointIndex> walked = state.walked();
    const auto goes_to =
        agents::map_expert({*state.graph, state.map, walked, state.episode->reference}, rule);
    return goes_to ? row_of_viewpoint(state, *goes_to) : kNoLabel;
  }

  // 0 for the one where the agent stands.
  static std::int64_t row_of_viewpoint(const DuetEpisodeState& state, ViewpointIndex viewpoint) {
    if (viewpoint == state.pose.viewpoint) return 0;
    const auto node = state.map.find(viewpoint);
    if (!node) {
      throw ArgumentError(fmt::format("episode {}: the annotated path goes to {:?}, not yet seen",
                                      state.episode->id, state.graph->id(viewpoint)));
    }
    const auto rows = state.map.rows();
    return std::ranges::find(rows, *node) - rows.begin() + 1;
  }

  void label(const DuetEpisodeState& state, std::size_t t, StepRow& row) const {
    std::vector<ViewpointIndex> neighbours;
    const std::span<const ViewpointIndex> reference = state.episode->reference;
    if (*options_.expert == Expert::kReference) {
      row.label = row_of_viewpoint(
          state, next_on_reference(*state.graph, state.pose.viewpoint, t, reference));
    } else {
      row.label = expert_label(state, *options_.expert == Expert::kSpl ? agents::ExpertRule::kSpl
                                                                       : agents::ExpertRule::kNdtw);
    }
    for (const sim::Candidate& candidate : row.candidates) {
      neighbours.push_back(candidate.viewpoint);
    }
    row.local_label =
        neighbour_label(*state.graph, state.pose.viewpoint, reference.back(), neighbours);
    for (std::size_t k = 0; k < row.objects.size(); ++k) {
      if (row.objects[k].id != state.episode->object) continue;
      row.object_label = static_cast<std::int64_t>(1 + row.views + k);
      break;
    }
  }

  static void add(const at::Tensor& logits, const std::vector<StepRow>& rows,
                  std::int64_t StepRow::*label, at::Tensor& loss) {
    std::vector<std::int64_t> labels, which;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].*label == kNoLabel) continue;
      which.push_back(static_cast<std::int64_t>(i));
      labels.push_back(rows[i].*label);
    }
    if (labels.empty()) return;
    const c10::Device device = logits.device();
    const at::Tensor part =
        at::cross_entropy_loss(logits.index_select(0, at::tensor(which, at::kLong).to(device)),
                               at::tensor(labels, at::kLong).to(device), {}, at::Reduction::Sum);
    loss = loss.defined() ? loss + part : part;
  }

  void add_loss(const NavigationOutput& output, const std::vector<StepRow>& rows,
                at::Tensor& loss) const {
    add(output.fused_logits, rows, &StepRow::label, loss);
    if (options_.three_losses) {
      add(output.global_logits, rows, &StepRow::label, loss);
      add(output.local_logits, rows, &StepRow::local_label, loss);
    }
    if (output.object_logits.defined()) {
      add(output.object_logits, rows, &StepRow::object_label, loss);
    }
  }

  void choose(std::size_t t, std::vector<StepRow>& rows) const {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto r = static_cast<std::int64_t>(i);
      const DuetEpisodeState& state = *active_[i];
      const auto best = static_cast<std::int64_t>(first_of_the_greatest(row_of(logits_, r)));
      Rng rng(options_.seed, options_.stream,
              stream_of(state.episode->id.data(), state.episode->id.size()) + 2 * t);
      rows[i].choice = best;
      if (options_.feedback == RolloutFeedback::kTeacher) {
        rows[i].choice = rows[i].label;
      } else if (options_.feedback == RolloutFeedback::kSample && !options_.draw_best) {
        rows[i].choice = drawn(row_of(probabilities_, r), rng.uniform());
      } else if (options_.feedback == RolloutFeedback::kExplore &&
                 rng.uniform() < options_.explore) {
        const std::uint64_t row = rng.below(state.map.open() + 1);  // open nodes come last
        rows[i].choice =
            row == 0 ? 0 : static_cast<std::int64_t>(rows[i].nodes.size() - state.map.open() + row);
      }
    }
  }

  static std::int64_t drawn(std::span<const float> shares, double at) {
    double sum = 0;
    std::int64_t last = 0;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      if (shares[i] <= 0) continue;
      last = static_cast<std::int64_t>(i);
      sum += double{shares[i]};
      if (at < sum) break;
    }
    return last;
  }

  // Where it goes, and whether it ends here.
  void decide(const DuetEpisodeState& state, bool last, StepRow& row) const {
    const bool training = options_.feedback == RolloutFeedback::kTeacher ||
                          options_.feedback == RolloutFeedback::kSample;
    const bool on_goal = !state.episode->reference.empty() &&
                         state.pose.viewpoint == state.episode->reference.back();
    const bool stops = training ? on_goal : row.choice == 0;
    if (stops || last || state.map.open() == 0) {
      row.ends = true;
    } else if (row.choice > 0) {
      row.goes_to = state.map.viewpoint(row.nodes[static_cast<std::size_t>(row.choice - 1)]);
    }
  }

  void finish(DuetEpisodeState& state, const StepRow& row) const {
    const bool own = row.choice == 0 && config_.stays_where_it_stops;
    state.finish(own ? agents::FinalStop::kUnlessOwn : agents::FinalStop::kAlways);
  }

  void move(DuetEpisodeState& state, std::size_t t, const StepRow& row) {
    if (!row.goes_to) {
      state.ended = true;
      return;
    }
    state.go(*state.map.find(*row.goes_to), runner_, config_);
    look(state, t + 1);
  }

  RolloutRunner& runner_;
  const DuetNetwork& network_;
  const DuetConfig& config_;
  const DuetRolloutOptions& options_;
  const StepWatcher& watcher_;
  std::vector<std::unique_ptr<DuetEpisodeState>> states_;
  std::vector<DuetEpisodeState*> active_;
  std::optional<RateDropout> dropout_;
  PreparedText text_;
  at::Tensor pool_;                    // all means and tokens of panoramas so far: (rows, hidden)
  at::Tensor logits_, probabilities_;  // of the last step, on the CPU
  Clock::duration spent_{};
};

}  // namespace

RolloutRunner::RolloutRunner(std::shared_ptr<const graph::GraphSet> graphs,
                             Surroundings& surroundings)
    : graphs_(std::move(graphs)), surroundings_(surroundings), panoramas_(graphs_) {}

const RolloutRunner::SeenViewpoint& RolloutRunner::place(const DuetConfig& config,
                                                         graph::Location location) {
  auto& known = places_[{location.scan.value, location.viewpoint.value}];
  if (known) return *known;
  auto place = std::make_unique<SeenViewpoint>();
  const graph::NavGraph& graph = graphs_->graph(location.scan);
  place->panorama = &panoramas_.at(location);
  const auto floats = [](const at::Tensor& values) {
    return std::span<float>(values.data_ptr<float>(), static_cast<std::size_t>(values.numel()));
  };
  place->views = at::zeros({kViews, config.image});
  surroundings_.views(graph, location.viewpoint, floats(place->views));
  if (config.object != 0) {
    place->objects = surroundings_.objects(graph, location.viewpoint);
    if (place->objects.size() > kMostObjects) place->objects.resize(kMostObjects);
    place->object_features = at::zeros({std::ssize(place->objects), config.object});
    const auto columns = static_cast<std::size_t>(config.object);
    for (std::size_t i = 0; i < place->objects.size(); ++i) {
      surroundings_.object(graph, location.viewpoint, i,
                           floats(place->object_features).subspan(i * columns, columns));
    }
  }
  known = std::move(place);
  return *known;
}

core::ResidentViews& RolloutRunner::views_on(c10::Device device, const DuetConfig& config) {
  if (!resident_) {
    resident_.emplace(config.image, device, [this](graph::Location at, std::span<float> out) {
      surroundings_.views(graphs_->graph(at.scan), at.viewpoint, out);
    });
  }
  return *resident_;
}

Rollout RolloutRunner::run(const DuetNetwork& network, std::span<const RolloutEpisode> episodes,
                           const DuetRolloutOptions& options, const StepWatcher& watcher) {
  return Run(*this, *graphs_, network, episodes, options, watcher).run();
}

}  // namespace enfilade::neural::duet
