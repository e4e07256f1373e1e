#include "enfilade/arena/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace enfilade::arena {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;

SessionObservation observation() {
  SessionObservation seen;
  seen.instruction = "Go to \"the\" desk.";
  seen.step = 2;
  seen.heading = degrees(270);
  seen.here = "C";
  seen.places = {{"B", degrees(-32.123456), degrees(3), 2.12345, true, true},
                 {"D", degrees(10), degrees(0), 4, false, false}};
  seen.map = {{"A", {"B", "C"}}, {"C", {"B", "D"}}};
  seen.told = "You went to C, 2.1 m.";
  seen.tools = {{Tool::kGoTo, "place", {"B", "D"}},
                {Tool::kMove, "actions", {"forward", "left"}, true},
                {Tool::kStop, {}, {}}};
  return seen;
}

TEST(Wire, ObservationsHaveDegreesAndMetres) {
  const json out = json::parse(to_json(observation()));
  EXPECT_EQ(out.at("heading"), 270);
  EXPECT_EQ(out.at("places")[0], (json{{"name", "B"},
                                       {"turn", -32.12},
                                       {"elevation", 3.0},
                                       {"distance", 2.123},
                                       {"visited", true},
                                       {"seen_before", true}}));
  EXPECT_EQ(out.at("map")[1], (json{{"name", "C"}, {"leads_to", {"B", "D"}}}));
  EXPECT_FALSE(out.contains("things"));
  EXPECT_EQ(out.at("tools")[2], (json{{"tool", "stop"}}));
}

TEST(Wire, ToolsHaveSchemasOfWhatIsPossible) {
  const json tools = json::parse(functions_json(observation()));
  ASSERT_EQ(tools.size(), 3U);
  EXPECT_EQ(tools[0].at("name"), "go_to");
  EXPECT_EQ(tools[0].at("parameters"),
            json::parse(R"({"type": "object", "additionalProperties": false, "required": ["place"],
                            "properties": {"place": {"type": "string", "enum": ["B", "D"]}}})"));
  const json moves = tools[1].at("parameters").at("properties").at("actions");
  EXPECT_EQ(moves.at("maxItems"), 4);
  EXPECT_EQ(moves.at("items").at("enum"), (json{"forward", "left"}));
  EXPECT_TRUE(tools[2].at("parameters").at("properties").empty());
  const json schema = json::parse(answer_schema(observation())).at("properties");
  EXPECT_EQ(schema.at("tool").at("enum"), (json{"go_to", "move", "stop"}));
  const json choices = schema.at("argument").at("anyOf");
  ASSERT_EQ(choices.size(), 3U);
  EXPECT_EQ(choices[0].at("maxItems"), 4);
  EXPECT_EQ(choices[1].at("enum"), (json{"B", "D"}));
  EXPECT_EQ(choices[2].at("type"), "null");
}

TEST(Wire, PlainToolsHaveStringsAlone) {
  const std::vector<ToolUse> uses{{Tool::kGoTo, "place", {}},
                                  {Tool::kMove, "actions", {"forward", "left"}, true},
                                  {Tool::kStop, {}, {}}};
  const json tools = json::parse(plain_functions_json(uses));
  ASSERT_EQ(tools.size(), 3U);
  EXPECT_EQ(tools[0].at("parameters"),
            json::parse(R"({"type": "object", "additionalProperties": false, "required": ["place"],
                            "properties": {"place": {"type": "string", "description":
                            "One of the values that the last result lists for go_to."}}})"));
  EXPECT_EQ(tools[1].at("parameters").at("properties").at("actions").at("description"),
            "One to 4 of forward, left, with commas between them.");
  EXPECT_TRUE(tools[2].at("parameters").at("properties").empty());
}

TEST(Wire, CallsAreReadFromArguments) {
  EXPECT_EQ(read_call("go_to", R"({"place": "B"})").call, (Call{"go_to", "B"}));
  EXPECT_EQ(read_call(" stop ", "").call, (Call{"stop", ""}));
  EXPECT_EQ(read_call("move", R"({"actions": ["forward", "left"]})").call,
            (Call{"move", "forward,left"}));
  EXPECT_EQ(read_call("move", R"({"actions": "[\"forward\", \"left\"]"})").call,
            (Call{"move", "forward,left"}));
  EXPECT_EQ(read_call("move", R"({"actions": "[forward"})").call, (Call{"move", "[forward"}));
  EXPECT_EQ(read_call("answer", R"({"object": 3, "why": {}})").call, (Call{"answer", "3"}));
  EXPECT_EQ(read_call("go_to", "{\"place\":").fault, "the arguments of \"go_to\" are no JSON");
  EXPECT_EQ(read_call("go_to", "[]").fault, "the arguments of \"go_to\" are no JSON object");
  EXPECT_LT(read_call(std::string(100'000, 'a'), "[").fault.size(), 200U);
  EXPECT_THAT(read_call("go_to", R"({"place": {"a": 1}})").fault, HasSubstr("neither a text nor"));
  EXPECT_THAT(read_call("move", R"({"actions": [["a"]]})").fault, HasSubstr("neither a text nor"));
  EXPECT_EQ(read_call("", "{}").fault, "no tool is named");
}

TEST(Wire, CallsAreReadFromAnswers) {
  const Reading marked = read_answer_json(
      "Sure:\n```json\n{\"thought\": \"The desk.\", \"tool\": \"go_to\", \"argument\": "
      "\"D\"}\n```");
  EXPECT_EQ(marked.call, (Call{"go_to", "D"}));
  EXPECT_EQ(marked.thought, "The desk.");
  EXPECT_EQ(read_answer_json(R"({"tool": "stop", "argument": null})").call, (Call{"stop", ""}));
  EXPECT_FALSE(read_answer_json("I stop.").call);
  EXPECT_FALSE(read_answer_json(R"({"tool": 3})").call);
  EXPECT_FALSE(read_answer_json("} {").call);

  const Reading text = read_answer_text("Thought: a desk.\n**Action: go_to(B)**\n");
  EXPECT_EQ(text.call, (Call{"go_to", "B"}));
  EXPECT_EQ(text.thought, "Thought: a desk.");
  EXPECT_EQ(read_answer_text("action: STOP.").call, (Call{"STOP", ""}));
  EXPECT_EQ(read_answer_text("Action: go_to B\nno\nAction: go_to D").call, (Call{"go_to", "D"}));
  EXPECT_EQ(read_answer_text("Action: move forward, left").call, (Call{"move", "forward, left"}));
  EXPECT_EQ(read_answer_text("I would stop here.").fault, "no line begins with \"Action:\"");
  EXPECT_EQ(read_answer_text("Action:").fault, "nothing stands after \"Action:\"");
  EXPECT_FALSE(read_answer_text("").call);
}

TEST(Wire, ReasoningIsTheThought) {
  constexpr const char* kStop = R"({"thought": "", "tool": "stop", "argument": null})";
  struct Row {
    std::string text, thought;
  };
  const Row rows[] = {
      {std::string("<think>Draft: {\"tool\": \"look\"}.</think>\n") + kStop,
       "Draft: {\"tool\": \"look\"}."},
      {std::string("No {brace here.</think>\n```json\n") + kStop + "\n```", "No {brace here."},
      {std::string("a</think>b</think>") + kStop, "a</think>b"},
      {std::string("[THINK]x[/THINK]") + kStop, "x"},
      {std::string(R"({"tool": "go_to", "argument": "B"} or rather )") + kStop + " {\"a\": 1} {",
       ""},
      {std::string(R"(Braces {like "these} and )") + kStop, ""},
  };
  for (const Row& row : rows) {
    const Reading reading = read_answer_json(row.text);
    EXPECT_EQ(reading.call, (Call{"stop", ""})) << row.text << reading.fault;
    EXPECT_EQ(reading.thought, row.thought) << row.text;
  }
  EXPECT_FALSE(read_answer_json("<think>Maybe {\"tool\": \"stop\"}").call) << "cut off";
  EXPECT_EQ(
      read_answer_json(R"({"thought": "t", "tool": "go_to", "argument": {"place": "B"}})").call,
      (Call{"go_to", "B"}));
  EXPECT_EQ(read_call("go_to", R"("{\"place\": \"B\"}")").call, (Call{"go_to", "B"}));
  EXPECT_EQ(read_call("stop", "null").call, (Call{"stop", ""}));
  const Reading text = read_answer_text("Action: go_to B?</think>Action: stop");
  EXPECT_EQ(text.call, (Call{"stop", ""}));
  EXPECT_EQ(text.thought, "Action: go_to B?");
  EXPECT_FALSE(read_answer_text("Action: stop</think>Well.").call);
  EXPECT_FALSE(read_answer_json(std::string(100'000, '{')).call);
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
