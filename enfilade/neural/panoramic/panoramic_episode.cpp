#include "enfilade/neural/panoramic/panoramic_episode.h"

#include <ATen/ATen.h>
#include <algorithm>
#include <tuple>
#include <utility>

#include "enfilade/agents/experts.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::neural::panoramic {
namespace {

constexpr std::uint32_t kViews = 36;

// [sin h, cos h, sin e, cos e], repeated.
void write_angle(Radians heading, Radians elevation, std::span<float> out) {
  const agents::AngleFeature numbers = agents::angle_feature(heading, elevation);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = numbers[i % numbers.size()];
}

std::span<float> row_of(const at::Tensor& tensor, std::size_t row, std::size_t width) {
  return {tensor.data_ptr<float>() + row * width, width};
}

}  // namespace

PanoramicEpisode::PanoramicEpisode(agents::PanoramaCache& panoramas, const graph::GraphSet& graphs,
                                   const EpisodeStart& start)
    : panoramas_(&panoramas),
      graphs_(&graphs),
      location_(start.location),
      view_(agents::level_view(start.heading)),
      goal_(start.goal) {
  arrive();
}

Radians PanoramicEpisode::heading() const noexcept { return agents::view_heading(view_); }
Radians PanoramicEpisode::elevation() const noexcept { return agents::view_elevation(view_); }

void PanoramicEpisode::add_point() {
  points_.push_back({location_.viewpoint, heading(), elevation()});
}

void PanoramicEpisode::arrive() {
  candidates_ = &panoramas_->at(location_).candidates;
  add_point();
}

double PanoramicEpisode::distance() const {
  EN_CHECK(goal_.has_value());
  return graphs_->graph(location_.scan).distance(location_.viewpoint, *goal_);
}

std::size_t PanoramicEpisode::teacher() const {
  EN_CHECK(goal_.has_value());
  const auto next =
      agents::next_on_shortest(graphs_->graph(location_.scan), location_.viewpoint, *goal_);
  if (!next || *next == location_.viewpoint) return stop();
  const auto chosen = std::ranges::find(*candidates_, *next, &sim::Candidate::viewpoint);
  return static_cast<std::size_t>(chosen - candidates_->begin());
}

void PanoramicEpisode::choose(std::size_t choice) {
  EN_CHECK(!ended_);
  EN_CHECK_LE(choice, stop());
  if (choice == stop()) {
    ended_ = true;
    return;
  }
  const sim::Candidate& chosen = (*candidates_)[choice];
  for (;;) {
    const sim::Action action = agents::step_towards(chosen, view_);
    if (action.index != 0) break;
    view_ = agents::view_after(action, view_);
    add_point();
  }
  location_.viewpoint = chosen.viewpoint;
  arrive();
}

ImageSource pictures_of(const core::ViewFeatures* features) {
  return [features](graph::Location location, std::uint32_t view, std::span<float> out) {
    if (features != nullptr) features->copy(location.scan, location.viewpoint, view, out);
  };
}

StepInput look(std::span<const PanoramicEpisode> walks, const PanoramicConfig& config,
               const ImageSource& images) {
  std::size_t most = 0;
  for (const PanoramicEpisode& walk : walks) most = std::max(most, walk.stop() + 1);
  const auto n = static_cast<std::int64_t>(walks.size());
  const auto slots = static_cast<std::int64_t>(most);
  const std::size_t width = config.feature();
  const auto wide = static_cast<std::int64_t>(width);
  StepInput input;
  input.action = at::empty({n, static_cast<std::int64_t>(config.angle)}, at::kFloat);
  input.views = at::empty({n, kViews, wide}, at::kFloat);
  input.candidates = at::zeros({n, slots, wide}, at::kFloat);
  input.closed = at::zeros({n, slots}, at::kBool);
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const PanoramicEpisode& walk = walks[i];
    const Radians base = walk.heading();
    write_angle(base, walk.elevation(), row_of(input.action, i, config.angle));
    for (std::uint32_t view = 0; view < kViews; ++view) {
      const auto out = row_of(input.views, i * kViews + view, width);
      images(walk.location(), view, out.first(config.image));
      write_angle(agents::view_heading(view) - base, agents::view_elevation(view),
                  out.subspan(config.image));
    }
    for (std::size_t k = 0; k < walk.stop(); ++k) {
      const sim::Candidate& candidate = walk.candidates()[k];
      const auto out = row_of(input.candidates, i * most + k, width);
      const auto picture = row_of(input.views, i * kViews + candidate.view, width);
      std::ranges::copy(picture.first(config.image), out.begin());
      write_angle(candidate.heading - base, candidate.elevation, out.subspan(config.image));
    }
    bool* const closed = input.closed.data_ptr<bool>() + i * most;
    std::fill(closed + walk.stop() + 1, closed + most, true);
  }
  return input;
}

namespace {

// The four numbers again and again, as write_angle() has them.
at::Tensor repeated(const at::Tensor& angles, std::int64_t columns) {
  const std::int64_t four = angles.size(2);
  return angles.repeat({1, 1, (columns + four - 1) / four}).narrow(2, 0, columns);
}

}  // namespace

StepInput look(std::span<const PanoramicEpisode> walks, const PanoramicConfig& config,
               core::ResidentViews& images) {
  PanoramicConfig blind = config;
  blind.image = 0;
  blind.angle = std::tuple_size_v<agents::AngleFeature>;
  const StepInput seen =
      look(walks, blind, ImageSource([](graph::Location, std::uint32_t, std::span<float>) {}));
  const std::int64_t n = seen.views.size(0), most = seen.candidates.size(1);
  std::vector<std::int64_t> rows;  // of the views, then of the candidates
  for (const PanoramicEpisode& walk : walks) {
    const std::int64_t first = images.first_row(walk.location());
    for (std::uint32_t view = 0; view < kViews; ++view) rows.push_back(first + view);
  }
  for (const PanoramicEpisode& walk : walks) {
    const std::int64_t first = images.first_row(walk.location());
    for (std::int64_t k = 0; k < most; ++k) {
      const auto at = static_cast<std::size_t>(k);
      rows.push_back(at < walk.stop() ? first + walk.candidates()[at].view
                                      : core::ResidentViews::kNothing);
    }
  }
  const at::Tensor pictures = images.gather(rows);
  const c10::Device device = pictures.device();
  const auto angle = static_cast<std::int64_t>(config.angle);
  const auto together = [&](const at::Tensor& part, const at::Tensor& angles) {
    return at::cat(
        {part.view({n, angles.size(1), part.size(1)}), repeated(angles.to(device), angle)}, 2);
  };
  StepInput input;
  input.action = repeated(seen.action.unsqueeze(1), angle).squeeze(1).to(device);
  input.views = together(pictures.narrow(0, 0, n * kViews), seen.views);
  input.candidates = together(pictures.narrow(0, n * kViews, n * most), seen.candidates);
  input.closed = seen.closed.to(device);
  return input;
}

}  // namespace enfilade::neural::panoramic
