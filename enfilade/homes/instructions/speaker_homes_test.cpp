// Speakers in whole model homes: thousands of instructions, all of them checked.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "enfilade/core/rng.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/instructions/path_story.h"
#include "enfilade/homes/instructions/speaker.h"
#include "tests/support/instructions/instruction_checker.h"
#include "tests/support/instructions/instruction_reader.h"

namespace enfilade::homes::instructions {
namespace EN_UNIT {

constexpr std::size_t kHomes = 16, kPathsPerHome = 30;

struct Totals {
  std::size_t instructions = 0, wrong = 0, alike = 0;
  std::size_t longest = 0;  // words
  std::set<std::string> vocabulary;
  std::map<SpeakerKind, std::size_t> words, count;
};

bool is_word(const std::string& w) { return w != "," && w != "."; }

// The path's story, to look for what went wrong.
std::string explain(const SpokenHome& home, const std::vector<ViewpointIndex>& path,
                    double heading) {
  std::string text;
  const PathStory story = tell_path(home, path, heading);
  for (const PathStretch& s : story.stretches) {
    text += fmt::format("[{} to {}: turn {:.0f}, {:.1f} m, climb {}", s.first, s.last, s.turn,
                        s.metres, s.climb);
    for (const Happening& h : s.happenings) {
      if (h.kind == HappeningKind::kCross) {
        text += fmt::format(", {} at {:.1f}", home.home.plan.rooms[h.to].name, h.metres);
      }
    }
    text += "] ";
  }
  return text;
}

void speak_in(std::uint64_t seed, Totals& totals) {
  PlanOptions options;
  options.seed = seed;
  const BuiltHome built = build_home(options);
  const graph::NavGraph graph(build_graph(built, "home", 0));
  const ThingsInView sights(built.home, *built.tracer, graph);
  const SpokenHome home{built.home, graph, sights};
  const testing::InstructionChecker checker(built.home, *built.tracer, graph);
  Rng rng(seed);
  std::size_t paths = 0;
  for (std::size_t tries = 0; tries < 5000 && paths < kPathsPerHome; ++tries) {
    const ViewpointIndex a(rng.below(graph.size())), b(rng.below(graph.size()));
    const auto path = graph.path(a, b);
    if (!path || path->size() < 5 || path->size() > 7 || sights.room(a) == sights.room(b)) continue;
    ++paths;
    const double heading = 6.283 * rng.uniform();
    std::set<std::string> texts;
    for (const SpeakerKind speaker : kSpeakers) {
      const std::string text = describe(home, *path, heading, speaker, rng.next()).text;
      texts.insert(text);
      ++totals.instructions;
      ++totals.count[speaker];
      std::size_t words = 0;
      for (const std::string& w : testing::split_words(text)) {
        if (!is_word(w)) continue;
        totals.vocabulary.insert(w);
        ++words;
      }
      totals.words[speaker] += words;
      totals.longest = std::max(totals.longest, words);
      const auto faults = checker.check(text, *path, heading);
      if (faults.empty()) continue;
      if (++totals.wrong <= 40) {
        ADD_FAILURE() << "home " << seed << ": " << text << "\n  "
                      << ::testing::PrintToString(faults) << "\n  "
                      << explain(home, *path, heading);
      }
    }
    if (texts.size() < 3) ++totals.alike;
  }
}

TEST(DescribeHomes, AThousandInstructionsAreTrueAndRichInWords) {
  Totals totals;
  for (std::uint64_t seed = 1; seed <= kHomes; ++seed) speak_in(seed, totals);
  EXPECT_GE(totals.instructions, 1000U);
  EXPECT_EQ(totals.wrong, 0U);
  EXPECT_EQ(totals.alike, 0U);
  EXPECT_GE(totals.vocabulary.size(), 400U);
  // Room-to-Room's mean is 26 words without punctuation; bounds are wide, against drifting.
  std::size_t words = 0;
  for (const auto& [speaker, said] : totals.words) words += said;
  const double mean = static_cast<double>(words) / static_cast<double>(totals.instructions);
  EXPECT_GT(mean, 20);
  EXPECT_LT(mean, 32);
  EXPECT_LT(totals.words[SpeakerKind::kTerse], 8 * totals.words[SpeakerKind::kLandmarks] / 10);
  EXPECT_LT(totals.longest, 60U);
  RecordProperty("vocabulary", static_cast<int>(totals.vocabulary.size()));
  for (const auto& [speaker, said] : totals.words) {
    RecordProperty(fmt::format("words_of_speaker_{}", static_cast<int>(speaker)),
                   static_cast<int>(said / totals.count[speaker]));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::instructions
