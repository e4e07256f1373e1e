#include "enfilade/homes/benchmarks/described_home.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "enfilade/homes/instructions/phrases.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::homes::benchmarks {
namespace {

constexpr std::array<const char*, 2> kLanguages{"en-IN", "en-US"};
constexpr double kPace = 1.2;  // metres a second

double rounded(double seconds) { return std::round(10 * seconds) / 10; }

// Says words one after another.
class Clock {
 public:
  explicit Clock(Rng& rng) : rng_(rng) {}

  void say(const std::string& text, std::vector<tasks::TimedWord>& words) {
    std::istringstream in(text);
    for (std::string word; in >> word;) {
      const double end =
          now_ + 0.12 + 0.05 * static_cast<double>(word.size()) + 0.1 * rng_.uniform();
      words.push_back({word, rounded(now_), rounded(end)});
      now_ = end + 0.1 * rng_.uniform();
      if (word.ends_with('.')) now_ += 0.4;
    }
  }
  void wait(double seconds) { now_ += seconds; }
  double now() const noexcept { return now_; }

 private:
  Rng& rng_;
  double now_ = 0.4;  // seconds since the recording began
};

// Where a guide stands and looks: always where the path goes on.
class Camera {
 public:
  Camera(const DescribedHome& site, std::span<const ViewpointIndex> path, double heading)
      : site_(site), path_(path) {
    add(0, 0, heading);
  }

  void stand(std::size_t place, double time) {
    const std::size_t from = std::min(place, path_.size() - 2);
    add(place, time, site_.heading(path_[from], path_[from + 1]));
  }
  tasks::PoseTrace take() { return std::move(trace_); }

 private:
  void add(std::size_t place, double time, double heading) {
    const ViewpointIndex v = path_[place];
    const tasks::CameraLook look{to_double(site_.graph().position(v)), Radians(heading), Radians(0),
                                 degrees(60), 4.0 / 3};
    trace_.snapshots.push_back(tasks::snapshot_of(site_.graph().id(v), time, look));
  }

  const DescribedHome& site_;
  std::span<const ViewpointIndex> path_;
  tasks::PoseTrace trace_;
};

tasks::PathAnnotation guide_of(const DescribedHome& site, const tasks::PathAnnotation& path,
                               std::span<const ViewpointIndex> viewpoints, std::size_t k, Rng& rng,
                               tasks::PoseTrace& trace) {
  tasks::PathAnnotation guide;
  guide.path_id = path.path_id;
  guide.id = fmt::to_string(path.path_id);
  guide.scan = path.scan;
  guide.heading = path.heading;
  guide.path = path.path;
  guide.group = path.path_id;
  tasks::InstructionDetails& details = guide.details.emplace_back();
  details.id = fmt::format("{}_{}", path.path_id, 10 * path.path_id + static_cast<long>(k) + 1);
  details.language = kLanguages.at(k);
  const instructions::Spoken spoken = instructions::describe(
      site.spoken(), viewpoints, path.heading.value, instructions::SpeakerKind::kGuide, rng.next());
  Clock clock(rng);
  std::string text;
  const auto room = site.room(viewpoints.front());
  if (room && !site.naming().is_stairs(*room)) {
    text = instructions::sentence(
        instructions::expand("[okay,|alright,|so,|now,|] you are [standing|] in the $room",
                             {{"room", site.naming().room(*room, rng)}}, rng));
    clock.say(text, details.words);
    text += " ";
  }
  Camera camera(site, viewpoints, path.heading.value);
  for (const instructions::SpokenPart& part : spoken.parts) {
    camera.stand(part.first, clock.now());
    clock.say(part.text, details.words);
    for (std::size_t place = part.first; place < part.last; ++place) {
      clock.wait(site.graph().distance(viewpoints[place], viewpoints[place + 1]) / kPace);
      camera.stand(place + 1, clock.now());
    }
  }
  trace = camera.take();
  guide.instructions = {text + spoken.text};
  return guide;
}

// What a follower walks.
std::vector<ViewpointIndex> walk_of(const DescribedHome& site, std::vector<ViewpointIndex> path,
                                    Rng& rng) {
  const std::uint64_t kind = rng.below(8);
  if (kind == 0 && path.size() > 2) path.pop_back();
  if (kind == 1) {  // into a wrong way, and back
    const std::size_t at = rng.below(path.size() - 1);
    const auto ways = site.graph().edges(path[at]);
    const ViewpointIndex wrong = ways[rng.below(ways.size())].target;
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(at) + 1, {wrong, path[at]});
  }
  return path;
}

tasks::Demonstration follow(const DescribedHome& site, const tasks::PathAnnotation& guide,
                            const std::vector<ViewpointIndex>& viewpoints, std::size_t k,
                            Rng& rng) {
  const std::vector<ViewpointIndex> walked = walk_of(site, viewpoints, rng);
  const tasks::EpisodeMetrics metrics = tasks::compute_metrics(site.graph(), walked, viewpoints);
  tasks::Demonstration demonstration;
  demonstration.instruction_id = 10 * guide.path_id + static_cast<std::int64_t>(k) + 1;
  demonstration.demonstration_id = demonstration.instruction_id;
  demonstration.annotator_id = 1 + static_cast<std::int64_t>(rng.below(40));
  demonstration.path = site.ids(walked);
  demonstration.ne = metrics.nav_error;
  demonstration.sr = metrics.success;
  demonstration.spl = metrics.spl;
  demonstration.dtw = metrics.dtw;
  demonstration.ndtw = metrics.ndtw;
  demonstration.sdtw = metrics.sdtw;
  return demonstration;
}

}  // namespace

GuidedPath write_guides(const DescribedHome& site, const tasks::PathAnnotation& path,
                        std::uint64_t seed) {
  Rng rng = rng_for(seed, path, "guides");
  GuidedPath result;
  const std::vector<ViewpointIndex> viewpoints = site.look_up(path.path);
  for (std::size_t k = 0; k < kLanguages.size(); ++k) {
    result.guides.push_back(guide_of(site, path, viewpoints, k, rng, result.traces.emplace_back()));
    result.walks.push_back(follow(site, result.guides.back(), viewpoints, k, rng));
  }
  return result;
}

}  // namespace enfilade::homes::benchmarks
