// For those who run the server.
#include <nlohmann/json.hpp>

#include "enfilade/service/collecting/tasks.h"
#include "enfilade/service/http/app.h"
#include "enfilade/service/http/description.h"

namespace enfilade::service::http {

void add_operation_routes(Router& router, Context& context) {
  router.add({"GET", "/healthz", Access::kPublic, [&context](const Request&) {
                context.evaluation.queued();  // the database answers
                return json_response(R"({"status":"ok"})");
              }});
  router.add(
      {"GET", "/metrics", Access::kPublic, [&context](const Request&) {
         Response response = json_response(context.metrics.text(
             {{"enfilade_submissions_queued", static_cast<double>(context.evaluation.queued())},
              {"enfilade_work_to_review",
               static_cast<double>(collecting::waiting_for_review(*context.database))},
              {"process_resident_memory_bytes", static_cast<double>(resident_bytes())}}));
         response.type = "text/plain; version=0.0.4; charset=utf-8";
         return response;
       }});
  router.add({"GET", "/api/v1/openapi.json", Access::kPublic,
              [](const Request&) { return json_response(std::string(kOpenApi)); }});
}

}  // namespace enfilade::service::http
