/// \file  The routes of the API, a function for each group.
#pragma once
#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/http/context.h"
#include "enfilade/service/http/router.h"

namespace enfilade::service::http {

void add_browsing_routes(Router& router);
void add_account_routes(Router& router);
/// \param most_bytes of a results file
void add_evaluation_routes(Router& router, std::size_t most_bytes);
/// For organisers. \param most_bytes of a new collection
void add_collection_routes(Router& router, std::size_t most_bytes);
void add_review_routes(Router& router);
void add_work_routes(Router& router);
/// Health, metrics and the API's description.
void add_operation_routes(Router& router);

/// A built page or asset of the web client. \throws HttpError 404
Response page(Context& context, const Request& request);

/// {collection} of the path. \throws HttpError 404
collecting::Collection collection_of(Context& context, const Request& request);
/// {task} of the path. \throws HttpError 404 if it is no number
std::int64_t task_of(const Request& request);

/// Submitted work with its history and steps. \pre a reviewer or an organiser asks
/// \throws HttpError 404
Response work_response(Context& context, const Request& request, std::int64_t task);

}  // namespace enfilade::service::http
