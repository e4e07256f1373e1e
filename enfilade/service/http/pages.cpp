// The built pages and assets of the web client.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/detail/gzip.h"
#include "enfilade/service/http/headers.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/service/http/web_files.h"

namespace enfilade::service::http {
namespace {

/// Mechanical Turk shows a collection's page in a frame and receives its form.
void allow_platform(Context& context, const Request& request, Response& response) {
  const auto collection = collecting::find_collection(context.db, request.text("collection"));
  if (!collection || collection->platform.kind != collecting::PlatformKind::kMturk) return;
  const std::string origins = fmt::format("{}", fmt::join(collection->platform.origins, " "));
  response.add_header("Content-Security-Policy", content_policy("'self' " + origins, origins));
  response.frameable = true;
}

}  // namespace

// "/leaderboard" is the file /leaderboard.html. Names of assets change with their content.
Response page(Context& context, const Request& request) {
  std::string path = request.path == "/" ? "/index" : request.path;
  if (path.find('.') == std::string::npos) path += ".html";
  const auto files = web_files();
  const auto found = std::ranges::lower_bound(files, path, {}, &WebFile::path);
  if (found == files.end() || found->path != path) {
    if (request.path == "/" && files.empty()) {
      return text_response("text/plain; charset=utf-8",
                           "This build of Enfilade has no web client in it: npm was not there. "
                           "The API is at /api/v1/, its description at /api/v1/openapi.json\n");
    }
    throw HttpError(404, "there is nothing here");
  }
  const bool packed = accepts_gzip(request);
  Response response = text_response(
      std::string(found->type), packed ? std::string(found->gzip) : detail::gunzip(found->gzip));
  if (packed) response.add_header("Content-Encoding", "gzip");
  response.add_header("Vary", "Accept-Encoding");
  response.add_header("ETag", fmt::format("\"{}\"", found->digest));
  response.add_header("Cache-Control", path.starts_with("/assets/")
                                           ? "public, max-age=31536000, immutable"
                                           : "no-cache");
  if (path == "/collect.html" || path == "/walk.html") allow_platform(context, request, response);
  return response;
}

}  // namespace enfilade::service::http
