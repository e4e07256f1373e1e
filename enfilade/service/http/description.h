/// \file  The API's description, openapi.json, which a build step puts into the library.
#pragma once
#include <string_view>

namespace enfilade::service::http {
extern const std::string_view kOpenApi;
}
