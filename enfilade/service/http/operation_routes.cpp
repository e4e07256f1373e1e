// For administrators: health, metrics, the API's description.
#include <nlohmann/json.hpp>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/collecting/tasks.h"
#include "enfilade/service/http/description.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

// Strangers may ask: details, which name files, are in the log.
std::string_view explanation(store::Trouble trouble) {
  switch (trouble) {
    case store::Trouble::kDiskFull:
      return "the disk of the database is full, or nearly so";
    case store::Trouble::kDatabaseReplaced:
      return "the database's file was moved or replaced; the server must be started again";
    case store::Trouble::kDatabaseUnreadable:
      return "the database cannot be read";
    case store::Trouble::kDatabaseUnwritable:
      return "the database cannot be written";
    case store::Trouble::kDatabaseUnreachable:
      return "the database's server cannot be reached";
  }
  return "";
}

Response health(Context& context, const Request& /*request*/) {
  if (const auto trouble = context.health.trouble()) {
    return error_response(503, enum_name(*trouble), explanation(*trouble));
  }
  return json_response({{"status", "ok"}});
}

Response metrics(Context& context, const Request& /*request*/) {
  return text_response(
      "text/plain; version=0.0.4; charset=utf-8",
      context.metrics.text(
          {{"enfilade_submissions_queued", static_cast<double>(context.submissions.queued())},
           {"enfilade_work_to_review",
            static_cast<double>(collecting::waiting_for_review(context.db))},
           {"process_resident_memory_bytes", static_cast<double>(resident_bytes())}}));
}

Response description(Context& /*context*/, const Request& /*request*/) {
  return text_response("application/json", std::string(kOpenApi));
}

}  // namespace

void add_operation_routes(Router& router) {
  router.add({"GET", "/healthz", Access::kPublic, health});
  router.add({"GET", "/metrics", Access::kPublic, metrics});
  router.add({"GET", "/api/v1/openapi.json", Access::kPublic, description});
}

}  // namespace enfilade::service::http
