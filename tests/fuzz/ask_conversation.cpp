// A whole conversation with a model's server that says anything: {"task": 0, "answers": 0, "turns":
// [...]}. A turn is {"status", "body", "wait", "events"}, or the body alone. Each episode ends, by
// as many requests as there are turns, whatever they say.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/arena/chat.h"
#include "enfilade/arena/dialect.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/check.h"
#include "tests/fuzz/json_mutator.h"
#include "tests/support/grid_world.h"

namespace {

using namespace enfilade;
using fuzz::Json;

/// Says the turns one after another; then it is gone.
class Recorded final : public arena::Endpoint {
 public:
  explicit Recorded(Json turns) : turns_(std::move(turns)) {}

  std::string post(std::string_view body, const arena::RequestOrigin& /*origin*/) override {
    EN_CHECK(Json::accept(body));
    if (next_ == turns_.size()) throw arena::EndpointError(404, "gone", {}, "gone");
    const Json& turn = turns_[next_++];
    const Json& said = turn.is_object() && turn.contains("body") ? turn["body"] : turn;
    const int status = number(turn, "status") ? static_cast<int>(*number(turn, "status")) : 200;
    std::string text = fuzz::text_of(said);
    if (status != 200) throw arena::EndpointError(status, "refused", number(turn, "wait"), text);
    return turn.is_object() && turn.contains("events") ? arena::join_events(text) : text;
  }
  bool is_gone() const { return next_ == turns_.size(); }

 private:
  static std::optional<double> number(const Json& turn, const char* field) {
    if (!turn.is_object() || !turn.contains(field) || !turn[field].is_number()) return {};
    return std::clamp(turn[field].get<double>(), -1e9, 1e9);
  }

  Json turns_;
  std::size_t next_ = 0;
};

/// What the driver keeps and shows of a refusal.
void check_words(const arena::Refusal& refusal) {
  const std::string words = arena::words_in(refusal.body);
  EN_CHECK(words.size() <= 300);
  EN_CHECK(std::ranges::none_of(words, [](unsigned char c) { return c < ' ' || c == 0x7F; }));
  const auto kept = arena::find_refusal(arena::kept_refusal(refusal));
  EN_CHECK(kept.has_value() && kept->status == refusal.status);
  EN_CHECK(arena::kind_of(*kept) == arena::kind_of(refusal));
}

/// Asks for one step as ask() does. \returns no value if there is no answer to this request;
/// `dialect` has changed then, or the episode is over
std::optional<std::string> answer_to(Recorded& endpoint, arena::Chat& chat, std::string request,
                                     arena::Dialect& dialect) {
  const arena::Patience patience{3, 0, [](double /*seconds*/) { return true; }};
  for (;;) {
    try {
      return post_patiently(endpoint, request, {}, patience,
                            [&chat](std::string_view answer) { chat.read(answer); })
          .answer;
    } catch (const arena::GivenUp&) {
      return std::nullopt;
    } catch (const arena::RequestRefused& error) {
      const arena::Refusal& refusal = error.refusal();
      check_words(refusal);
      const bool too_long = kind_of(refusal) == arena::RefusalKind::kTooLong;
      if (!chat.leave_out_reasoning(refusal) && !(too_long && chat.shorten())) {
        if (const auto remedy = arena::remedy_for(refusal, request, dialect, {})) {
          EN_CHECK(!(*remedy == dialect));
          dialect = *remedy;
        }
        return std::nullopt;
      }
      const std::string next = chat.request();
      EN_CHECK(next != request);
      request = next;
    }
  }
}

/// \returns whether the episode is over, or has to begin again in another dialect
bool walk(arena::GraphWorld& world, const arena::Prompt& prompt, Recorded& endpoint,
          arena::Dialect& dialect) {
  const arena::SessionLimits limits{.steps = 6, .mistakes = 3};
  const auto session = world.start_on_graph(0, limits);
  const arena::Dialect before = dialect;
  arena::Chat chat(prompt, {.model = "m"}, dialect, limits);
  while (!session->ending()) {
    const std::string request = chat.ask(session->observation(), {}, {});
    const auto answer = answer_to(endpoint, chat, request, dialect);
    if (!answer) return dialect == before;
    const arena::ChatAnswer read = chat.read(*answer);
    EN_CHECK(read.reading.call.has_value() == read.reading.fault.empty());
    const std::uint32_t done = session->observation().step + session->mistakes();
    if (read.reading.call) {
      session->call(*read.reading.call);
    } else {
      session->misread(read.reading.fault);
    }
    EN_CHECK_EQ(session->observation().step + session->mistakes(), done + 1);
    chat.close(*answer, read, session->observation());
  }
  return true;
}

std::size_t choice(const Json& input, const char* field, std::size_t count) {
  const bool given = input.contains(field) && input[field].is_number_unsigned();
  return given ? input[field].get<std::uint64_t>() % count : 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static std::array worlds{
      std::make_unique<arena::GraphWorld>(arena::testing::episodes()),
      std::make_unique<arena::GraphWorld>(arena::testing::episodes(tasks::Task::kReverie)),
      std::make_unique<arena::GraphWorld>(arena::testing::episodes(tasks::Task::kR2rBack))};
  static const arena::Prompt prompt = arena::Prompt::named("text");
  constexpr std::array kAnswers{arena::Answers::kTools, arena::Answers::kJson,
                                arena::Answers::kText};
  const Json input = fuzz::parse_input(data, size);
  if (!input.is_object() || !input.contains("turns") || !input["turns"].is_array()) return -1;
  Recorded endpoint(input["turns"]);
  arena::Dialect dialect{.answers = kAnswers[choice(input, "answers", kAnswers.size())],
                         .stream = choice(input, "stream", 2) == 1};
  auto& world = *worlds[choice(input, "task", worlds.size())];
  for (int dialects = 0; !walk(world, prompt, endpoint, dialect); ++dialects) {
    EN_CHECK(dialects < 20);  // each remedy leaves something out
  }
  return 0;
}
