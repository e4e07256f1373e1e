#include "enfilade/homes/benchmarks/described_home.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <utility>

#include "enfilade/homes/instructions/phrases.h"

namespace enfilade::homes::benchmarks {
namespace {

constexpr std::size_t kShown = 5;  // steps that the oracle sees, as in CVDN
constexpr std::size_t kMostTurns = 6;

// The text of an instance, as the reader of CVDN's files makes it from the turns and the target.
std::string text_of(const std::vector<tasks::DialogueTurn>& turns, const std::string& target) {
  std::string text;
  for (const tasks::DialogueTurn& turn : turns) {
    text += fmt::format("{} {} ", turn.role == "navigator" ? "<NAV>" : "<ORA>", turn.message);
  }
  return text + "<TAR> " + target;
}

// One game of one navigator and one oracle.
class Game {
 public:
  Game(const DescribedHome& site, const tasks::PathAnnotation& path, std::uint64_t seed)
      : site_(site),
        path_(path),
        rng_(rng_for(seed, path, "dialogue")),
        at_(site.graph().find(path.path.front()).value()),
        heading_(path.heading.value) {}

  std::vector<tasks::PathAnnotation> play() {
    if (!choose_goal()) return {};
    while (instances_.size() < kMostTurns && !in_goal_room(at_)) {
      const std::vector<ViewpointIndex> shown = plan();
      if (shown.size() < 2) return {};  // out of reach
      if (!instances_.empty()) ask(shown);
      const std::vector<ViewpointIndex> walked = turns_.empty() ? stroll(shown) : follow(shown);
      record(shown, walked);
      heading_ = site_.heading(walked[walked.size() - 2], walked.back());
      at_ = walked.back();
      steps_ += static_cast<std::int64_t>(walked.size()) - 1;
    }
    return std::move(instances_);
  }

 private:
  bool in_goal_room(ViewpointIndex v) const {
    return std::ranges::count(site_.in_room(room_), v) > 0;
  }

  bool choose_goal() {
    const auto room = site_.room(site_.graph().find(path_.path.back()).value());
    if (!room) return false;
    room_ = *room;
    std::vector<std::size_t> things;
    for (const std::size_t thing : site_.things_in(std::vector{room_})) {
      if (instructions::weight_of(site_.home(), thing) >= 1) things.push_back(thing);
    }
    if (things.empty() || in_goal_room(at_) || site_.naming().is_stairs(room_)) return false;
    target_ = site_.home().things[things[rng_.below(things.size())]].noun;
    return true;
  }

  // The first steps of a shortest path to the nearest viewpoint of the room.
  std::vector<ViewpointIndex> plan() const {
    const graph::NavGraph& graph = site_.graph();
    double least = std::numeric_limits<double>::infinity();
    ViewpointIndex goal = at_;
    for (const ViewpointIndex v : site_.in_room(room_)) {
      if (graph.distance(at_, v) >= least) continue;
      least = graph.distance(at_, v);
      goal = v;
    }
    std::vector<ViewpointIndex> path = graph.path(at_, goal).value();
    path.resize(std::min(path.size(), kShown + 1));
    return path;
  }

  // What the navigator does before anybody has said anything: a step or two, perhaps a wrong one.
  std::vector<ViewpointIndex> stroll(const std::vector<ViewpointIndex>& shown) {
    const auto ways = site_.graph().edges(at_);
    if (rng_.below(3) == 0) return {at_, ways[rng_.below(ways.size())].target};
    const std::size_t moves = std::min<std::size_t>(1 + rng_.below(2), shown.size() - 1);
    return {shown.begin(), shown.begin() + static_cast<std::ptrdiff_t>(moves) + 1};
  }

  // One time out of four it stops early.
  std::vector<ViewpointIndex> follow(const std::vector<ViewpointIndex>& shown) {
    const bool early = shown.size() > 2 && rng_.below(4) == 0;
    return {shown.begin(), shown.end() - (early ? 1 : 0)};
  }

  std::string say(std::string_view pattern, const instructions::Slots& slots) {
    std::string text = instructions::expand(pattern, slots, rng_);
    text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
    return text;
  }

  // A question, and the answer that begins with "Yes." or "No." where it is one of those.
  void ask(const std::vector<ViewpointIndex>& shown) {
    std::string question, before;
    const double turn =
        std::remainder(site_.heading(at_, shown[1]) - heading_, 2 * kPi) * 180 / kPi;
    const auto here = site_.room(at_);
    const bool can_ask_side = std::abs(turn) > 40 && std::abs(turn) < 140;
    const std::uint64_t kind = rng_.below(3);
    if (kind == 0 && can_ask_side) {
      const bool right = rng_.below(2) == 0;
      question = say("[should I|do I|shall I] [go|turn] $side [here|now]?",
                     {{"side", right ? "right" : "left"}});
      before = right == (turn > 0) ? "Yes. " : "No. ";
    } else if (kind == 1) {
      question = ask_for_room(before);
    } else if (here && !site_.naming().is_stairs(*here)) {
      question = say("I am in the $room[ now|]. [Where do I go|Which way|Where to now]?",
                     {{"room", site_.naming().room(*here, rng_)}});
    } else {
      question = say("[where do I go|which way|where to now]?", {});
    }
    const auto speaker = rng_.below(2) == 0 ? instructions::SpeakerKind::kTerse
                                            : instructions::SpeakerKind::kLandmarks;
    std::string answer =
        before + instructions::describe(site_.spoken(), shown, heading_, speaker, rng_.next()).text;
    if (in_goal_room(shown.back())) answer += " " + say("the $thing is in there.", thing());
    turns_.push_back({"navigator", std::move(question), steps_});
    turns_.push_back({"oracle", std::move(answer), steps_});
  }
  instructions::Slots thing() const { return {{"thing", target_}}; }

  // "Is it in the kitchen?"
  std::string ask_for_room(std::string& before) {
    std::size_t room = room_;
    if (rng_.below(2) == 0) room = rng_.below(site_.home().plan.rooms.size());
    if (site_.naming().is_stairs(room)) room = room_;
    before = site_.naming().same_room_name(room, room_) ? "Yes. " : "No. ";
    return say("is [it|the $thing] in the $room?",
               {{"room", site_.naming().room(room, rng_)}, {"thing", target_}});
  }

  void record(const std::vector<ViewpointIndex>& shown, const std::vector<ViewpointIndex>& walked) {
    tasks::PathAnnotation& entry = instances_.emplace_back();
    entry.scan = path_.scan;
    entry.heading = Radians(heading_);
    tasks::NamedRegion region{target_, site_.ids(site_.in_room(room_)), site_.ids(walked),
                              site_.ids(shown)};
    // As the benchmark trusts: the navigator who passed where the oracle pointed to.
    const bool passed = std::find(walked.begin() + 1, walked.end(), shown.back()) != walked.end();
    entry.path = passed ? region.player : region.planner;
    entry.goal = std::move(region);
    entry.instructions = {text_of(turns_, target_)};
    entry.details.emplace_back().turns = turns_;
    entry.group = path_.path_id;
  }

  const DescribedHome& site_;
  const tasks::PathAnnotation& path_;
  Rng rng_;
  ViewpointIndex at_;
  double heading_;
  std::size_t room_ = 0;
  std::string target_;
  std::int64_t steps_ = 0;
  std::vector<tasks::DialogueTurn> turns_;
  std::vector<tasks::PathAnnotation> instances_;
};

}  // namespace

std::vector<tasks::PathAnnotation> write_dialogue(const DescribedHome& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed) {
  return Game(site, path, seed).play();
}

}  // namespace enfilade::homes::benchmarks
