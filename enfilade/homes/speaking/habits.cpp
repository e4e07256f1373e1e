#include "enfilade/homes/speaking/habits.h"

namespace enfilade::homes::speaking {
namespace {

Habits terse() {
  Habits h;
  h.brevity = 1;
  h.bend = 0.85;
  h.towards = h.things = 0.02;
  h.all_things = 1;
  h.merge = 0.7;
  h.skip = 0.9;
  h.goal = h.elide = 0.8;
  h.clauses = 4;
  h.links = Links::kShort;
  h.least_words = 8;
  h.most_words = 20;
  return h;
}

Habits by_landmarks() {
  Habits h;
  h.brevity = h.bend = 0.6;
  h.start = 0.12;
  h.towards = 0.2;
  h.things = h.merge = 0.7;
  h.all_things = 2;
  h.distance = 0.1;
  h.skip = 0.8;
  h.openings = 0.08;
  h.goal = 0.95;
  h.elide = 0.4;
  h.clauses = 3;
  h.least_words = 20;
  h.most_words = 40;
  return h;
}

Habits step_by_step() {
  Habits h;
  h.brevity = 0.3;
  h.bend = 0.25;
  h.start = 0.06;
  h.towards = 0.1;
  h.things = h.openings = h.elide = 0.2;
  h.all_things = 1;
  h.distance = h.merge = 0.4;
  h.skip = 0.6;
  h.goal = 0.9;
  h.clauses = 2;
  h.least_words = 20;
  h.most_words = 40;
  return h;
}

}  // namespace

Habits habits_of(Speaker speaker) {
  switch (speaker) {
    case Speaker::kTerse:
      return terse();
    case Speaker::kLandmarks:
      return by_landmarks();
    case Speaker::kStepByStep:
      break;
  }
  return step_by_step();
}

Habits leaner_habits(Habits h, double leaner) {
  for (double* share : {&h.brevity, &h.bend, &h.merge, &h.skip, &h.elide}) {
    *share += (1 - *share) * leaner;
  }
  for (double* share : {&h.start, &h.towards, &h.distance, &h.openings}) *share *= 1 - leaner;
  h.things *= 1 - leaner / 2;  // what one sees says most in few words
  return h;
}

}  // namespace enfilade::homes::speaking
