#include "enfilade/net/connections/lobby.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

#include "enfilade/net/connections/body.h"
#include "enfilade/net/connections/response_text.h"
#include "enfilade/net/hosts.h"

namespace enfilade::net::connections {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::duration<double> kHeadTime{10};
constexpr milliseconds kIdleTime{5'000};
constexpr milliseconds kQuietTime{2'000};  // without a byte of a client that is to leave
constexpr milliseconds kTick{100};         // between two looks at what has taken too long
constexpr std::size_t kMostGuests = 1024;
constexpr int kMostAtOnce = 64;  // connections that are accepted between two looks at the others
constexpr std::uint64_t kListening = 0, kWaker = 1;  // no guests' numbers

Clock::duration in_ticks(std::chrono::duration<double> time) {
  return std::chrono::duration_cast<Clock::duration>(time);
}

/// Leaves a quarter of the process's descriptors for its files. The workers have one guest each;
/// were there more of them than descriptors, the guests that wait would still have some.
std::size_t most_guests(int workers) {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const rlim_t most = limit.rlim_cur / 4 * 3, held = static_cast<rlim_t>(workers);
  const rlim_t left = std::max(most > held ? most - held : 0, 1 + most / 4);
  return std::min<rlim_t>(kMostGuests, left);
}

/// The last entry of a list: of X-Forwarded-For the address that the proxy itself saw.
std::string last_entry(std::string_view header) {
  header = header.substr(header.rfind(',') + 1);  // without a comma npos + 1 = 0
  header.remove_prefix(std::min(header.find_first_not_of(" \t"), header.size()));
  return std::string(header);
}

std::string text_of(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> host{};
  const int failed = ::getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(),
                                   host.size(), nullptr, 0, NI_NUMERICHOST);
  return failed == 0 ? host.data() : "";
}

}  // namespace

Guest::~Guest() {
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
}

Lobby::Lobby(std::unique_ptr<Descriptor> listening, const ServerConfig& config)
    : config_(config),
      head_time_(in_ticks(std::min(kHeadTime, std::chrono::duration<double>(config.body_seconds)))),
      body_time_(in_ticks(std::chrono::duration<double>(config.body_seconds))),
      stop_time_(in_ticks(std::chrono::duration<double>(config.stop_seconds))),
      listening_(std::move(listening)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      waker_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      most_guests_(most_guests(config.threads)) {
  last_number_ = kWaker;
  if (!watch(listening_->number(), kListening) || !watch(waker_.number(), kWaker)) {
    throw Error("epoll: no room");
  }
  thread_ = std::thread([this] { run(); });
}

Lobby::~Lobby() { close(); }

void Lobby::close() {
  if (!closed_) overdue_at_ = Clock::now() + stop_time_;
  closed_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

bool Lobby::is_overdue() const noexcept { return closed_ && Clock::now() > overdue_at_; }

bool Lobby::watch(int socket, std::uint64_t number) const {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = number;
  return ::epoll_ctl(epoll_.number(), EPOLL_CTL_ADD, socket, &event) == 0;
}

void Lobby::wake() const {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t done = ::write(waker_.number(), &one, sizeof one);
}

std::unique_ptr<Guest> Lobby::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ended_ || !whole_.empty(); });
  if (whole_.empty()) return nullptr;
  auto guest = std::move(whole_.front());
  whole_.pop_front();
  return guest;
}

void Lobby::give_back(std::unique_ptr<Guest> guest, Stay stay) {
  {
    const std::scoped_lock lock(mutex_);
    if (ended_) return;
    returned_.push_back({std::move(guest), stay});
  }
  wake();
}

void Lobby::run() {
  std::array<epoll_event, 64> events{};
  auto next_look = Clock::now() + kTick;
  while (!closed_) {
    const int count = ::epoll_wait(epoll_.number(), events.data(), static_cast<int>(events.size()),
                                   static_cast<int>(kTick.count()));
    for (std::size_t k = 0; k < static_cast<std::size_t>(std::max(count, 0)); ++k) {
      const std::uint64_t number = events[k].data.u64;
      if (number == kListening) accept_some();
      std::uint64_t ignored = 0;
      if (number == kWaker && ::read(waker_.number(), &ignored, sizeof ignored) < 0) continue;
      const auto found = guests_.find(number);  // it may be gone meanwhile
      if (found == guests_.end()) continue;
      Guest& guest = *found->second;
      attempt(guest, [&] { receive(guest); });
    }
    take_back();
    give_seats();
    if (Clock::now() < next_look) continue;
    next_look = Clock::now() + kTick;
    end_waits();
  }
  listening_.reset();
  guests_.clear();
  const std::scoped_lock lock(mutex_);
  returned_.clear();
  ended_ = true;
  changed_.notify_all();
}

/// Does something for a guest. If that throws, as for want of memory, it costs this connection
/// alone.
template <class Step>
void Lobby::attempt(Guest& guest, const Step& step) {
  const std::uint64_t number = guest.number;
  try {
    step();
  } catch (...) {
    const auto found = guests_.find(number);
    if (found != guests_.end()) take_out(*found->second);
  }
}

/// Not all that wait: in a flood of them nothing else would be done.
void Lobby::accept_some() {
  for (int left = kMostAtOnce; left > 0; --left) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    const int socket = ::accept4(listening_->number(), reinterpret_cast<sockaddr*>(&address), &size,
                                 SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0) {
      const bool full = errno == EMFILE || errno == ENFILE;
      if (errno == EINTR || errno == ECONNABORTED || (full && drop_oldest())) continue;
      if (full) std::this_thread::sleep_for(kTick);  // the workers have all of them
      return;
    }
    const int on = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    std::unique_ptr<Guest> guest;
    try {
      guest = std::make_unique<Guest>(socket, text_of(address, size));
    } catch (const std::bad_alloc&) {
      ::close(socket);
      return;  // the next ones wait until there is memory
    }
    keep(std::move(guest));
  }
}

/// Requests that wait for a worker.
std::size_t Lobby::count_whole() {
  const std::scoped_lock lock(mutex_);
  return whole_.size();
}

/// Null where the system has no room.
Guest* Lobby::keep(std::unique_ptr<Guest> guest) {
  if (guests_.size() + count_whole() >= most_guests_) drop_oldest();
  Guest& kept = *guest;
  kept.number = ++last_number_;
  kept.state = Guest::State::kIdle;
  kept.end = Clock::now() + kIdleTime;
  if (!watch(kept.socket, kept.number)) return nullptr;
  try {
    guests_.emplace(kept.number, std::move(guest));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
  return &kept;
}

/// No longer reads the guest.
std::unique_ptr<Guest> Lobby::take_out(Guest& guest) {
  if (guest.state != Guest::State::kSeat) {
    ::epoll_ctl(epoll_.number(), EPOLL_CTL_DEL, guest.socket, nullptr);
  }
  seekers_.erase(guest.number);
  const auto found = guests_.find(guest.number);
  auto taken = std::move(found->second);
  guests_.erase(found);
  return taken;
}

bool Lobby::drop_oldest() {
  if (guests_.empty()) return false;
  take_out(*guests_.begin()->second);
  return true;
}

void Lobby::receive(Guest& guest) {
  std::array<char, 16U << 10U> piece;
  const ssize_t more = ::recv(guest.socket, piece.data(), piece.size(), MSG_DONTWAIT);
  if (more < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (more == 0 && guest.state == Guest::State::kBody) {
    return refuse(guest, HttpError(400, "the body broke off"));
  }
  if (more <= 0) {
    take_out(guest);
  } else if (guest.state == Guest::State::kLeaving) {
    guest.end = std::min(guest.latest, Clock::now() + kQuietTime);
  } else {
    guest.bytes.append(piece.data(), static_cast<std::size_t>(more));
    advance(guest);
  }
}

void Lobby::advance(Guest& guest) {
  using State = Guest::State;
  try {
    if (guest.state == State::kIdle && !guest.bytes.empty()) {
      guest.state = State::kHead;
      guest.head = {};  // it was of the last request
      guest.end = Clock::now() + head_time_;
    }
    if (guest.state == State::kHead) {
      const std::size_t size = guest.head_end.find(guest.bytes);
      if (size == 0) return;
      read_head(guest, size);
    }
    if (guest.state != State::kBody) return;
    const std::size_t length = guest.head.length.value_or(0);
    const bool small = !guest.head.chunked && !guest.head.waits && length <= kSmallBody;
    if (small && guest.bytes.size() < length) return;
    if (small && count_whole() >= (most_guests_ + 1) / 2) {
      throw HttpError(503, "too many requests at once; try again");
    }
    if (small) return give_to_worker(guest);
    ::epoll_ctl(epoll_.number(), EPOLL_CTL_DEL, guest.socket, nullptr);
    guest.state = State::kSeat;
    seekers_.insert(guest.number);
  } catch (const HttpError& error) {
    refuse(guest, error);
  }
}

void Lobby::read_head(Guest& guest, std::size_t size) const {
  guest.head = parse_head(std::string_view(guest.bytes).substr(0, size));
  guest.bytes.erase(0, size);
  guest.head_end = {};
  guest.state = Guest::State::kBody;
  guest.end = Clock::now() + body_time_;
  Request& request = guest.head.request;
  request.address = guest.address;
  if (config_.behind_proxy) {
    // What is no address stays the proxy's own: as an address of its own, each made-up text would
    // have limits of its own.
    auto client = parse_address(last_entry(request.header("x-forwarded-for")));
    if (client) request.address = std::move(*client);
  }
  const auto protocol = request.headers.find("x-forwarded-proto");
  if (protocol != request.headers.end()) protocol->second = last_entry(protocol->second);
  guest.group = address_group(request.address);
}

void Lobby::give_to_worker(Guest& guest) {
  auto taken = take_out(guest);
  const std::scoped_lock lock(mutex_);
  whole_.push_back(std::move(taken));
  changed_.notify_one();
}

void Lobby::give_seats() {
  const int most = std::max(1, config_.threads / 4 * 3);
  const int most_of_address = std::max(1, config_.threads / 2);
  for (auto at = seekers_.begin(); at != seekers_.end() && seats_taken_ < most;) {
    Guest& guest = *guests_.at(*at);
    ++at;
    int& taken = seats_[guest.group];
    if (taken >= most_of_address) continue;
    ++taken;
    ++seats_taken_;
    guest.seated = true;
    give_to_worker(guest);
  }
}

void Lobby::take_back() {
  std::vector<Returned> returned;
  {
    const std::scoped_lock lock(mutex_);
    returned.swap(returned_);
  }
  for (auto& [guest, stay] : returned) {
    if (std::exchange(guest->seated, false)) {
      --seats_taken_;
      if (const auto seats = seats_.find(guest->group); --seats->second == 0) seats_.erase(seats);
    }
    Guest* kept = keep(std::move(guest));
    if (kept == nullptr) continue;
    const bool stays = stay == Stay::kYes;
    attempt(*kept, [this, kept, stays] { stays ? advance(*kept) : leave(*kept); });
  }
}

void Lobby::end_waits() {
  const auto now = Clock::now();
  std::vector<Guest*> late;
  for (const auto& [number, guest] : guests_) {
    if (guest->end <= now) late.push_back(guest.get());
  }
  for (Guest* guest : late) {
    attempt(*guest, [this, guest] { end_wait(*guest); });
  }
}

void Lobby::end_wait(Guest& guest) {
  using State = Guest::State;
  switch (guest.state) {
    case State::kIdle:
    case State::kLeaving:
      take_out(guest);
      break;
    case State::kHead:
      refuse(guest, HttpError(408, "the head took too long"));
      break;
    case State::kBody:
      refuse(guest, HttpError(408, "the body took too long"));
      break;
    case State::kSeat:
      refuse(guest, HttpError(503, "too many large bodies at once; try again"));
      break;
  }
}

/// A refusal is so short that it needs no waiting.
void Lobby::refuse(Guest& guest, const HttpError& error) {
  const Response response = config_.refuse(error);
  std::string text = head_text(response, After::kCloses);
  if (!guest.head.head_only) text += *response.body;
  ::send(guest.socket, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (config_.refused) {
    Request& request = guest.head.request;
    if (request.address.empty()) request.address = guest.address;  // the head is not whole
    config_.refused(request, response);
  }
  leave(guest);
}

/// Reads and forgets what the client still sends. Closing at once would tell it that the connection
/// broke, and make it forget the response that it has not looked at.
void Lobby::leave(Guest& guest) {
  ::shutdown(guest.socket, SHUT_WR);
  if (guest.state == Guest::State::kSeat) {
    seekers_.erase(guest.number);
    watch(guest.socket, guest.number);
  }
  guest.state = Guest::State::kLeaving;
  guest.bytes = {};
  guest.latest = Clock::now() + body_time_;
  guest.end = std::min(guest.latest, Clock::now() + kQuietTime);
}

}  // namespace enfilade::net::connections
