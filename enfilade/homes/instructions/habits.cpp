#include "enfilade/homes/instructions/habits.h"

#include <array>

namespace enfilade::homes::instructions {
namespace {

/// By Speaker.
constexpr std::array<Habits, 4> kHabits{
    // kTerse
    Habits{.brevity = 1,
           .bend = 0.85,
           .towards = 0.02,
           .things = 0.02,
           .all_things = 1,
           .merge = 0.7,
           .skip = 0.9,
           .goal = 0.8,
           .elide = 0.8,
           .clauses = 4,
           .links = Links::kShort,
           .least_words = 8,
           .most_words = 20},
    // kLandmarks
    Habits{.brevity = 0.6,
           .bend = 0.6,
           .start = 0.12,
           .towards = 0.2,
           .things = 0.7,
           .all_things = 2,
           .distance = 0.1,
           .merge = 0.7,
           .skip = 0.8,
           .openings = 0.08,
           .goal = 0.95,
           .elide = 0.4,
           .clauses = 3,
           .least_words = 20,
           .most_words = 40},
    // kStepByStep
    Habits{.brevity = 0.3,
           .bend = 0.25,
           .start = 0.06,
           .towards = 0.1,
           .things = 0.2,
           .all_things = 1,
           .distance = 0.4,
           .merge = 0.4,
           .skip = 0.6,
           .openings = 0.2,
           .goal = 0.9,
           .elide = 0.2,
           .clauses = 2,
           .least_words = 20,
           .most_words = 40},
    // kGuide: as long as the path asks for
    Habits{.brevity = 0.1,
           .bend = 0,
           .start = 0.9,
           .towards = 0.6,
           .things = 0.95,
           .all_things = 8,
           .distance = 0.8,
           .merge = 0,
           .skip = 0,
           .openings = 0.5,
           .goal = 1,
           .elide = 0,
           .clauses = 2,
           .least_words = 300,
           .most_words = 300},
};

}  // namespace

Habits habits_of(Speaker speaker) { return kHabits.at(static_cast<std::size_t>(speaker)); }

Habits leaner_habits(Habits h, double leaner) {
  for (double* share : {&h.brevity, &h.bend, &h.merge, &h.skip, &h.elide}) {
    *share += (1 - *share) * leaner;
  }
  for (double* share : {&h.start, &h.towards, &h.distance, &h.openings}) *share *= 1 - leaner;
  h.things *= 1 - leaner / 2;  // landmarks say the most in few words
  return h;
}

}  // namespace enfilade::homes::instructions
