/// \file  What routes of workers and of reviewers share.
#pragma once
#include <cstdint>

#include "enfilade/service/http/app.h"

namespace enfilade::service::http {

/// {task} of the path. \throws HttpError 404 if it is no number
std::int64_t task_id(const Request& request);

/// What was handed in, with its history and steps. \pre the asker is a reviewer or an organiser
/// \throws HttpError 404
Response work_response(Context& context, const Request& request, std::int64_t task);

}  // namespace enfilade::service::http
