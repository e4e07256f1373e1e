/// \file  The head of a request: its first line and its headers.
#pragma once
#include <cstddef>
#include <optional>
#include <string_view>

#include "enfilade/net/messages.h"

namespace enfilade::net::connections {

/// Whether a line has a control character other than a tab.
bool has_control(std::string_view line);

/// Finds the end of a head whose bytes arrive piece by piece. Looks at each byte once.
class HeadEnd {
 public:
  /// \param bytes those of the last call, and further ones
  /// \returns bytes of the head with its empty line; 0 if it is not complete
  /// \throws HttpError 400 for a line that does not end with CR LF, or a head beyond the limits;
  /// 414 for a first line beyond them
  std::size_t find(std::string_view bytes);

 private:
  std::size_t at_ = 0, line_ = 0, lines_ = 0;  // bytes so far, of the line; lines
};

/// What a head says.
struct Head {
  Request request;                    ///< without an address
  std::optional<std::size_t> length;  ///< of the body, if it is said
  bool chunked = false;               ///< the body is sent in chunks
  bool waits = false;                 ///< the client sends the body after "100 Continue"
  bool closes = false;                ///< the client wants no further response on this connection
  bool head_only = false;             ///< HEAD: the response has no body

  bool has_body() const { return chunked || length.value_or(0) > 0; }
};

/// \param text a head, as HeadEnd finds it
/// \throws HttpError 400, also where a proxy could see another end of the request; 414
Head parse_head(std::string_view text);

}  // namespace enfilade::net::connections
