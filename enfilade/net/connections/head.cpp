#include "enfilade/net/connections/head.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

#include "enfilade/core/numbers.h"
#include "enfilade/core/texts.h"

namespace enfilade::net::connections {
namespace {

constexpr std::size_t kMostHead = 64U << 10U;
constexpr std::size_t kLongestLine = 8U << 10U;
constexpr std::size_t kMostLines = 200;
constexpr std::size_t kLongestTarget = 2048;
constexpr std::size_t kMostDigits = 15;  // of a length

/// Methods, and whether their requests may have a body.
constexpr std::array<std::pair<std::string_view, bool>, 7> kMethods{{{"GET", false},
                                                                     {"HEAD", false},
                                                                     {"OPTIONS", false},
                                                                     {"POST", true},
                                                                     {"PUT", true},
                                                                     {"PATCH", true},
                                                                     {"DELETE", true}}};

bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }

bool is_token(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
  });
}

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text.substr(0, text.find_last_not_of(" \t") + 1);  // npos + 1 is 0
}

[[noreturn]] void refuse(const char* message) { throw HttpError(400, message); }

/// "GET /path?query HTTP/1.1". \returns whether it is HTTP/1.0
bool read_first_line(std::string_view line, Request& request) {
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) refuse("this is no request of HTTP");
  std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") refuse("HTTP/1.1 and HTTP/1.0 are known");
  if (target.size() > kLongestTarget) throw HttpError(414, "the path is too long");
  target = target.substr(0, target.find('#'));
  const bool has_form = target == "*" || target.starts_with('/');
  if (!has_form || target.find(' ') != std::string_view::npos) refuse("this is no path");
  request.method = line.substr(0, first);
  request.target = target;
  request.path = decode_percent(target.substr(0, target.find('?')));
  if (std::ranges::any_of(request.path, is_control)) refuse("the path has a control character");
  return version == "HTTP/1.0";
}

void read_header(std::string_view line, Texts& headers) {
  const std::size_t colon = std::min(line.find(':'), line.size());
  if (line.front() == ' ' || line.front() == '\t') refuse("a header goes on in a second line");
  if (colon == line.size() || !is_token(line.substr(0, colon))) {
    refuse("a line of the head is no header");
  }
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (has_control(value)) refuse("a header has a control character");
  // Lines of one name are one list (RFC 9110, 5.3): proxies may add theirs to the client's.
  const auto [at, added] = headers.emplace(lower_case(line.substr(0, colon)), value);
  if (!added) at->second.append(at->first == "cookie" ? "; " : ", ").append(value);
}

/// Where a proxy could see another end of the request than we do, an attacker could make it give
/// one client's response to another client.
void read_end(Head& head, bool may_have_body, bool old) {
  const auto& headers = head.request.headers;
  const auto length = headers.find("content-length");
  const auto coding = headers.find("transfer-encoding");
  constexpr const char* kUnclear = "it is not clear where this request ends";
  if (length != headers.end()) {
    const std::string& text = length->second;  // of two lines "3, 3"
    const bool digits = std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
    head.length = parse_number<std::size_t>(text);
    if (!digits || text.size() > kMostDigits || !head.length) refuse(kUnclear);
  }
  if (coding != headers.end()) {
    head.chunked = lower_case(coding->second) == "chunked";
    if (!head.chunked || head.length || old) refuse(kUnclear);
  }
  if (head.has_body() && !may_have_body) refuse(kUnclear);
}

}  // namespace

bool has_control(std::string_view line) {
  return std::ranges::any_of(line, [](char c) { return is_control(c) && c != '\t'; });
}

std::size_t HeadEnd::find(std::string_view bytes) {
  for (; at_ < bytes.size(); ++at_) {
    const char c = bytes[at_];
    const bool after_return = at_ > 0 && bytes[at_ - 1] == '\r';
    if ((c == '\n') != after_return) refuse("a line of the head does not end with CR LF");
    if (c == '\n') {
      if (line_ == 0) return at_ + 1;
      line_ = 0;
      if (++lines_ > kMostLines) refuse("the head has too many lines");
    } else if (c != '\r' && ++line_ > kLongestLine) {
      if (lines_ == 0) throw HttpError(414, "the path is too long");
      refuse("a line of the head is too long");
    }
    if (at_ >= kMostHead) refuse("the head is too long");
  }
  return 0;
}

Head parse_head(std::string_view text) {
  Head head;
  Request& request = head.request;
  const auto next_line = [&text] {
    const std::string_view line = text.substr(0, text.find("\r\n"));
    text.remove_prefix(std::min(line.size() + 2, text.size()));
    return line;
  };
  const bool old = read_first_line(next_line(), request);
  for (std::string_view line = next_line(); !line.empty(); line = next_line()) {
    read_header(line, request.headers);
  }
  const auto* method = std::ranges::find(kMethods, std::string_view(request.method),
                                         &std::pair<std::string_view, bool>::first);
  if (method == kMethods.end()) refuse("no such method");
  const auto host = request.headers.find("host");
  const bool named = host != request.headers.end();
  if (named ? host->second.empty() || host->second.find(',') != std::string::npos : !old) {
    refuse("Host: must be there, once");
  }
  read_end(head, method->second, old);
  const std::string connection = lower_case(request.header("connection"));
  head.closes = old || connection.find("close") != std::string::npos;
  head.waits = !old && head.has_body() && lower_case(request.header("expect")) == "100-continue";
  head.head_only = request.method == "HEAD";
  if (head.head_only) request.method = "GET";
  return head;
}

}  // namespace enfilade::net::connections
