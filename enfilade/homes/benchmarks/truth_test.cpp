// What is written for other benchmarks is checked against the homes, by the reader of instructions
// that shares nothing with the writers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/benchmarks/described_home.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/tasks/tokenizer.h"
#include "tests/support/instructions/instruction_checker.h"
#include "tests/support/instructions/instruction_reader.h"

namespace enfilade::homes::benchmarks {
namespace EN_UNIT {

using instructions::testing::Claim;
using instructions::testing::Named;
using instructions::testing::read_instruction;
using instructions::testing::read_names;
using instructions::testing::split_words;
using ::testing::IsEmpty;

constexpr std::size_t kPaths = 14;
constexpr std::uint64_t kSeed = 7;

PlanOptions options_for(std::uint64_t seed, std::optional<unsigned> storeys) {
  PlanOptions options;
  options.seed = seed;
  options.storeys = storeys;
  return options;
}

// A home with paths, and everything that is needed to check what is said of it.
struct Place {
  explicit Place(std::uint64_t seed, std::optional<unsigned> storeys)
      : built(build_home(options_for(seed, storeys), HomeSurfaces::kPlain)),
        graph(build_graph(built, "home", 0)),
        sights(built.home, *built.tracer, graph),
        site(built, graph, sights, 0),
        checker(built.home, *built.tracer, graph),
        surfaces(built.home.mesh) {
    Rng rng(seed);
    for (std::size_t tries = 0; tries < 5000 && paths.size() < kPaths; ++tries) {
      const ViewpointIndex a(rng.below(graph.size())), b(rng.below(graph.size()));
      const auto found = graph.path(a, b);
      if (!found || found->size() < 5 || found->size() > 7 || sights.room(a) == sights.room(b)) {
        continue;
      }
      tasks::PathAnnotation& path = paths.emplace_back();
      path.path_id = static_cast<std::int64_t>(paths.size());
      path.scan = "home";
      path.heading = Radians(6.283 * rng.uniform());
      path.path = site.ids(*found);
    }
  }

  const Home& home() const { return built.home; }
  const PlanRoom& room_of(std::size_t thing) const {
    return home().plan.rooms[home().things[thing].room];
  }
  std::size_t thing_of(std::int64_t object) const {
    const auto found =
        std::ranges::find(home().things, static_cast<std::uint32_t>(object), &HomeThing::object);
    return static_cast<std::size_t>(found - home().things.begin());
  }

  BuiltHome built;
  graph::NavGraph graph;
  instructions::ThingsInView sights;
  DescribedHome site;
  instructions::testing::InstructionChecker checker;
  instructions::testing::Surfaces surfaces;
  std::vector<tasks::PathAnnotation> paths;
};

const std::vector<std::unique_ptr<Place>>& places() {
  static const auto kPlaces = [] {
    std::vector<std::unique_ptr<Place>> all;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      all.push_back(std::make_unique<Place>(seed, std::nullopt));
    }
    all.push_back(std::make_unique<Place>(4, 2));
    return all;
  }();
  return kPlaces;
}

// The storey that a text names, if it does.
std::optional<unsigned> storey_of(const Home& home, const std::string& text) {
  const auto has = [&](const char* words) { return text.find(words) != std::string::npos; };
  if (has("first floor") || has("level 1") || has("lower floor")) return 0;
  if (has("third floor") || has("level 3")) return 2;
  if (has("upper floor")) return static_cast<unsigned>(home.plan.storeys.size()) - 1;
  if (has("second floor") || has("level 2")) return 1;
  return std::nullopt;
}

// The rooms that a text sends to: of the name, of the storey, with the thing that marks it.
std::set<std::size_t> rooms_of(const Home& home, const std::string& text,
                               const std::vector<Named>& names) {
  std::set<std::size_t> rooms;
  const auto room = std::ranges::find_if(names, [](const Named& n) { return !n.rooms.empty(); });
  if (room == names.end()) return rooms;
  rooms = room->rooms;
  const auto storey = storey_of(home, text);
  std::erase_if(rooms,
                [&](std::size_t r) { return storey && home.plan.rooms[r].storey != *storey; });
  if (room + 1 != names.end() && (room + 1)->before == "with") {
    std::erase_if(rooms, [&](std::size_t r) {
      return std::ranges::none_of((room + 1)->thing.fits,
                                  [&](std::size_t t) { return home.things[t].room == r; });
    });
  }
  return rooms;
}

// The first thing named that does not mark a room.
std::vector<std::size_t> things_meant(const Home& home, const std::vector<Named>& names,
                                      const std::set<std::size_t>& rooms) {
  std::vector<std::size_t> found;
  for (const Named& name : names) {
    if (!name.rooms.empty() || name.before == "with") continue;
    for (const std::size_t thing : name.thing.fits) {
      if (rooms.contains(home.things[thing].room)) found.push_back(thing);
    }
    break;
  }
  return found;
}

TEST(Requests, NameARoomAndAThingThatTheEndShows) {
  std::size_t requests = 0, objects = 0;
  for (const auto& place : places()) {
    for (const tasks::PathAnnotation& path : place->paths) {
      for (const tasks::PathAnnotation& entry : write_requests(place->site, path, kSeed)) {
        const std::size_t thing = place->thing_of(std::get<tasks::NamedObject>(entry.goal).id);
        ASSERT_LT(thing, place->home().things.size());
        EXPECT_EQ(entry.path, path.path);
        EXPECT_EQ(entry.instructions.size(), 3U);
        ++objects;
        for (const std::string& text : entry.instructions) {
          const std::vector<Named> names = read_names(place->home(), text);
          const std::set<std::size_t> rooms = rooms_of(place->home(), text, names);
          EXPECT_THAT(things_meant(place->home(), names, rooms), ::testing::ElementsAre(thing))
              << text;
          EXPECT_TRUE(rooms.contains(place->home().things[thing].room)) << text;
          ++requests;
        }
        // By rays of its own: some point of it is in view from the end, and near.
        const Vec3f eye = place->graph.position(place->graph.find(path.path.back()).value());
        const auto points = place->surfaces.points(place->home().things[thing].object);
        EXPECT_TRUE(std::ranges::any_of(points, [&](Vec3f p) {
          return length(p - eye) < 3.2F && place->built.tracer->sees(eye, p, 0.02F);
        })) << entry.id;
      }
    }
  }
  EXPECT_GE(objects, 60U);
  EXPECT_GE(requests, 180U);
}

TEST(Descriptions, FitOneThingAndTheirPolygonsHoldIt) {
  std::size_t entries = 0, boxes = 0;
  for (const auto& place : places()) {
    const Home& home = place->home();
    for (const tasks::PathAnnotation& path : place->paths) {
      const auto alternatives = write_descriptions(place->site, path, kSeed);
      if (alternatives.empty()) continue;
      ++entries;
      const auto& goal = std::get<tasks::NamedBoxes>(alternatives[0].goal);
      std::set<std::size_t> meant;
      for (std::size_t k = 0; k < alternatives[0].instructions.size(); ++k) {
        const auto& fields = alternatives[0].details[k].fields;
        ASSERT_EQ(fields.size(), 4U);
        const std::string text = fields[0].second + fields[3].second;
        const std::vector<Named> names = read_names(home, text);
        const auto things = things_meant(home, names, rooms_of(home, text, names));
        ASSERT_EQ(things.size(), 1U) << text;
        const HomeThing& thing = home.things[things[0]];
        meant.insert(things[0]);
        const std::string look = fields[1].second, near = fields[2].second;
        if (look.find("high") != std::string::npos) {
          const double said = std::stod(look.substr(look.find_first_of("0123456789"))) / 100;
          EXPECT_NEAR(said, thing.high.z - thing.low.z, 0.051) << look;
        } else if (look.find("flat") != std::string::npos) {
          EXPECT_LT(thing.high.z - thing.low.z, 0.1);
        } else {
          EXPECT_NE(look.find(thing.colour), std::string::npos) << look;
        }
        const std::vector<Named> others = read_names(home, near);
        if (near.find("there is nothing") == std::string::npos && !others.empty()) {
          ASSERT_EQ(others.size(), 1U) << near;
          const auto gap = [&](std::size_t o) {
            const HomeThing& other = home.things[o];
            const auto apart = [](double a0, double a1, double b0, double b1) {
              return std::max({b0 - a1, a0 - b1, 0.0});
            };
            return std::hypot(apart(thing.low.x, thing.high.x, other.low.x, other.high.x),
                              apart(thing.low.y, thing.high.y, other.low.y, other.high.y));
          };
          const auto in_room = [&](std::size_t o) { return home.things[o].room == thing.room; };
          EXPECT_EQ(std::ranges::count_if(others[0].thing.fits, in_room), 1) << near;
          EXPECT_TRUE(std::ranges::any_of(others[0].thing.fits, [&](std::size_t o) {
            return o != things[0] && in_room(o) && gap(o) < 1.001;
          })) << near;
        }
      }
      ASSERT_EQ(meant.size(), 1U) << "all texts mean one thing";
      std::set<std::string> with_box;
      for (const tasks::NamedBox& box : goal.boxes) {
        ++boxes;
        with_box.insert(box.viewpoint);
        // Nearly all points of the thing in view lie in the outline, to the step of the rays;
        // between rays, thin parts may reach out a little farther.
        const double step = 2 * kPi / 240, centre = box.centre.heading.value;
        const Vec3f eye = place->graph.position(place->graph.find(box.viewpoint).value());
        std::size_t seen = 0, out = 0;
        for (const Vec3f p : place->surfaces.points(home.things[*meant.begin()].object)) {
          if (!place->built.tracer->sees(eye, p, 0.02F)) continue;
          const Vec3d d = to_double(p - eye);
          const double elevation = std::atan2(d.z, std::hypot(d.x, d.y));
          if (std::abs(elevation) > kPi / 3) continue;  // no view shows it
          const double beside = std::remainder(std::atan2(d.x, d.y) - centre, 2 * kPi);
          const double outside = std::max({elevation - box.corners[0].elevation.value,
                                           box.corners[2].elevation.value - elevation,
                                           box.corners[0].heading.value - centre - beside,
                                           beside - (box.corners[1].heading.value - centre)});
          EXPECT_LT(outside, 2.5 * step) << box.object;
          out += outside > step ? 1 : 0;
          ++seen;
        }
        EXPECT_LE(static_cast<double>(out), 0.05 * static_cast<double>(seen)) << box.object;
        EXPECT_GT(centre, box.corners[0].heading.value);
        EXPECT_LT(centre, box.corners[1].heading.value);
        EXPECT_GT(box.centre.elevation.value, box.corners[2].elevation.value);
        EXPECT_LT(box.centre.elevation.value, box.corners[0].elevation.value);
      }
      for (const tasks::PathAnnotation& one : alternatives) {
        EXPECT_EQ(one.goal, alternatives[0].goal);
        EXPECT_EQ(one.instructions, alternatives[0].instructions);
        EXPECT_TRUE(with_box.contains(one.path.back())) << "it ends where the thing is seen";
        const auto steps = place->site.look_up(one.path);
        for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
          EXPECT_NE(place->graph.edge(steps[i], steps[i + 1]), nullptr);
        }
      }
    }
  }
  EXPECT_GE(entries, 35U);
  EXPECT_GE(boxes, 70U);
}

// The text without its first words, up to and with `end`.
std::string after(const std::string& text, const std::string& end) {
  const std::size_t at = text.find(end);
  return at == std::string::npos ? text : text.substr(at + end.size());
}

double distance_to_region(const Place& place, ViewpointIndex from,
                          const std::vector<std::string>& region) {
  double least = std::numeric_limits<double>::infinity();
  for (const ViewpointIndex v : place.site.look_up(region)) {
    least = std::min(least, place.graph.distance(from, v));
  }
  return least;
}

// What a navigator claims, and what the oracle says first.
void check_question(const Place& place, const std::string& question, const std::string& answer,
                    const std::vector<ViewpointIndex>& shown, double heading,
                    std::size_t goal_room) {
  // The reader of instructions knows neither question marks nor "now".
  std::string plain = question;
  std::ranges::replace(plain, '?', '.');
  const std::size_t now = plain.find(" now.");
  if (now != std::string::npos) plain.erase(now, 4);
  const std::vector<Named> names = read_names(place.home(), plain);
  const bool yes = answer.starts_with("Yes. "), no = answer.starts_with("No. ");
  const bool names_a_room = question.starts_with("I am in") || question.starts_with("Is ");
  ASSERT_FALSE(names_a_room && names.empty()) << question;
  if (question.starts_with("I am in")) {
    ASSERT_EQ(names.size(), 1U) << question;
    EXPECT_TRUE(names[0].rooms.contains(place.sights.room(shown.front()).value())) << question;
    EXPECT_FALSE(yes || no);
  } else if (question.starts_with("Is ")) {
    ASSERT_TRUE(yes || no);
    EXPECT_EQ(names.back().rooms.contains(goal_room), yes) << question << " " << answer;
  } else if (question.find("right") != std::string::npos ||
             question.find("left") != std::string::npos) {
    ASSERT_TRUE(yes || no);
    const double turn = std::remainder(place.site.heading(shown[0], shown[1]) - heading, 2 * kPi);
    EXPECT_EQ((turn > 0) == (question.find("right") != std::string::npos), yes) << question;
  }
}

TEST(Dialogues, LeadAlongShortestPathsAndAreTrue) {
  std::size_t instances = 0, answers = 0;
  for (const auto& place : places()) {
    for (const tasks::PathAnnotation& path : place->paths) {
      const auto game = write_dialogue(place->site, path, kSeed);
      ViewpointIndex at = place->graph.find(path.path.front()).value();
      for (const tasks::PathAnnotation& one : game) {
        ++instances;
        const auto& region = std::get<tasks::NamedRegion>(one.goal);
        const auto shown = place->site.look_up(region.planner);
        const auto walked = place->site.look_up(region.player);
        ASSERT_GE(shown.size(), 2U);
        ASSERT_LE(shown.size(), 6U);
        EXPECT_EQ(shown.front(), at) << "where the last steps ended";
        EXPECT_EQ(walked.front(), at);
        double metres = 0;
        for (std::size_t i = 0; i + 1 < shown.size(); ++i) {
          EXPECT_NE(place->graph.edge(shown[i], shown[i + 1]), nullptr);
          metres += place->graph.distance(shown[i], shown[i + 1]);
        }
        for (std::size_t i = 0; i + 1 < walked.size(); ++i) {
          EXPECT_NE(place->graph.edge(walked[i], walked[i + 1]), nullptr);
        }
        EXPECT_NEAR(distance_to_region(*place, shown.front(), region.viewpoints),
                    metres + distance_to_region(*place, shown.back(), region.viewpoints), 1e-6)
            << "the oracle shows a shortest path to the region";
        const auto room = place->sights.room(place->site.look_up(region.viewpoints)[0]).value();
        EXPECT_TRUE(std::ranges::any_of(place->home().things, [&](const HomeThing& t) {
          return t.room == room && t.noun == region.target;
        })) << region.target;
        const auto& turns = one.details.at(0).turns;
        if (!turns.empty()) {
          ASSERT_GE(turns.size(), 2U);
          EXPECT_EQ(turns[turns.size() - 2].role, "navigator");
          EXPECT_EQ(turns.back().role, "oracle");
          const double heading = one.heading.value;
          std::string answer = turns.back().message;
          check_question(*place, turns[turns.size() - 2].message, answer, shown, heading, room);
          if (answer.starts_with("Yes. ") || answer.starts_with("No. ")) {
            answer = after(answer, ". ");
          }
          const std::string there = "The " + region.target + " is in there.";
          if (answer.ends_with(there)) {
            EXPECT_EQ(place->sights.room(shown.back()), room);
            answer.resize(answer.size() - there.size() - 1);
          }
          EXPECT_THAT(place->checker.check(answer, shown, heading), IsEmpty()) << answer;
          ++answers;
        }
        at = walked.back();
      }
    }
  }
  EXPECT_GE(instances, 80U);
  EXPECT_GE(answers, 40U);
}

TEST(Guides, SayWhatIsTrueWordByWord) {
  std::size_t words = 0, guides = 0, same = 0;
  for (const auto& place : places()) {
    for (const tasks::PathAnnotation& path : place->paths) {
      const auto steps = place->site.look_up(path.path);
      const GuidedPath guided = write_guides(place->site, path, kSeed);
      ASSERT_EQ(guided.guides.size(), guided.walks.size());
      for (std::size_t k = 0; k < guided.guides.size(); ++k) {
        const tasks::PathAnnotation& guide = guided.guides[k];
        ++guides;
        const std::string& text = guide.instructions.at(0);
        // Who begins on stairs does not say where.
        const std::string first = text.substr(0, text.find(". ") + 1);
        const bool says_room = first.find("ou are ") != std::string::npos;
        if (says_room) {
          const std::vector<Named> names = read_names(place->home(), first);
          ASSERT_EQ(names.size(), 1U) << first;
          EXPECT_TRUE(names[0].rooms.contains(place->sights.room(steps.front()).value())) << first;
        }
        EXPECT_THAT(
            place->checker.check(says_room ? after(text, ". ") : text, steps, path.heading.value),
            IsEmpty())
            << text;
        std::string joined;
        double now = 0;
        for (const tasks::TimedWord& word : guide.details.at(0).words) {
          joined += (joined.empty() ? "" : " ") + word.word;
          EXPECT_GE(word.start.value(), now - 1e-9) << word.word;
          EXPECT_GE(word.end.value(), word.start.value());
          now = word.start.value();
          ++words;
        }
        EXPECT_EQ(joined, text);
        // The trace stands at each viewpoint of the path in turn, and lasts as long as the words.
        std::vector<std::string> stood;
        for (const tasks::PoseSnapshot& snapshot : guided.traces.at(k).snapshots) {
          if (stood.empty() || stood.back() != snapshot.viewpoint) {
            stood.push_back(snapshot.viewpoint);
          }
          const Vec3f at = place->graph.position(place->graph.find(snapshot.viewpoint).value());
          EXPECT_LT(length(look_of(snapshot).position - to_double(at)), 1e-3);
        }
        EXPECT_EQ(stood, path.path);
        const tasks::PoseTrace& trace = guided.traces[k];
        EXPECT_NEAR(
            std::remainder(look_of(trace.snapshots[0]).heading.value - path.heading.value, 2 * kPi),
            0, 1e-5);
        EXPECT_NEAR(trace.snapshots.back().time, now, 30);
        EXPECT_GE(tasks::parse_pose_trace(to_npz(trace), "").snapshots.size(), path.path.size());
        const tasks::Demonstration& walk = guided.walks[k];
        const auto walked = place->site.look_up(walk.path);
        for (std::size_t i = 0; i + 1 < walked.size(); ++i) {
          EXPECT_NE(place->graph.edge(walked[i], walked[i + 1]), nullptr);
        }
        EXPECT_EQ(walked.front(), steps.front());
        EXPECT_NEAR(walk.ne, place->graph.distance(walked.back(), steps.back()), 1e-9);
        EXPECT_EQ(walk.sr, walk.ne < 3 ? 1 : 0);
        if (walked == steps) {
          ++same;
          EXPECT_EQ(walk.ndtw, 1);
        }
      }
    }
  }
  EXPECT_GT(words, 35 * guides) << "longer than Room-to-Room's";
  EXPECT_GT(same, guides / 2);
  EXPECT_LT(same, guides);
}

TEST(Pieces, CoverThePathAndTheText) {
  std::size_t pieces = 0, instructions = 0, moves = 0;
  for (const auto& place : places()) {
    for (const tasks::PathAnnotation& path : place->paths) {
      const auto steps = place->site.look_up(path.path);
      for (const instructions::SpeakerKind speaker : instructions::kSpeakers) {
        const instructions::Spoken spoken =
            describe(place->site.spoken(), steps, path.heading.value, speaker, kSeed);
        EXPECT_EQ(spoken.text,
                  describe(place->site.spoken(), steps, path.heading.value, speaker, kSeed).text);
        ++instructions;
        tasks::PathAnnotation one = path;
        one.instructions = {spoken.text};
        one = in_pieces(std::move(one), {spoken.parts});
        std::vector<std::string> all;
        std::size_t at = 0;
        for (const tasks::SubInstruction& part : one.details.at(0).parts) {
          all.insert(all.end(), part.words.begin(), part.words.end());
          ASSERT_TRUE(part.places);
          EXPECT_EQ(part.places->first, at) << spoken.text;
          EXPECT_GE(part.places->second, at);
          at = part.places->second;
          ++pieces;
        }
        EXPECT_EQ(at, steps.size() - 1);
        EXPECT_EQ(all, tasks::tokenize(spoken.text));
        for (const instructions::SpokenPart& part : spoken.parts) {
          moves += part.last > part.first ? 1 : 0;
          const auto reading = read_instruction(place->home(), part.text);
          for (const Claim& claim : reading.claims) {
            if (claim.kind != Claim::Kind::kCross || !claim.to) continue;
            // On the way, or in the doorway at its end.
            const std::size_t last = std::min(part.last + 1, steps.size() - 1);
            bool met = false;
            for (std::size_t i = part.first; i <= last; ++i) {
              const auto room = place->sights.room(steps[i]);
              met = met || (room && claim.to->contains(*room));
            }
            EXPECT_TRUE(met) << part.text << " in " << spoken.text;
          }
        }
      }
    }
  }
  EXPECT_GT(pieces, 2 * instructions);
  EXPECT_GT(moves, instructions);
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::benchmarks
