#include "enfilade/neural/continuous/gatherer.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <algorithm>
#include <map>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"

namespace enfilade::neural::continuous {

using enfilade::continuous::Action;

namespace {

// A choice by probabilities, or the likeliest.
std::int64_t choose(const float* probabilities, bool drawn, Rng& rng) {
  const double at = drawn ? rng.uniform() : 0;
  double sum = 0;
  std::int64_t best = 0;
  for (std::int64_t c = 0; c < kChoices; ++c) {
    sum += static_cast<double>(probabilities[c]);
    if (drawn && at < sum) return c;
    if (probabilities[c] > probabilities[best]) best = c;
  }
  return best;  // not drawn, or the rest that rounding leaves
}

// The part of one row.
template <class T>
void append_row(std::vector<T>& all, const std::vector<T>& rows, std::size_t row, std::size_t n) {
  const std::size_t width = rows.size() / n;
  const auto first = rows.begin() + static_cast<std::ptrdiff_t>(row * width);
  all.insert(all.end(), first, first + static_cast<std::ptrdiff_t>(width));
}

constexpr std::size_t kMostKnown = 4;  // buildings that are not looked at now; some 50 MB each
constexpr std::uint32_t kDepthPixels = 64;
constexpr std::size_t kCell = kDepthPixels / static_cast<std::size_t>(kDepthCells);
constexpr float kFarthest = 10;  // metres, as VLN-CE's depth

Camera camera_of(const ImageEncoder& encoder, const std::string& name) {
  return name.starts_with("resnet") ? Camera{224, 224, degrees(90)} : encoder.camera();
}

// The mean of each cell. \param pixels (kDepthPixels, kDepthPixels) metres, 0: no surface
void average(std::span<const float> pixels, std::span<std::uint8_t> cells) {
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const std::size_t row = cell / kDepthCells * kCell, column = cell % kDepthCells * kCell;
    float sum = 0;
    for (std::size_t y = row; y < row + kCell; ++y) {
      for (std::size_t x = column; x < column + kCell; ++x) {
        const float metres = pixels[y * kDepthPixels + x];
        sum += metres == 0 ? kFarthest : std::min(metres, kFarthest);
      }
    }
    const float share = sum / (kFarthest * static_cast<float>(kCell * kCell));
    cells[cell] = static_cast<std::uint8_t>(share * 255 + 0.5F);
  }
}

}  // namespace

std::vector<std::size_t> walking(std::span<const agents::ContinuousObservation> batch) {
  std::vector<std::size_t> slots;
  for (std::size_t s = 0; s < batch.size(); ++s) {
    if (!batch[s].ended) slots.push_back(s);
  }
  return slots;
}

Gatherer::Gatherer(const GathererParts& parts, const Mixture& mixture,
                   const tasks::ContinuousEpisodes& episodes)
    : parts_(parts),
      mixture_(mixture),
      episodes_(episodes),
      teacher_(agents::make_patient_reference()),
      states_(*parts.network),
      walks_(episodes.episodes.size()) {}

void Gatherer::start(std::size_t slot, const agents::ContinuousObservation& seen,
                     const enfilade::continuous::SimulatorConfig& config) {
  teacher_->start(slot, seen, config);
  states_.start(slot, read_text(*parts_.words, seen.episode->instruction.text, *parts_.config));
  eye_height_ = config.eye_height;
}

void Gatherer::act(std::span<const agents::ContinuousObservation> batch,
                   std::span<Action> actions) {
  teacher_->act(batch, actions);
  const std::vector<std::size_t> slots = walking(batch);
  const SightRows seen =
      parts_.sight != nullptr ? parts_.sight->look(batch, slots, eye_height_) : SightRows{};
  const bool teacher_alone = mixture_.teacher_share >= 1;
  const at::Tensor probabilities = teacher_alone ? at::Tensor() : states_.step(slots, seen);
  for (std::size_t k = 0; k < slots.size(); ++k) {
    const std::size_t slot = slots[k];
    const agents::ContinuousObservation& own = batch[slot];
    const auto advice = static_cast<std::int64_t>(actions[slot]);
    std::int64_t choice = advice;
    if (!teacher_alone && own.rng->uniform() >= mixture_.teacher_share) {
      const bool last = own.step + 1 == mixture_.last_action;
      choice =
          last ? 0
               : choose(probabilities.data_ptr<float>() + static_cast<std::int64_t>(k) * kChoices,
                        mixture_.drawn, *own.rng);
    }
    RecordedEpisode& walk =
        walks_[static_cast<std::size_t>(own.episode - episodes_.episodes.data())];
    append_row(walk.seen.pictures, seen.pictures, k, slots.size());
    append_row(walk.seen.depth, seen.depth, k, slots.size());
    walk.previous.push_back(static_cast<std::uint8_t>(states_.previous(slot)));
    walk.teacher.push_back(static_cast<std::uint8_t>(advice));
    states_.tell(slot, choice);
    actions[slot] = static_cast<Action>(choice);
  }
}

std::vector<std::int64_t> read_text(const models::InstructionWords& words, std::string_view text,
                                    const models::NetworkConfig& config) {
  return words.encode(config.inputs.language ? text : std::string_view(), config.max_words);
}

at::Tensor picture_numbers(std::span<const std::uint16_t> halves, std::int64_t n,
                           const Sizes& sizes) {
  if (halves.empty()) return at::zeros({n, std::max<std::int64_t>(sizes.features, 1)}, at::kFloat);
  at::Tensor numbers = at::empty({n, sizes.features}, at::kFloat);
  const bool finite =
      copy_halves(reinterpret_cast<const std::byte*>(halves.data()),
                  {numbers.data_ptr<float>(), static_cast<std::size_t>(numbers.numel())});
  EN_CHECK(finite);
  return numbers;
}

at::Tensor depth_numbers(std::span<const std::uint8_t> bytes, std::int64_t n) {
  at::Tensor numbers = at::zeros({n, kDepthSize}, at::kFloat);
  std::ranges::transform(bytes, numbers.data_ptr<float>(),
                         [](std::uint8_t byte) { return static_cast<float>(byte) / 255; });
  return numbers;
}

void EpisodeStates::start(std::size_t slot, const std::vector<std::int64_t>& instruction) {
  const c10::NoGradGuard no_gradients;
  if (slot >= previous_.size()) {
    const auto more = static_cast<std::int64_t>(slot + 1 - previous_.size());
    const auto grow = [&](at::Tensor& rows, std::int64_t width) {
      const at::Tensor nothing =
          at::zeros({more, width}, at::TensorOptions(at::kFloat).device(network_.device()));
      rows = rows.defined() ? at::cat({rows, nothing}) : nothing;
    };
    grow(sentences_, static_cast<std::int64_t>(network_.sizes().own.sentence));
    grow(states_, static_cast<std::int64_t>(network_.sizes().own.hidden));
    previous_.resize(slot + 1);
  }
  const auto row = static_cast<std::int64_t>(slot);
  sentences_[row].copy_(network_.read(std::span(&instruction, 1))[0]);
  states_[row].zero_();
  previous_[slot] = kNoAction;
}

std::vector<std::int64_t> EpisodeStates::likeliest(std::span<const std::size_t> slots,
                                                   const SightRows& seen) {
  const at::Tensor best = step(slots, seen).argmax(1);
  const auto* const first = best.data_ptr<std::int64_t>();
  return {first, first + best.numel()};
}

at::Tensor EpisodeStates::step(std::span<const std::size_t> slots, const SightRows& seen) {
  const c10::NoGradGuard no_gradients;
  const std::int64_t n = std::ssize(slots);
  const at::Tensor rows = at::empty({n}, at::kLong), previous = at::empty({n}, at::kLong);
  for (std::int64_t r = 0; r < n; ++r) {
    const std::size_t slot = slots[static_cast<std::size_t>(r)];
    rows.data_ptr<std::int64_t>()[r] = static_cast<std::int64_t>(slot);
    previous.data_ptr<std::int64_t>()[r] = previous_[slot];
  }
  const StepRows steps{picture_numbers(seen.pictures, n, network_.sizes()),
                       depth_numbers(seen.depth, n),
                       previous,
                       {n}};
  const at::Tensor there = rows.to(network_.device());
  const at::Tensor states =
      network_.walk(sentences_.index_select(0, there), steps, states_.index_select(0, there));
  states_.index_copy_(0, there, states);
  return at::softmax(network_.score(states), 1).to(at::kCPU);
}

SightEncoder::SightEncoder(const ContinuousSight& config)
    : config_(config), scenes_(config.scene_of, config.threads) {
  if (!config_.scene_of) throw ArgumentError("scene_of: empty, but the agent is to see");
  encoder_ = make_encoder(config_.encoder);
  camera_ = camera_of(*encoder_, config_.encoder.name);
}

features::FeatureInfo SightEncoder::info() const {
  return {.encoder = config_.encoder.name,
          .preprocessing = encoder_->preprocessing(),
          .weights = encoder_->weights_hash(),
          .views = 1,
          .dimensions = encoder_->dimensions(),
          .camera = camera_,
          .type = features::DType::kFloat16};
}

void SightEncoder::draw(const std::string& scan,
                        std::span<const enfilade::continuous::MeshView> views,
                        std::span<float> pictures, std::span<float> depth) {
  enfilade::continuous::Eyes& eyes = scenes_.of(scan);
  render::Outputs colour;
  colour.colour = render::ColourOutput{render::ColourFormat::kPlanarFloat32,
                                       encoder_->normalisation(), std::as_writable_bytes(pictures)};
  eyes.render(camera_, views, colour);
  render::Outputs metres;
  metres.depth = render::DepthOutput{.pixels = std::as_writable_bytes(depth)};
  eyes.render(Camera{kDepthPixels, kDepthPixels, degrees(90)}, views, metres);
}

SightRows SightEncoder::look(std::span<const agents::ContinuousObservation> batch,
                             std::span<const std::size_t> rows, double eye_height) {
  std::map<std::string, std::vector<std::size_t>> by_scan;  // places among `rows`
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const agents::ContinuousObservation& seen = batch[rows[r]];
    by_scan[seen.buildings->scan(seen.building)].push_back(r);
  }
  // Those of this step stay, however many: the next step needs them again.
  scenes_.keep(kMostKnown, by_scan);
  const std::size_t pixels = std::size_t{camera_.width} * camera_.height * 3;
  constexpr std::size_t kDepth = std::size_t{kDepthPixels} * kDepthPixels;
  const std::span<float> pictures = encoder_->memory(rows.size(), camera_);
  std::vector<float> depth(rows.size() * kDepth);
  std::vector<std::size_t> order;
  for (const auto& [scan, places] : by_scan) {
    std::vector<enfilade::continuous::MeshView> views;
    for (const std::size_t r : places) {
      const enfilade::continuous::Pose& pose = batch[rows[r]].pose;
      const Vec3d feet = to_double(pose.position);
      views.push_back({0, {feet.x, feet.y, feet.z + eye_height}, pose.heading, pose.elevation});
    }
    draw(scan, views, pictures.subspan(order.size() * pixels, views.size() * pixels),
         std::span(depth).subspan(order.size() * kDepth, views.size() * kDepth));
    order.insert(order.end(), places.begin(), places.end());
  }
  const std::size_t width = encoder_->dimensions();
  std::vector<float> features(rows.size() * width);
  encoder_->encode(pictures, rows.size(), camera_, features);
  SightRows seen{std::vector<std::uint16_t>(features.size()),
                 std::vector<std::uint8_t>(rows.size() * kDepthSize)};
  for (std::size_t k = 0; k < order.size(); ++k) {
    std::ranges::transform(std::span(features).subspan(k * width, width),
                           seen.pictures.begin() + static_cast<std::ptrdiff_t>(order[k] * width),
                           to_half);
    average(std::span(depth).subspan(k * kDepth, kDepth),
            std::span(seen.depth).subspan(order[k] * kDepthSize, kDepthSize));
  }
  return seen;
}

}  // namespace enfilade::neural::continuous
