// A list of messages of JSON-RPC to the server of MCP. Each request gets one response, with its id;
// nothing that a client says is an exception.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "enfilade/arena/mcp.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/check.h"
#include "tests/fuzz/json_mutator.h"
#include "tests/support/grid_world.h"

namespace {

using namespace enfilade;
using fuzz::Json;

bool is_id(const Json& id) { return id.is_string() || id.is_number_integer(); }

void check(const Json& message, const std::vector<std::string>& answers) {
  std::size_t responses = 0;
  for (const std::string& text : answers) {
    const Json answer = Json::parse(text);
    if (answer.is_array()) continue;  // of a batch
    EN_CHECK(answer.is_object() && answer.at("jsonrpc") == "2.0");
    if (answer.contains("method")) continue;  // a notification
    ++responses;
    EN_CHECK(answer.contains("result") != answer.contains("error"));
    const bool known = message.is_object() && message.contains("id") && is_id(message["id"]);
    if (known && answer.contains("result")) EN_CHECK(answer.at("id") == message["id"]);
  }
  EN_CHECK(responses <= 1);
  if (message.is_object() && message.contains("id") && is_id(message["id"]) &&
      message.contains("method") && message["method"].is_string()) {
    EN_CHECK_EQ(responses, 1U);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto kEpisodes = arena::testing::episodes(tasks::Task::kReverie, 2);
  std::vector<std::size_t> all(kEpisodes->episodes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  arena::McpServer server(std::make_unique<arena::GraphWorld>(kEpisodes), {},
                          {.episodes = all, .limits = {.steps = 5, .mistakes = 3}});
  const Json input = fuzz::parse_input(data, size);
  if (!input.is_array()) {
    server.handle({reinterpret_cast<const char*>(data), size});
    return 0;
  }
  for (const Json& message : input) check(message, server.handle(fuzz::text_of(message)));
  return 0;
}
