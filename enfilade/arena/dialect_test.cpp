#include "enfilade/arena/dialect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace enfilade::arena {
namespace EN_UNIT {

using ::testing::HasSubstr;

constexpr const char* kRequest =
    R"({"model": "m", "messages": [{"role": "system", "content": "s"}], "temperature": 0, "seed": 1,
        "max_tokens": 50, "tools": [], "tool_choice": "required"})";
constexpr const char* kJsonRequest =
    R"({"model": "m", "messages": [], "response_format": {"type": "json_schema"}, "stream": true})";

/// The remedies, each step on its own line of differences; "" if there is none.
std::string changed(const std::string& body, const std::string& request = kRequest,
                    Dialect dialect = {}, const SetByHand& by_hand = {}) {
  const auto found = remedy_for({400, body}, request, dialect, by_hand);
  if (!found) return "nothing";
  std::string text = std::string(names_of(Answers())[static_cast<std::size_t>(found->answers)]);
  for (const std::string& one : differences(*found)) text += "; " + one;
  return text;
}

// In the forms of OpenAI, vLLM, Mistral, FastAPI, Ollama, OpenRouter and others.
TEST(Dialects, LeaveOutOrRenameWhatIsNamed) {
  struct Row {
    const char *body, *changed;
  };
  constexpr Row kRows[] = {
      {R"({"error": {"message": "Unsupported value: 'temperature' does not support 0.", "param": "temperature", "code": "unsupported_value"}})",
       "tools; temperature is left out"},
      {R"({"error": {"message": "temperature: only 1 is supported", "type": "invalid_request_error"}})",
       "tools; temperature is left out"},
      {R"({"error": {"message": "Use 'max_completion_tokens' instead of 'max_tokens'.", "param": "max_tokens"}})",
       "tools; max_completion_tokens takes the place of max_tokens"},
      {R"({"error": {"message": "max_tokens: use max_completion_tokens"}})",
       "tools; max_completion_tokens takes the place of max_tokens"},
      {R"({"detail": [{"type": "extra_forbidden", "loc": ["body", "seed"], "msg": "Extra inputs are not permitted", "input": 1}]})",
       "tools; seed is left out"},
      {R"({"object": "error", "message": {"detail": [{"loc": ["body", "seed"], "msg": "no", "input": {"temperature": 0}}]}})",
       "tools; seed is left out"},
      {R"({"object": "error", "message": "[{'type': 'extra_forbidden', 'loc': ('body', 'seed')}]", "param": null})",
       "tools; seed is left out"},
      {R"({"error": {"message": "tool_choice 'required' is not supported, use 'auto'; see tools"}})",
       "tools; tool_choice is auto"},
      {R"({"error": {"message": "registry/gemma:2b does not support tools", "param": null}})",
       "json"},
      {R"({"error": {"message": "No endpoints found that support tool use.", "code": 404}})",
       "json"},
      {R"({"detail": "Stream must be set to true"})", "tools; responses are streamed"},
      {"This model only supports streaming", "tools; responses are streamed"},
      {R"({"error": {"message": "System role not supported"}})",
       "tools; the system's text is in the user's first message"},
      {R"({"error": {"message": "the model is not there"}})", "nothing"},
      {R"({"error": {"message": "bad messages", "param": "messages[0].content"}})", "nothing"},
      {R"({"error": {"message": "min_temperatures are odd"}})", "nothing"},
      {"", "nothing"},
  };
  for (const Row& row : kRows) EXPECT_EQ(changed(row.body), row.changed) << row.body;
}

// llama-cpp-python with the format chatml-function-calling.
TEST(Dialects, AnErrorWithoutATextIsOfARequiredTool) {
  const std::string silent = R"({"error": {"message": "", "type": "internal_server_error"}})";
  EXPECT_TRUE(says_invalid(silent));
  EXPECT_EQ(changed(silent, R"({"tools": [], "tool_choice": "required"})"),
            "tools; tool_choice is auto");
  EXPECT_EQ(changed(silent, R"({"tools": [], "tool_choice": "auto"})"), "nothing");
  EXPECT_FALSE(says_invalid(R"({"error": {"message": "busy"}})"));
  EXPECT_FALSE(says_invalid(R"({"error": ""})"));
  EXPECT_FALSE(says_invalid("[]"));
}

TEST(Dialects, GoOnFromRemedyToRemedy) {
  const std::string limit = R"({"error": {"message": "no max_completion_tokens", "param": null}})";
  Dialect dialect;
  dialect.limit = LimitField::kMaxCompletionTokens;
  EXPECT_EQ(changed(limit, R"({"max_completion_tokens": 5})", dialect),
            "tools; max_tokens is left out");
  const std::string format = R"({"error": {"message": "bad response_format"}})";
  dialect = {.answers = Answers::kJson};
  EXPECT_EQ(changed(format, kJsonRequest, dialect),
            "json; response_format is json_object with schema");
  dialect.json = JsonForm::kObjectOfSchema;
  EXPECT_EQ(changed(format, kJsonRequest, dialect), "json; response_format is json_object");
  dialect.json = JsonForm::kObject;
  EXPECT_EQ(changed(format, kJsonRequest, dialect), "text");
  EXPECT_EQ(changed(format, kJsonRequest, dialect, {.answers = true}),
            "json; response_format is left out");
  dialect.json = JsonForm::kNone;
  EXPECT_EQ(changed(format, R"({"model": "m", "stream": true})", dialect), "nothing");
  dialect = {};
  dialect.tool_choice = ToolChoice::kNone;
  const std::string parser = R"({"error": "\"auto\" tool choice requires --tool-call-parser"})";
  EXPECT_EQ(changed(parser, R"({"tools": [], "stream": true})", dialect), "json");
}

TEST(Dialects, LeaveAloneWhatIsSetByHand) {
  EXPECT_EQ(changed(R"({"error": {"message": "no tools here"}})", kRequest, {}, {.answers = true}),
            "nothing");
  EXPECT_EQ(changed(R"({"error": {"message": "no max_tokens"}})", kRequest, {}, {.limit = true}),
            "nothing");
}

TEST(Dialects, TellRefusalsApart) {
  struct Row {
    int status;
    const char* body;
    RefusalKind kind;
  };
  constexpr Row kRows[] = {
      {400, R"({"error": {"code": "context_length_exceeded", "message": "..."}})",
       RefusalKind::kTooLong},
      {500,
       R"({"error": {"message": "could not broadcast input array from shape (97,) into shape (84,) "}})",
       RefusalKind::kTooLong},
      {400, R"({"error": {"message": "the request exceeds the available context size"}})",
       RefusalKind::kTooLong},
      {400, R"({"message": "This model's maximum context length is 4096 tokens."})",
       RefusalKind::kTooLong},
      {413, "", RefusalKind::kTooLong},
      {400, R"({"error": {"message": "This model's maximum prompt length is 131072"}})",
       RefusalKind::kTooLong},
      {400, R"([{"error": {"message": "The input token count (9) exceeds the maximum number"}}])",
       RefusalKind::kTooLong},
      {422, R"({"error": "`inputs` tokens + `max_new_tokens` must be <= 4096. Given: 5000"})",
       RefusalKind::kTooLong},
      {400, R"({"error": {"message": "Invalid request: the model token limit is 8192"}})",
       RefusalKind::kTooLong},
      {400, R"({"error": {"code": "content_filter", "param": "prompt"}})", RefusalKind::kFilter},
      {400, R"({"code": "data_inspection_failed"})", RefusalKind::kFilter},
      {403, R"({"error": {"message": "Your input was flagged"}})", RefusalKind::kFilter},
      {400, R"({"error": {"message": "temperature: only 1"}})", RefusalKind::kOther},
      {401, "wrong key", RefusalKind::kOther},
      // Of the account and of settings.
      {401, R"({"error": {"message": "context window: no key"}})", RefusalKind::kOther},
      {402, R"({"error": {"message": "credits for the context length"}})", RefusalKind::kOther},
      {403, R"({"error": {"message": "You have reached your token limit"}})", RefusalKind::kOther},
      {403, R"({"error": {"message": "Your account was flagged"}})", RefusalKind::kOther},
      {404, R"({"error": {"message": "no model of that context size"}})", RefusalKind::kOther},
  };
  for (const Row& row : kRows) EXPECT_EQ(kind_of({row.status, row.body}), row.kind) << row.body;
}

TEST(Dialects, StatusFiveHundredMayBeARefusal) {
  const auto passes = [](int status, const std::string& body) {
    return EndpointError(status, "", {}, body).passes();
  };
  EXPECT_TRUE(passes(500, "out of order"));
  EXPECT_TRUE(passes(500, R"({"error": {"message": "CUDA out of memory"}})"));
  EXPECT_FALSE(
      passes(500, R"({"error": {"message": "[{'type': 'literal_error', 'loc': ('body',)}]"}})"));
  EXPECT_FALSE(passes(500, R"({"error": {"type": "invalid_request_error"}})"));
  EXPECT_FALSE(passes(500, R"({"error": {"message": "the maximum context length is 4096"}})"));
  EXPECT_FALSE(passes(500, R"({"error": {"code": "content_filter"}})"));
  EXPECT_TRUE(passes(503, R"({"error": {"type": "invalid_request_error"}})"));
  EXPECT_FALSE(passes(501, ""));
  EXPECT_FALSE(passes(400, ""));
}

TEST(Dialects, KeepRefusalsAndTheirWords) {
  const Refusal refusal{422, R"({"detail": [{"loc": ["body", "seed"], "msg": "not permitted"}]})"};
  EXPECT_EQ(words_in(refusal.body), "not permitted (seed)");
  EXPECT_EQ(words_in("<html>"), "<html>");
  EXPECT_EQ(words_in(R"({"error": {"message": "no"}})"), "no");
  EXPECT_EQ(words_in("a\r\n\x1b[31mb\x7f"), "a   [31mb ") << "nothing for a terminal";
  // OpenRouter's, with the provider's in it.
  EXPECT_EQ(words_in(R"({"error": {"message": "Provider returned error",)"
                     R"( "metadata": {"raw": "{\"error\": {\"message\": \"too hot\"}}"}}})"),
            "too hot");
  const auto again = find_refusal(kept_refusal(refusal));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->status, 422);
  EXPECT_EQ(again->body, refusal.body);
  EXPECT_FALSE(find_refusal(R"({"choices": []})"));
  EXPECT_FALSE(find_refusal(R"({"refused": 3})"));
  EXPECT_TRUE(refusal_names({400, "no reasoning_content, please"}, "reasoning_content"));
  EXPECT_FALSE(refusal_names({400, "no reasoning_contents"}, "reasoning_content"));
}

TEST(Events, BecomeOneCompletion) {
  const std::string events =
      ": a comment\r\n\r\n"
      "data: "
      "{\"id\":\"x\",\"choices\":[{\"delta\":{\"role\":\"assistant\",\"content\":null}}]}\r\n\r\n"
      "data: {\"choices\":[{\"delta\":{\"reasoning_content\":\"h\"}}]}\n\n"
      "data: {\"choices\":[{\"delta\":{\"reasoning_content\":\"m\",\"content\":\"East\"}}]}\n\n"
      "data: {\"choices\":[{\"delta\":{\"content\":\".\",\"tool_calls\":[{\"index\":0,\"id\":\"c\","
      "\"type\":\"function\",\"function\":{\"name\":\"go_to\",\"arguments\":\"{\\\"pl\"}}]}}]}\n\n"
      "data: {\"choices\":[{\"delta\":{\"tool_calls\":[{\"index\":0,\"function\":{\"arguments\":"
      "\"ace\\\":\\\"B\\\"}\"}}]},\"finish_reason\":\"tool_calls\"}]}\n\n"
      "data: {\"choices\":[],\"usage\":{\"prompt_tokens\":7}}\n\n"
      "data: [DONE]\n\n";
  EXPECT_EQ(
      join_events(events),
      R"({"object":"chat.completion","id":"x","choices":[{"index":0,"message":)"
      R"({"role":"assistant","content":"East.","reasoning_content":"hm","tool_calls":)"
      R"([{"index":0,"id":"c","type":"function","function":{"name":"go_to","arguments":)"
      R"("{\"place\":\"B\"}"}}]},"finish_reason":"tool_calls"}],"usage":{"prompt_tokens":7}})");
  EXPECT_THROW(join_events("data: {\"choices\":[{\"delta\":{\"content\":\"x\"}}]}\n\n"),
               EndpointError);
  EXPECT_THAT(join_events("data: {\"error\":{\"message\":\"busy\"}}\n\n"), HasSubstr("busy"));
}

TEST(Events, MayBeOdd) {
  const std::string end =
      "data: {\"choices\":[{\"delta\":{\"content\":\"x\"}}]}\n\ndata: [DONE]\n\n";
  for (const char* odd :
       {R"("delta": "text")", R"("delta": [])", R"("delta": null)", R"("message": 3)"}) {
    const std::string event = "data: {\"choices\": [{" + std::string(odd) + "}]}\n\n";
    EXPECT_THAT(join_events(event + end), HasSubstr(R"("content":"x")")) << odd;
    EXPECT_THAT(join_events(event + "data: [DONE]\n\n"), HasSubstr(R"("content":null)")) << odd;
  }
  for (const char* damaged : {"data: {\"choices\":[{\"del\n\n", "data: 3\n\n"}) {
    EXPECT_THROW(join_events(damaged + end), EndpointError) << damaged;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
