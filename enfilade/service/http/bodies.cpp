#include "enfilade/service/http/bodies.h"

#include <fmt/format.h>

#include "enfilade/service/http/http.h"

namespace enfilade::service::http {

using nlohmann::ordered_json;

ordered_json parse_object(const std::string& body) {
  ordered_json object = ordered_json::parse(body, nullptr, false);
  if (!object.is_object()) throw HttpError(400, "bad-body", "the body is not a JSON object");
  return object;
}

std::string field(const ordered_json& object, const char* name, bool required) {
  const auto found = object.find(name);
  if (found == object.end() && !required) return {};
  if (found == object.end() || !found->is_string()) {
    throw HttpError(400, "bad-body", fmt::format("{}: must be there, and a text", name));
  }
  return found->get<std::string>();
}

}  // namespace enfilade::service::http
