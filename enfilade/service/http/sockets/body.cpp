#include "enfilade/service/http/sockets/body.h"

#include <fmt/format.h>
#include <chrono>
#include <utility>

#include "enfilade/core/numbers.h"
#include "enfilade/core/gzip.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/messages.h"

namespace enfilade::service::http::sockets {
namespace {

// JSON packs to a tenth, and what is made for it to a thousandth. Below that many bytes the ratio
// is of no interest.
constexpr std::size_t kMostRatio = 200;
constexpr std::size_t kAnyRatio = 64U << 10U;
constexpr std::size_t kMedium = 1U << 20U;

}  // namespace

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

std::unique_lock<std::mutex> BodyRoom::wait_for_turn(std::size_t bytes) {
  return std::unique_lock(turns_[bytes > kMedium ? 1 : 0]);
}

Body::Body(httplib::Request& request, const httplib::ContentReader& reader, std::string address,
           BodyRoom& room, double seconds)
    : reader_(reader),
      room_(room),
      address_(std::move(address)),
      coding_(detail::lower_case(request.get_header_value("Content-Encoding"))),
      length_(parse_number<std::size_t>(request.get_header_value("Content-Length"))),
      seconds_(seconds) {
  request.headers.erase("Content-Encoding");
}

Body::~Body() { keep_room(0); }

void Body::take_room(std::size_t bytes) {
  if (!room_.take(address_, bytes)) {
    throw HttpError(503, "too many large bodies at once; try again");
  }
  taken_ += bytes;
}

void Body::keep_room(std::size_t bytes) {
  if (taken_ <= bytes) return;
  room_.give_back(address_, taken_ - bytes);
  taken_ = bytes;
}

// Gives the body's bytes to take(), as they are sent. What that throws ends it.
void Body::read_pieces(const std::function<void(std::string_view)>& take) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds_);
  const auto late = [end] { return std::chrono::steady_clock::now() > end; };
  whole_ = reader_([&](const char* data, std::size_t more) {
    if (late()) return false;
    take({data, more});
    return true;
  });
  if (whole_) return;
  if (late()) throw HttpError(408, "the body took too long");
  throw HttpError(400, "the body broke off");
}

// The same, unpacked.
void Body::read_packed(const std::function<void(std::string_view)>& take) {
  std::size_t packed = 0, unpacked = 0;
  Gunzip gunzip;
  const auto take_checked = [&](std::string_view piece) {
    unpacked += piece.size();
    if (unpacked > kAnyRatio && unpacked / kMostRatio > packed) {
      throw HttpError(413,
                      fmt::format("the body unpacks to more than {} times its size", kMostRatio));
    }
    take(piece);
  };
  try {
    read_pieces([&](std::string_view piece) {
      packed += piece.size();
      gunzip.add(piece, take_checked);
    });
  } catch (const HttpError&) {
    throw;
  } catch (const Error& error) {  // of gunzip
    throw HttpError(400, error.what());
  }
  if (!gunzip.ended()) throw HttpError(400, "the compressed body broke off");
}

std::string Body::read(std::size_t most) {
  begun_ = true;
  const bool plain = coding_.empty() || coding_ == "identity";
  if (!plain && coding_ != "gzip") {
    throw HttpError(415, "Content-Encoding: neither gzip nor identity");
  }
  const auto check = [most](std::size_t bytes) {
    if (bytes > most) throw HttpError(413, fmt::format("the body has more than {} bytes", most));
  };
  std::string body;
  const auto expect = [&](std::size_t bytes) {
    if (bytes <= kSmallBody) return;
    take_room(bytes);
    body.reserve(bytes);  // takes memory only where it is written to
  };
  if (plain && length_) {
    check(*length_);
    expect(*length_);
  }
  const auto take = [&](std::string_view piece) {
    const std::size_t size = body.size() + piece.size();
    check(size);
    // A body whose size is not known is expected to be the largest.
    if (size > kSmallBody && taken_ == 0) expect(most);
    body += piece;
  };
  if (plain) {
    read_pieces(take);
  } else {
    read_packed(take);
  }
  keep_room(body.size());
  if (body.size() > kSmallBody) turn_ = room_.wait_for_turn(body.size());
  return body;
}

bool Body::finish() {
  if (!begun_ && coding_.empty() && length_ && *length_ <= kSmallBody) {
    try {
      read(kSmallBody);
    } catch (const HttpError&) {  // of no interest
    }
  }
  return whole_;
}

}  // namespace enfilade::service::http::sockets
