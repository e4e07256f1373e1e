#include "enfilade/report/parts/page.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/draw/markup.h"

namespace enfilade::report::parts {
namespace {

// Marks our own scripts. Text of the data set cannot know it.
std::string random_nonce() {
  std::random_device device;
  std::string nonce;
  for (int i = 0; i < 4; ++i) nonce += fmt::format("{:08x}", device());
  return nonce;
}

using Values = std::array<std::pair<std::string_view, std::string_view>, 7>;

// Replaces each {{name}} of the template. The inserted values are not searched for names.
std::string fill(std::string_view html, const Values& values) {
  std::string page;
  while (true) {
    const std::size_t begin = html.find("{{");
    page += html.substr(0, begin);
    if (begin == std::string_view::npos) return page;
    const std::size_t end = html.find("}}", begin);
    EN_CHECK(end != std::string_view::npos);
    const std::string_view name = html.substr(begin + 2, end - begin - 2);
    const auto value = std::ranges::find(values, name, &Values::value_type::first);
    EN_CHECK(value != values.end());
    page += value->second;
    html.remove_prefix(end + 2);
  }
}

}  // namespace

std::string script_json(const nlohmann::ordered_json& data) {
  constexpr bool kAscii = true;
  const std::string json =
      data.dump(-1, ' ', kAscii, nlohmann::ordered_json::error_handler_t::replace);
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";  // in JSON, < occurs in strings only
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string make_page(std::string_view title, const nlohmann::ordered_json& data) {
  if (kD3.empty()) {
    throw Error(
        "this build of Enfilade has no D3, which draws the report: install node-d3 and configure "
        "with -DEN_WITH_D3=ON");
  }
  const std::string nonce = random_nonce(), safe_title = draw::escape(title),
                    json = script_json(data);
  return fill(kPageHtml, {{{"nonce", nonce},
                           {"title", safe_title},
                           {"style", kPageStyle},
                           {"d3", kD3},
                           {"d3 licence", kD3Licence},
                           {"script", kPageScript},
                           {"data", json}}});
}

}  // namespace enfilade::report::parts
