#include "enfilade/arena/prompt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using tests::refusal;

SessionObservation observation() {
  SessionObservation seen;
  seen.instruction = "Go past the sofa & stop at {{here}}.";
  seen.step = 1;
  seen.heading = degrees(90);
  seen.here = "B";
  seen.places = {{"A", degrees(-175), degrees(0), 2.34, true, true, ""},
                 {"C", degrees(3), degrees(-25), 4, false, false, "a bed"},
                 {"D", degrees(47), degrees(0), 1.05, false, true, ""}};
  seen.map = {{"A", {"B", "D"}}, {"B", {"A", "C", "D"}}};
  seen.told = "You went to B, 2.3 m.";
  seen.tools = {{Tool::kGoTo, "place", {"A", "C", "D"}}, {Tool::kStop, {}, {}}};
  return seen;
}

Prompt prompt(const std::string& start, const std::string& step) {
  return Prompt::parse("answers: text\n---\n" + start + "\n---\n" + step, "p.txt", "p");
}

TEST(Prompts, FillInWhatIsKnown) {
  const Prompt made = prompt("{{instruction}} In {{steps}} steps.",
                             "{{#places}}{{name}} {{turn_words}}{{elevation_words}} {{distance}}"
                             "{{#what}} {{what}}{{/what}}|{{/places}} {{unvisited}}");
  EXPECT_EQ(made.start(observation(), Answers::kTools, {.steps = 7}),
            "Go past the sofa & stop at {{here}}. In 7 steps.");  // no HTML, no second look
  EXPECT_THAT(made.step(observation(), Answers::kTools, {}, {}),
              "A behind you 2.3|C straight on, 25 degrees down 4.0 a bed|"
              "D 47 degrees to the right 1.1| C, D");
  EXPECT_THAT(made.step(observation(), Answers::kText, {}, {}),
              HasSubstr("\n\nTools:\ngo_to <place: A, C, D>\nstop"));
}

TEST(Prompts, TellWhatWasDone) {
  const Prompt made =
      prompt("", "{{#history}}{{number}}: {{thought}}/{{call}}/{{told}}\n{{/history}}");
  const std::vector<PastStep> past{{"Left.", "go_to B", "You went to B."}, {"", "", "Nothing."}};
  EXPECT_EQ(made.step(observation(), Answers::kTools, {}, past),
            "1: Left./go_to B/You went to B.\n2: /none/Nothing.");
}

// Golden: what a change of a template or of its values changes.
TEST(Prompts, MapGpt) {
  const Prompt made = Prompt::named("mapgpt");
  EXPECT_EQ(made.pictures(), PictureKind::kPlaces);
  EXPECT_EQ(made.answers(), Answers::kJson);
  EXPECT_EQ(made.memory(), PromptMemory::kLast);
  EXPECT_EQ(made.step(observation(), Answers::kTools, {},
                      std::vector<PastStep>{{"East first.", "go_to B", "You went to B, 2.3 m."}}),
            "Step 1: go_to B. You went to B, 2.3 m. You thought: East first.\n"
            "Map:\n"
            "A is connected with B, D\n"
            "B (you are here) is connected with A, C, D\n"
            "Places that were seen and not visited: C, D\n"
            "\n"
            "Step 2 of 30. You can go to:\n"
            "A: behind you, 2.3 m away; its picture is named A; you have been there\n"
            "C: straight on, 25 degrees down, 4.0 m away; its picture is named C\n"
            "D: 47 degrees to the right, 1.1 m away; its picture is named D");
}

TEST(Prompts, BuiltInOnesSayHowToAnswerAndWhatIsThere) {
  for (const std::string& name : Prompt::names()) {
    const Prompt made = Prompt::named(name);
    for (const Answers answers : {Answers::kTools, Answers::kJson, Answers::kText}) {
      const std::string start = made.start(observation(), answers, {});
      EXPECT_THAT(start, HasSubstr("Go past the sofa & stop at {{here}}.")) << name;
      EXPECT_THAT(start, HasSubstr(answers == Answers::kText ? "Action:" : "")) << name;
      const std::string step = made.step(observation(), answers, {}, {});
      for (const char* part : {"A", "C", "D", "4.0 m", "Step 2"}) {
        EXPECT_THAT(step, HasSubstr(part)) << name;
      }
      EXPECT_THAT(step, Not(HasSubstr("{{"))) << name;
    }
  }
  EXPECT_THAT(refusal<LookupError>([] { Prompt::named("gpt"); }),
              HasSubstr("no prompt \"gpt\"; there are text, marks, navgpt, mapgpt"));
}

TEST(Prompts, FaultsNameTheLine) {
  const auto fault = [](const std::string& text) {
    return refusal<InvalidInput>([&] { Prompt::parse(text, "p.txt", "p"); });
  };
  EXPECT_THAT(fault("pictures: film\n---\na\n---\nb"),
              HasSubstr("p.txt: line 1: \"film\", not one of none, strip, places"));
  EXPECT_THAT(fault("\nmodel: x\n---\n---\n"), HasSubstr("line 2: \"model\", not pictures"));
  EXPECT_THAT(fault("Hello\n---\n---\n"), HasSubstr("line 1: not \"name: value\""));
  EXPECT_THAT(fault("kept_pictures: -1\n---\n---\n"), HasSubstr("a whole number from 0 to 100"));
  EXPECT_THAT(fault("---\nonly one"), HasSubstr("the texts of the start and of a step"));
  EXPECT_THAT(fault("---\na\n---\nb\n---\nc"), HasSubstr("a third text"));
  EXPECT_THAT(fault("---\na\n---\n{{#places}} x"), HasSubstr("line 4"));
  EXPECT_THAT(fault("---\na\n---\nb\n{{> /etc/passwd}}"),
              HasSubstr("line 5: \"> /etc/passwd\": partials and other delimiters"));
  EXPECT_THAT(fault("---\n{{=<% %>=}}\n---\n"), HasSubstr("line 2: \"=<% %>=\": partials"));
  EXPECT_THAT(fault("---\na\n---\nb\n{{#places}}\n{{ nmae }}{{/places}}"),
              HasSubstr("line 6: \"nmae\", not one of answer_rule, call, "));
  EXPECT_EQ(fault("---\n{{! any}}{{{told}}}{{& told}}\n---\n{{# map }}{{^is_here}}{{/is_here}}"
                  "{{/map}}"),
            "accepted");
  EXPECT_EQ(fault("---\n{{ ! any }}{{ & told }}{{{ told }}}\n---\n{{ # places }}{{ name }}"
                  "{{ ^ visited }}{{ / visited }}{{ /places }}"),
            "accepted");
  for (const char* tag : {"{{ > file }}", "{{##told}}", "{{ {told}}}", "{{{ &told }}}"}) {
    EXPECT_THAT(fault("---\na\n---\n" + std::string(tag)), HasSubstr("line 4: ")) << tag;
  }
  EXPECT_EQ(fault("---\n---\n"), "accepted");
  EXPECT_THAT(refusal<FileError>([] { Prompt::load("/nowhere.txt"); }), HasSubstr("nowhere"));
}

TEST(Prompts, AreReadAsAnyEditorSavesThem) {
  const tests::TemporaryFolder folder("prompt");
  const auto file = folder.path() / "mine.txt";
  for (const std::string& saved :
       {std::string("\uFEFFanswers: json\n---\na\n---\nb\n\nc"),
        std::string("\uFEFFanswers: json\r\n---\r\na\r\n---\r\nb\r\n\r\nc\r\n"),
        gzip("answers: json\n---\na\n---\nb\n\nc", 6)}) {
    write_file_atomically(file, saved);
    const Prompt made = Prompt::open(file);
    EXPECT_EQ(made.name(), "mine");
    EXPECT_EQ(made.answers(), Answers::kJson);
    EXPECT_EQ(made.start(observation(), Answers::kJson, {}), "a");
    EXPECT_EQ(made.step(observation(), Answers::kTools, {}, {}), "b\n\nc");
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
