#include "enfilade/net/connections/body.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/core/texts.h"

namespace enfilade::net::connections {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kPiece = 16U << 10U;
constexpr std::size_t kLongestSizeLine = 8U << 10U;  // with the size of a chunk
constexpr milliseconds kPieceTime{5'000};  // between two pieces of a request, or of a response
constexpr milliseconds kSlice{500};        // of that time, between two questions whether to give up
// JSON packs to a tenth, and what is made for it to a thousandth. Below that many bytes the ratio
// is of no interest.
constexpr std::size_t kMostRatio = 200;
constexpr std::size_t kAnyRatio = 64U << 10U;

/// Unpacks a body as it is sent.
class Unpacking {
 public:
  /// Passes what comes out to take(). What that throws ends it.
  void add(std::string_view piece, const Gunzip::Take& take) {
    packed_ += piece.size();
    const auto take_checked = [&](std::string_view more) {
      unpacked_ += more.size();
      if (unpacked_ > kAnyRatio && unpacked_ / kMostRatio > packed_) {
        throw HttpError(413,
                        fmt::format("the body unpacks to more than {} times its size", kMostRatio));
      }
      take(more);
    };
    try {
      gunzip_.add(piece, take_checked);
    } catch (const HttpError&) {
      throw;
    } catch (const Error& error) {  // of gunzip_
      throw HttpError(400, error.what());
    }
  }
  void check_ended() const {
    if (!gunzip_.ended()) throw HttpError(400, "the compressed body broke off");
  }

 private:
  std::size_t packed_ = 0, unpacked_ = 0;
  Gunzip gunzip_;
};

}  // namespace

bool is_ready(int socket, short event, milliseconds time) {
  pollfd one{socket, event, 0};
  int ready = 0;
  do {
    ready = ::poll(&one, 1, static_cast<int>(std::max(time, milliseconds{0}).count()));
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

bool send_all(int socket, std::string_view text, const std::function<bool()>& gives_up) {
  auto end = std::chrono::steady_clock::now() + kPieceTime;
  while (!text.empty()) {
    const ssize_t sent = ::send(socket, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return false;
    if (sent > 0) {
      text.remove_prefix(static_cast<std::size_t>(sent));
      end = std::chrono::steady_clock::now() + kPieceTime;
      continue;
    }
    if (gives_up && gives_up()) return false;
    if (!is_ready(socket, POLLOUT, kSlice) && std::chrono::steady_clock::now() > end) return false;
  }
  return true;
}

bool BodyRoom::take(const std::string& address, std::size_t bytes) {
  const std::scoped_lock lock(mutex_);
  const auto own = by_address_.find(address);
  const std::size_t before = own == by_address_.end() ? 0 : own->second;
  if (bytes > kBodies * largest_ - taken_ || bytes > kBodiesOfAddress * largest_ - before) {
    return false;
  }
  taken_ += bytes;
  by_address_[address] = before + bytes;
  return true;
}

void BodyRoom::give_back(const std::string& address, std::size_t bytes) {
  const std::scoped_lock lock(mutex_);
  taken_ -= bytes;
  const auto own = by_address_.find(address);
  own->second -= bytes;
  if (own->second == 0) by_address_.erase(own);
}

RequestBody::RequestBody(int socket, const Head& head, std::string& bytes, std::string address,
                         BodyRoom& room, double seconds)
    : socket_(socket),
      head_(head),
      bytes_(bytes),
      address_(std::move(address)),
      coding_(lower_case(head.request.header("content-encoding"))),
      room_(room),
      end_(std::chrono::steady_clock::now() +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(
               std::chrono::duration<double>(seconds))) {}

RequestBody::~RequestBody() { keep_room(0); }

void RequestBody::take_room(std::size_t bytes) {
  if (!room_.take(address_, bytes)) {
    throw HttpError(503, "too many large bodies at once; try again");
  }
  taken_ += bytes;
}

void RequestBody::keep_room(std::size_t bytes) {
  if (taken_ <= bytes) return;
  room_.give_back(address_, taken_ - bytes);
  taken_ = bytes;
}

// Receives further bytes, behind those that are not used yet.
void RequestBody::receive() {
  bytes_.erase(0, std::exchange(used_, 0));
  const auto left =
      std::chrono::duration_cast<milliseconds>(end_ - std::chrono::steady_clock::now());
  if (left <= milliseconds{0} || !is_ready(socket_, POLLIN, std::min(left, kPieceTime))) {
    throw HttpError(408, "the body took too long");
  }
  const std::size_t before = bytes_.size();
  bytes_.resize(before + kPiece);
  const ssize_t more = ::recv(socket_, &bytes_[before], kPiece, MSG_DONTWAIT);
  const bool none_yet = more < 0 && (errno == EAGAIN || errno == EINTR);
  bytes_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(more, 0)));
  if (more <= 0 && !none_yet) throw HttpError(400, "the body broke off");
}

void RequestBody::pass_on(std::size_t size, const Take& take) {
  while (size > 0) {
    if (used_ == bytes_.size()) receive();
    const auto piece = std::string_view(bytes_).substr(used_, size);
    take(piece);
    used_ += piece.size();
    size -= piece.size();
  }
}

// Valid until the next bytes are received.
std::string_view RequestBody::read_line() {
  std::size_t end = 0;
  while ((end = bytes_.find('\n', used_)) == std::string::npos) {
    if (bytes_.size() - used_ > kLongestSizeLine)
      throw HttpError(400, "a line of the body is too long");
    receive();
  }
  const auto line = std::string_view(bytes_).substr(used_, end - used_);
  used_ = end + 1;
  if (!line.ends_with('\r')) throw HttpError(400, "a line of the body does not end with CR LF");
  const std::string_view content = line.substr(0, line.size() - 1);
  if (has_control(content)) throw HttpError(400, "a line of the body has a control character");
  return content;
}

void RequestBody::read_chunks(const Take& take) {
  constexpr std::size_t kSizeDigits = 8;
  constexpr int kMostTrailers = 20;
  for (;;) {
    const std::string_view line = read_line();
    const std::string_view digits = line.substr(0, line.find_first_of("; \t"));
    std::size_t size = 0;
    const char* const end = digits.data() + digits.size();
    if (digits.empty() || digits.size() > kSizeDigits ||
        std::from_chars(digits.data(), end, size, 16).ptr != end) {
      throw HttpError(400, "the size of a chunk is no hexadecimal number");
    }
    const std::size_t behind = line.find_first_not_of(" \t", digits.size());
    if (behind != std::string_view::npos && line[behind] != ';') {
      throw HttpError(400, "behind the size of a chunk is neither its end nor an extension");
    }
    if (size == 0) break;
    pass_on(size, take);
    if (!read_line().empty()) throw HttpError(400, "a chunk is longer than its size");
  }
  for (int left = kMostTrailers; !read_line().empty(); --left) {
    if (left == 0) throw HttpError(400, "too many lines behind the body");
  }
}

// Gives the body's bytes to take(), as they are sent. What that throws ends it.
void RequestBody::read_pieces(const Take& take) {
  if (head_.waits && !send_all(socket_, "HTTP/1.1 100 Continue\r\n\r\n")) {
    throw HttpError(400, "the body broke off");
  }
  if (head_.chunked) {
    read_chunks(take);
  } else {
    pass_on(head_.length.value_or(0), take);
  }
  whole_ = true;
}

std::string RequestBody::read(std::size_t most) {
  begun_ = true;
  const bool plain = coding_.empty() || coding_ == "identity";
  if (!plain && coding_ != "gzip") {
    throw HttpError(415, "Content-Encoding: neither gzip nor identity");
  }
  const auto check = [most](std::size_t bytes) {
    if (bytes > most) throw HttpError(413, fmt::format("the body has more than {} bytes", most));
  };
  std::string body;
  std::optional<Unpacking> packed;
  if (!plain) packed.emplace();
  const auto expect = [&](std::size_t bytes) {
    if (bytes <= kSmallBody) return;
    take_room(bytes - taken_);
    body.reserve(bytes);  // takes memory only where it is written to
  };
  if (plain && head_.length) {
    check(*head_.length);
    expect(*head_.length);
  }
  const auto take = [&](std::string_view piece) {
    const std::size_t size = body.size() + piece.size();
    check(size);
    // A body whose size is not known is expected to be the largest.
    if (size > kSmallBody && size > taken_) expect(most);
    body += piece;
  };
  read_pieces([&](std::string_view piece) {
    // A packed file whose header is missing, as of one that a person chose in a form.
    if (!packed && body.size() < kGzipMark.size() &&
        (body + std::string(piece.substr(0, kGzipMark.size()))).starts_with(kGzipMark)) {
      packed.emplace().add(std::exchange(body, {}), take);
    }
    if (packed) {
      packed->add(piece, take);
    } else {
      take(piece);
    }
  });
  if (packed) packed->check_ended();
  keep_room(body.size());
  return body;
}

bool RequestBody::finish() {
  if (!begun_ && head_.length && bytes_.size() >= *head_.length) {
    used_ = *head_.length;
    whole_ = true;
  }
  bytes_.erase(0, std::exchange(used_, 0));
  return whole_ || !head_.has_body();
}

}  // namespace enfilade::net::connections
