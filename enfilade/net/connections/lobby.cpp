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
constexpr std::uint64_t kListening = 0, kWaker = 1;  // no guests' numbers

Clock::duration in_ticks(std::chrono::duration<double> time) {
  return std::chrono::duration_cast<Clock::duration>(time);
}

/// Leaves a quarter of the process's descriptors for its files.
std::size_t most_guests() {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  return std::min<std::size_t>(kMostGuests, limit.rlim_cur / 4 * 3);
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

Lobby::Lobby(int listening, const ServerConfig& config)
    : config_(config),
      head_time_(in_ticks(std::min(kHeadTime, std::chrono::duration<double>(config.body_seconds)))),
      body_time_(in_ticks(std::chrono::duration<double>(config.body_seconds))),
      listening_(listening),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      waker_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      most_guests_(most_guests()) {
  last_number_ = kWaker;
  if (!watch(listening_, kListening) || !watch(waker_, kWaker)) throw Error("epoll: no room");
  thread_ = std::thread([this] { run(); });
}

Lobby::~Lobby() {
  close();
  ::close(epoll_);
  ::close(waker_);
}

void Lobby::close() {
  closed_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

bool Lobby::watch(int socket, std::uint64_t number) const {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = number;
  return ::epoll_ctl(epoll_, EPOLL_CTL_ADD, socket, &event) == 0;
}

void Lobby::wake() const {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t done = ::write(waker_, &one, sizeof one);
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
    const int count = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()),
                                   static_cast<int>(kTick.count()));
    for (std::size_t k = 0; k < static_cast<std::size_t>(std::max(count, 0)); ++k) {
      const std::uint64_t number = events[k].data.u64;
      if (number == kListening) accept_all();
      std::uint64_t ignored = 0;
      if (number == kWaker && ::read(waker_, &ignored, sizeof ignored) < 0) continue;
      const auto found = guests_.find(number);  // it may be gone meanwhile
      if (found != guests_.end()) receive(*found->second);
    }
    take_back();
    give_seats();
    if (Clock::now() < next_look) continue;
    next_look = Clock::now() + kTick;
    end_waits();
  }
  ::close(listening_);
  guests_.clear();
  const std::scoped_lock lock(mutex_);
  returned_.clear();
  ended_ = true;
  changed_.notify_all();
}

void Lobby::accept_all() {
  for (;;) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    const int socket = ::accept4(listening_, reinterpret_cast<sockaddr*>(&address), &size,
                                 SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0) {
      const bool full = errno == EMFILE || errno == ENFILE;
      if (errno == EINTR || errno == ECONNABORTED || (full && drop_oldest())) continue;
      if (full) std::this_thread::sleep_for(kTick);  // the workers have all of them
      return;
    }
    const int on = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    keep(std::make_unique<Guest>(socket, text_of(address, size)));
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
  guests_.emplace(kept.number, std::move(guest));
  return &kept;
}

/// No longer reads the guest.
std::unique_ptr<Guest> Lobby::take_out(Guest& guest) {
  if (guest.state != Guest::State::kSeat) {
    ::epoll_ctl(epoll_, EPOLL_CTL_DEL, guest.socket, nullptr);
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
    if (small && count_whole() >= most_guests_ / 2) {
      throw HttpError(503, "too many requests at once; try again");
    }
    if (small) return give_to_worker(guest);
    ::epoll_ctl(epoll_, EPOLL_CTL_DEL, guest.socket, nullptr);
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
    if (kept != nullptr) stay == Stay::kYes ? advance(*kept) : leave(*kept);
  }
}

void Lobby::end_waits() {
  using State = Guest::State;
  const auto now = Clock::now();
  std::vector<Guest*> late;
  for (const auto& [number, guest] : guests_) {
    if (guest->end <= now) late.push_back(guest.get());
  }
  for (Guest* guest : late) {
    switch (guest->state) {
      case State::kIdle:
      case State::kLeaving:
        take_out(*guest);
        break;
      case State::kHead:
        refuse(*guest, HttpError(408, "the head took too long"));
        break;
      case State::kBody:
        refuse(*guest, HttpError(408, "the body took too long"));
        break;
      case State::kSeat:
        refuse(*guest, HttpError(503, "too many large bodies at once; try again"));
        break;
    }
  }
}

/// A refusal is so short that it needs no waiting.
void Lobby::refuse(Guest& guest, const HttpError& error) {
  const Response response = config_.refuse(error);
  const std::string text = head_text(response, After::kCloses) + *response.body;
  ::send(guest.socket, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
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
