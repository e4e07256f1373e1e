// Sessions of the arena (episodes stepped call by call), and its runs, shown step by step.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/service/sessions/replays.h"
#include "enfilade/service/sessions/sessions.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;
using sessions::Ticket;

constexpr std::size_t kMostCallBytes = 64U << 10U;  // of a call: a model's answer in words
constexpr std::size_t kLongestText = 200;           // of a tool or an argument
constexpr const char* kKeyHeader = "enfilade-session";

/// The key is in a header and not in the address, which logs and histories have.
Ticket ticket_of(const Request& request) {
  const std::string_view key = request.header(kKeyHeader);
  if (key.empty()) {
    throw HttpError(401,
                    "the header Enfilade-Session is missing: the key that the session began with");
  }
  return {request.id("session", "there is no such session"), std::string(key)};
}

Response begin(RouteContext& context, const Request& request) {
  context.begun_sessions.count(request.address, context.db.now());
  Form form(request.body);
  sessions::NewSession wanted;
  const std::string task = form.text("task", Presence::kOptional);
  if (!task.empty()) wanted.task = task;
  wanted.split = form.text("split");
  wanted.episode = form.text("episode", Presence::kOptional);
  const auto limit = [&form](const char* name) -> std::optional<std::uint32_t> {
    constexpr std::int64_t kMost = 1000;
    const std::int64_t given = form.whole(name, 0, 1, kMost);
    return given == 0 ? std::nullopt : std::optional(static_cast<std::uint32_t>(given));
  };
  wanted.steps = limit("steps");
  wanted.mistakes = limit("mistakes");
  form.check();
  const Ticket ticket = context.arena_sessions.begin(wanted);
  ordered_json out{{"key", ticket.key}};
  out.update(context.arena_sessions.state(ticket));
  Response response = json_response(out, 201);
  response.add_header("Location", fmt::format("/api/v1/sessions/{}", ticket.id));
  response.add_header("Cache-Control", "no-store");
  return response;
}

/// {"tool", "argument"?}, or {"answer"}: a model's words, of which the last line "Action: ..."
/// counts.
arena::Reading read_call(Form& form) {
  if (form.has("answer")) {
    if (form.has("tool")) form.add_fault("answer, tool: one of them");
    return arena::read_answer_text(form.text("answer"));
  }
  arena::Reading reading;
  arena::Call& call = reading.call.emplace();
  call.tool = form.text("tool");
  call.argument = form.text("argument", Presence::kOptional);
  for (const auto& [name, text] : {std::pair{"tool", &call.tool}, {"argument", &call.argument}}) {
    if (text->size() <= kLongestText) continue;
    form.add_fault(fmt::format("{}: longer than {} bytes", name, kLongestText));
  }
  return reading;
}

Response call(RouteContext& context, const Request& request) {
  const Ticket ticket = ticket_of(request);
  Form form(request.body);
  sessions::NewCall wanted{read_call(form), {}};
  constexpr std::int64_t kMost = 1'000'000;
  const std::int64_t after = form.whole("after", -1, 0, kMost);
  form.check();
  if (after >= 0) wanted.after = after;
  return json_response(context.arena_sessions.call(ticket, wanted));
}

arena::PictureKind kind_of(const Request& request) {
  const std::string& name = request.parameter("kind");
  if (name == "strip") return arena::PictureKind::kStrip;
  if (name == "places") return arena::PictureKind::kPlaces;
  throw HttpError(404, "pictures: strip or places");
}

Response picture(RouteContext& context, const Request& request) {
  constexpr std::int64_t kLeast = 64, kMost = 1024;
  const Ticket ticket = ticket_of(request);
  const auto number =
      static_cast<std::size_t>(std::max<std::int64_t>(0, request.id("number", "no such picture")));
  const auto size = static_cast<std::uint32_t>(request.number("size", 512, kLeast, kMost));
  Response response = text_response(
      "image/jpeg", context.arena_sessions.picture(ticket, kind_of(request), number, size));
  response.add_header("Cache-Control", "no-store");  // the same address shows another step later
  return response;
}

Response state(RouteContext& context, const Request& request) {
  return json_response(context.arena_sessions.state(ticket_of(request)));
}

Response result(RouteContext& context, const Request& request) {
  return text_response("application/json", context.arena_sessions.result(ticket_of(request)));
}

Response outcome(RouteContext& context, const Request& request) {
  return json_response(context.arena_sessions.outcome(ticket_of(request)));
}

Response list_runs(RouteContext& context, const Request& request) {
  return json_response(context.replays.runs(request.text("episode")));
}

/// One of an enumeration's names in the query; the first value where there is none.
template <class Enum>
Enum choice(const Request& request, const char* name) {
  const std::string text = request.text(name);
  if (text.empty()) return Enum{};
  if (const auto found = find_enum<Enum>(text)) return *found;
  throw HttpError(
      400, fmt::format("{}: {:.40?}; it can be {}", name, text, fmt::join(names_of(Enum{}), ", ")));
}

/// A page of a list.
std::pair<std::size_t, std::size_t> page_of(const Request& request) {
  constexpr std::int64_t kMostOffset = 1'000'000'000, kMostListed = 500;  // episodes
  return {static_cast<std::size_t>(request.number("offset", 0, 0, kMostOffset)),
          static_cast<std::size_t>(request.number("limit", kMostListed, 1, kMostListed))};
}

Response run(RouteContext& context, const Request& request) {
  sessions::EpisodeQuery query;
  std::tie(query.offset, query.limit) = page_of(request);
  query.sort = choice<sessions::EpisodeSort>(request, "sort");
  query.show = choice<sessions::EpisodeShow>(request, "show");
  query.descending = request.number("descending", 0, 0, 1) == 1;
  return json_response(context.replays.run(request.parameter("run"), query));
}

Response run_measures(RouteContext& context, const Request& request) {
  return json_response(context.replays.measures(request.parameter("run")));
}

Response compare_runs(RouteContext& context, const Request& request) {
  const auto [offset, limit] = page_of(request);
  return json_response(
      context.replays.compare(request.parameter("run"), request.parameter("other"), offset, limit));
}

Response run_episode(RouteContext& context, const Request& request) {
  return json_response(
      context.replays.episode(request.parameter("run"), request.parameter("episode")));
}

Response run_picture(RouteContext& context, const Request& request) {
  const auto number = [&request](const char* name) {
    return static_cast<std::size_t>(std::max<std::int64_t>(0, request.id(name, "no such picture")));
  };
  Response response = shared_response(
      "image/jpeg", context.replays.picture(request.parameter("run"), request.parameter("episode"),
                                            number("step"), number("number")));
  add_digest(response);
  return response;
}

}  // namespace

void add_session_routes(Router& router) {
  const std::string one = "/api/v1/sessions/{session}";
  router.add({"POST", "/api/v1/sessions", Access::kPublic, begin});
  router.add({"GET", one, Access::kPublic, state});
  router.add({"POST", one + "/calls", Access::kPublic, call, kMostCallBytes});
  router.add({"GET", one + "/pictures/{kind}/{number}", Access::kPublic, picture});
  router.add({"GET", one + "/result", Access::kPublic, result});
  router.add({"GET", one + "/outcome", Access::kPublic, outcome});
  router.add({"GET", "/api/v1/runs", Access::kPublic, list_runs});
  const std::string one_run = "/api/v1/runs/{run}";
  router.add({"GET", one_run, Access::kPublic, run});
  router.add({"GET", one_run + "/measures", Access::kPublic, run_measures});
  router.add({"GET", one_run + "/compare/{other}", Access::kPublic, compare_runs});
  router.add({"GET", one_run + "/episodes/{episode}", Access::kPublic, run_episode});
  router.add({"GET", one_run + "/episodes/{episode}/steps/{step}/pictures/{number}",
              Access::kPublic, run_picture});
}

}  // namespace enfilade::service::http
