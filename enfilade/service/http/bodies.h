/// \file  Small bodies of requests, read field by field.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace enfilade::service::http {

/// \throws HttpError 400 if the body is no JSON object
nlohmann::ordered_json parse_object(const std::string& body);

/// A text of an object. \throws HttpError 400 if it is none, or is required and absent
std::string field(const nlohmann::ordered_json& object, const char* name, bool required);

}  // namespace enfilade::service::http
