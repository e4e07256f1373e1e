/// \file  The API's OpenAPI description, openapi.json, as a build step put it into the library.
#pragma once
#include <string_view>

namespace enfilade::service::http {
extern const std::string_view kOpenApi;
}
