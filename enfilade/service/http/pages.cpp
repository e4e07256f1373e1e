// The built pages and assets of the web client. For administrators: health, metrics, the API's
// description.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/gzip.h"
#include "enfilade/draw/markup.h"
#include "enfilade/service/collecting/assignments.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/service/http/web_files.h"

namespace enfilade::service::http {
namespace {

/// Mechanical Turk shows a collection's page in a frame and receives its form.
void allow_platform(RouteContext& context, const Request& request, Response& response) {
  const auto collection = collecting::find_collection(context.db, request.text("collection"));
  if (!collection || collection->platform.kind != collecting::PlatformKind::kMturk) return;
  const std::string origins = fmt::format("{}", fmt::join(collection->platform.origins, " "));
  response.add_header("Content-Security-Policy", content_policy("'self' " + origins, origins));
  response.frameable = true;
}

// Limit of a file of the pages, unpacked: they are our own, and none has a megabyte.
constexpr std::size_t kMostBytes = 16U << 20U;

/// Null if there is none.
const WebFile* find_file(std::string_view address) {
  std::string path(address == "/" ? "/index" : address);
  if (path.find('.') == std::string::npos) path += ".html";
  const auto files = web_files();
  const auto found = std::ranges::lower_bound(files, path, {}, &WebFile::path);
  return found == files.end() || found->path != path ? nullptr : &*found;
}

/// Links to the style sheets, whose names change with their content.
const std::string& style_links() {
  static const std::string kLinks = [] {
    std::string links;
    for (const WebFile& file : web_files()) {
      if (!file.path.ends_with(".css")) continue;
      links += fmt::format("<link rel=\"stylesheet\" href=\"{}\" />", file.path);
    }
    return links;
  }();
  return kLinks;
}

// By store::Trouble. Strangers may ask: details, which name files, are in the log.
constexpr std::array<std::string_view, names_of(store::Trouble{}).size()> kExplanations{
    "the disk of the database is full, or nearly so",
    "the database's file was moved or replaced; the server must be started again",
    "the database cannot be read",
    "the database cannot be written",
    "the database's server cannot be reached",
    "a table of the database is missing"};

Response health(RouteContext& context, const Request& /*request*/) {
  if (const auto trouble = context.health.trouble()) {
    std::string words(kExplanations[static_cast<std::size_t>(*trouble)]);
    if (*trouble == store::Trouble::kTableMissing) words += ": " + context.health.missing_table();
    return error_response(503, enum_name(*trouble), words);
  }
  return json_response({{"status", "ok"}});
}

Response metrics(RouteContext& context, const Request& /*request*/) {
  return text_response(
      "text/plain; version=0.0.4; charset=utf-8",
      context.metrics.text(
          {{"enfilade_submissions_queued", static_cast<double>(context.submissions.queued())},
           {"enfilade_work_to_review",
            static_cast<double>(collecting::waiting_for_review(context.db))},
           {"process_resident_memory_bytes", static_cast<double>(resident_bytes())}}));
}

Response description(RouteContext& /*context*/, const Request& /*request*/) {
  return text_response("application/json", std::string(kOpenApi));
}

/// The header that pages have (elements/page.ts), for those that no script draws.
std::string site_header(const HeaderFacts& served) {
  using Link = std::pair<std::string_view, std::string_view>;
  constexpr Link kRuns{"/replay", "Runs"};
  constexpr std::array<Link, 5> kPages{{{"/", "Buildings"},
                                        {"/episodes", "Episodes"},
                                        {"/leaderboard", "Leaderboard"},
                                        {"/submit", "Submit"},
                                        {"/organise", "Collections"}}};
  std::string links;
  const auto add = [&links](const Link& link) {
    links += fmt::format("<a href=\"{}\">{}</a>", link.first, link.second);
  };
  std::ranges::for_each(kPages, add);
  if (served.runs) add(kRuns);
  return fmt::format(
      "<header class=\"site\"><a href=\"/\" class=\"name\">Enfilade</a>"
      "<nav aria-label=\"Pages\" class=\"site-links\">{}</nav>{}</header>",
      links,
      served.synthetic ? "<span class=\"badge synthetic\">Model homes: SYNTHETIC</span>" : "");
}

}  // namespace

bool is_page(std::string_view path) { return path == "/" || find_file(path) != nullptr; }

void show_to_people(const Request& request, const HeaderFacts& served, Response& error) {
  const bool by_browser = request.header("accept").find("text/html") != std::string_view::npos;
  if (!by_browser || request.path.starts_with("/api/")) return;
  const bool nothing = error.status == 404;
  const std::string heading =
      nothing ? "There is nothing here" : fmt::format("This did not work ({})", error.status);
  const std::string text =
      nothing ? "The address may be mistyped, or the page has moved." : draw::escape(error.problem);
  error.type = "text/html; charset=utf-8";
  error.body = std::make_shared<const std::string>(fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\" />"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\" />"
      "<title>{0} · Enfilade</title>{1}</head>\n"
      "<body>{3}\n"
      "<main id=\"main\" class=\"lost\"><h1>{0}</h1><p class=\"note\">{2}</p>"
      "<p><a href=\"/\" class=\"button main\">To the first page</a></p></main></body></html>\n",
      heading, style_links(), text, site_header(served)));
}

// "/leaderboard" is the file /leaderboard.html. Names of assets change with their content.
Response page(RouteContext& context, const Request& request) {
  const WebFile* found = find_file(request.path);
  if (found == nullptr) {
    if (request.path == "/") {
      return text_response("text/plain; charset=utf-8",
                           "This build of Enfilade has no web client in it: npm was not there. "
                           "The API is at /api/v1/, its description at /api/v1/openapi.json\n");
    }
    throw HttpError(404, "there is nothing here");
  }
  const bool packed = accepts_gzip(request);
  Response response =
      text_response(std::string(found->type),
                    packed ? std::string(found->gzip) : gunzip(found->gzip, kMostBytes));
  if (packed) response.add_header("Content-Encoding", "gzip");
  response.add_header("Vary", "Accept-Encoding");
  response.add_header("ETag", fmt::format("\"{}\"", found->digest));
  response.add_header("Cache-Control", found->path.starts_with("/assets/")
                                           ? "public, max-age=31536000, immutable"
                                           : "no-cache");
  if (found->path == "/collect.html" || found->path == "/walk.html")
    allow_platform(context, request, response);
  return response;
}

void add_operation_routes(Router& router) {
  router.add({"GET", "/healthz", Access::kPublic, health});
  router.add({"GET", "/metrics", Access::kPublic, metrics});
  router.add({"GET", "/api/v1/openapi.json", Access::kPublic, description});
}

}  // namespace enfilade::service::http
