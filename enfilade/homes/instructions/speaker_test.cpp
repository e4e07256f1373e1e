#include "enfilade/homes/instructions/speaker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/instructions/path_story.h"
#include "tests/support/instructions/box_home.h"
#include "tests/support/instructions/instruction_checker.h"
#include "tests/support/instructions/instruction_reader.h"

namespace enfilade::homes::instructions {
namespace EN_UNIT {

struct Path {
  std::vector<ViewpointIndex> viewpoints;
  double heading = 0;
};

// Shortest paths of 3 to 6 edges from room to room, looking anywhere.
std::vector<Path> paths_in(const graph::NavGraph& graph, const ThingsInView& sights,
                           std::size_t most, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Path> found;
  for (std::size_t tries = 0; tries < 200 * most && found.size() < most; ++tries) {
    const ViewpointIndex a(rng.below(graph.size())), b(rng.below(graph.size()));
    const auto path = graph.path(a, b);
    if (!path || path->size() < 4 || path->size() > 7 || sights.room(a) == sights.room(b)) continue;
    found.push_back({*path, 6.283 * rng.uniform()});
  }
  return found;
}

struct Stage {
  Home home;
  std::shared_ptr<mesh::RayTracer> tracer = testing::tracer_of(home);
  graph::NavGraph graph;
  ThingsInView sights{home, *tracer, graph};
  SpokenHome spoken{home, graph, sights};
  testing::InstructionChecker checker{home, *tracer, graph};
};

Stage& small_stage() {
  static Stage stage = [] {
    Home home = testing::small_home();
    const auto tracer = testing::tracer_of(home);
    return Stage{home, tracer, testing::small_graph(*tracer)};
  }();
  return stage;
}

// --- what a checker must find ----------------------------------------------------------------

std::vector<std::size_t> places_of(const std::string& text, const std::string& word) {
  std::vector<std::size_t> found;
  const auto is_letter = [&](std::size_t i) {
    return i < text.size() && std::isalpha(static_cast<unsigned char>(text[i])) != 0;
  };
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    if (!is_letter(at - 1) && !is_letter(at + word.size())) found.push_back(at);
  }
  return found;
}

// One of `words`, anywhere in the text, becomes another of them.
std::optional<std::string> exchange(const std::string& text, const std::vector<std::string>& words,
                                    Rng& rng) {
  std::vector<std::pair<std::size_t, std::string>> places;
  for (const std::string& word : words) {
    for (const std::size_t at : places_of(text, word)) places.emplace_back(at, word);
  }
  // "right inside", "right before", "right next to" are no sides.
  std::erase_if(places, [&](const auto& p) {
    const std::string rest = text.substr(p.first);
    return p.first == 0 || rest.starts_with("right inside") || rest.starts_with("right before") ||
           rest.starts_with("right next");
  });
  if (places.empty()) return std::nullopt;
  const auto [at, word] = places[rng.below(places.size())];
  std::string other = word;
  while (other == word) other = words[rng.below(words.size())];
  return text.substr(0, at) + other + text.substr(at + word.size());
}

std::vector<std::string> sentences_of(const std::string& text) {
  std::vector<std::string> found;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('.', begin);
    found.push_back(text.substr(begin, end + 1 - begin));
    begin = end + 2;
  }
  return found;
}

// Two sentences change places.
std::optional<std::string> reorder(const std::string& text, const std::vector<std::string>&,
                                   Rng& rng) {
  std::vector<std::string> sentences = sentences_of(text);
  if (sentences.size() < 2) return std::nullopt;
  const std::size_t k = rng.below(sentences.size() - 1);
  std::swap(sentences[k], sentences[k + 1]);
  std::string out;
  for (const std::string& s : sentences) out += (out.empty() ? "" : " ") + s;
  return out;
}

struct Damage {
  const char* name;
  std::optional<std::string> (*make)(const std::string&, const std::vector<std::string>&, Rng&);
  std::vector<std::string> words;
};

TEST(InstructionChecker, FindsWhatWasDamaged) {
  const Stage& stage = small_stage();
  const std::vector<Damage> damages{
      {"side", exchange, {"left", "right"}},
      {"order", reorder, {}},
      {"colour", exchange, {"green", "red", "white", "brown", "black", "blue", "silver"}},
      {"room", exchange, {"kitchen", "bedroom", "office", "bathroom", "living room"}},
      {"another", exchange, {"into the", "into another"}},
      {"stairs", exchange, {"upstairs", "downstairs"}},
      {"noun", exchange, {"bench", "sofa", "bed", "desk", "plant", "fridge", "wardrobe"}}};
  for (const Damage& damage : damages) {
    Rng rng(3);
    std::size_t made = 0, found = 0;
    for (const Path& path : paths_in(stage.graph, stage.sights, 200, 5)) {
      for (const SpeakerKind speaker : kSpeakers) {
        const std::string text =
            describe(stage.spoken, path.viewpoints, path.heading, speaker, rng.next()).text;
        const auto damaged = damage.make(text, damage.words, rng);
        if (!damaged) continue;
        ++made;
        const bool caught = !stage.checker.check(*damaged, path.viewpoints, path.heading).empty();
        if (caught) ++found;
      }
    }
    RecordProperty(damage.name, std::to_string(found) + " of " + std::to_string(made));
    EXPECT_GT(made, 20U) << damage.name;
    EXPECT_GT(static_cast<double>(found), 0.95 * static_cast<double>(made)) << damage.name;
  }
}

TEST(InstructionChecker, FindsSharpTurnsThatAreNone) {
  const Stage& stage = small_stage();
  Rng rng(4);
  std::size_t made = 0;
  for (const Path& path : paths_in(stage.graph, stage.sights, 300, 9)) {
    const auto story = tell_path(stage.spoken, path.viewpoints, path.heading);
    const double turn = story.stretches.front().turn;
    if (std::abs(turn) < 65 || std::abs(turn) > 125) continue;
    const std::string text =
        describe(stage.spoken, path.viewpoints, path.heading, SpeakerKind::kTerse, rng.next()).text;
    const std::string plain = turn > 0 ? "Turn right" : "Turn left";
    if (!text.starts_with(plain)) continue;
    const std::string sharp = "Turn sharp" + text.substr(std::string("Turn").size());
    ++made;
    EXPECT_EQ(stage.checker.check(sharp, path.viewpoints, path.heading).empty(),
              std::abs(turn) >= 90)
        << sharp << " " << turn;
  }
  EXPECT_GT(made, 10U);
}

TEST(Describe, SaysOnlyWhatIsTrueInASmallHome) {
  const Stage& stage = small_stage();
  Rng rng(2);
  for (const Path& path : paths_in(stage.graph, stage.sights, 300, 1)) {
    for (const SpeakerKind speaker : kSpeakers) {
      const std::string text =
          describe(stage.spoken, path.viewpoints, path.heading, speaker, rng.next()).text;
      EXPECT_THAT(stage.checker.check(text, path.viewpoints, path.heading), ::testing::IsEmpty())
          << text;
    }
  }
}

TEST(Describe, IsWellWrittenAndTheSameForTheSameSeed) {
  const Stage& stage = small_stage();
  for (const Path& path : paths_in(stage.graph, stage.sights, 100, 7)) {
    std::set<std::string> texts;
    for (const SpeakerKind speaker : kSpeakers) {
      const std::string text =
          describe(stage.spoken, path.viewpoints, path.heading, speaker, 11).text;
      EXPECT_EQ(text, describe(stage.spoken, path.viewpoints, path.heading, speaker, 11).text);
      EXPECT_NE(text, describe(stage.spoken, path.viewpoints, path.heading, speaker, 12).text);
      EXPECT_TRUE(text.ends_with('.')) << text;
      EXPECT_FALSE(text.ends_with("..")) << text;
      for (const char* bad :
           {"  ", " ,", " .", ",,", "$", "[", "]", "|", " a a", " a e", " a i", " a o"}) {
        EXPECT_EQ(text.find(bad), std::string::npos) << text;
      }
      for (const std::string& one : sentences_of(text)) {
        EXPECT_TRUE(one.size() > 2 && one[0] >= 'A' && one[0] <= 'Z') << text;
      }
      texts.insert(text);
    }
    EXPECT_EQ(texts.size(), 3U);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::instructions
