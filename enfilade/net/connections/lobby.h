/// \file  Connections whose next request is on its way: one thread reads them all.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/mapped_file.h"
#include "enfilade/net/connections/head.h"
#include "enfilade/net/server.h"

namespace enfilade::net::connections {

using Clock = std::chrono::steady_clock;

/// A connection. Either the lobby has it, or a worker.
struct Guest {
  /// What it is waited for.
  enum class State : std::uint8_t {
    kIdle,     ///< for a request to begin
    kHead,     ///< for the end of its head
    kBody,     ///< for the end of its body, which is small
    kSeat,     ///< for a thread that may read its body
    kLeaving,  ///< for the client to close
  };

  Guest(int its_socket, std::string its_address)
      : socket(its_socket), address(std::move(its_address)) {}
  ~Guest();  ///< closes the socket
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

  int socket;
  std::string address;  ///< of the connection
  std::string bytes;    ///< received and not yet used; without the head once that is complete
  HeadEnd head_end;     ///< of `bytes`
  Head head;            ///< of the present request; empty until it is whole
  std::string group;    ///< of the client's address, for limits
  bool seated = false;  ///< whether it has a seat
  int answered = 0;     ///< requests
  std::uint64_t number = 0;
  State state = State::kIdle;
  Clock::time_point end;     ///< of the wait
  Clock::time_point latest;  ///< of kLeaving: end of all waits
};

/// Reads heads and small bodies of all connections on one thread, and gives whole requests to the
/// workers. A request whose body the worker has to wait for needs a seat: Server's documentation
/// says how many there are.
class Lobby {
 public:
  /// \param listening a bound socket that does not block
  /// \throws Error, std::system_error where the system has no room for descriptors or a thread
  /// \pre config outlives *this
  Lobby(std::unique_ptr<Descriptor> listening, const ServerConfig& config);
  ~Lobby();
  Lobby(const Lobby&) = delete;
  Lobby& operator=(const Lobby&) = delete;

  /// For workers: waits for the next request. Null: the lobby is closed.
  std::unique_ptr<Guest> next();
  enum class Stay : std::uint8_t { kYes, kNo };
  /// For workers: takes a connection back after a response.
  void give_back(std::unique_ptr<Guest> guest, Stay stay);
  /// Closes what waits. Requests that are whole are still given to workers.
  void close();
  bool is_closed() const noexcept { return closed_; }
  /// Whether it is closed for longer than responses may take.
  bool is_overdue() const noexcept;

 private:
  struct Returned {
    std::unique_ptr<Guest> guest;
    Stay stay;
  };

  void run();
  template <class Step>
  void attempt(Guest& guest, const Step& step);
  std::size_t count_whole();
  bool watch(int socket, std::uint64_t number) const;
  void wake() const;
  void accept_some();
  Guest* keep(std::unique_ptr<Guest> guest);
  std::unique_ptr<Guest> take_out(Guest& guest);
  bool drop_oldest();
  void receive(Guest& guest);
  void advance(Guest& guest);
  void read_head(Guest& guest, std::size_t size) const;
  void give_to_worker(Guest& guest);
  void give_seats();
  void take_back();
  void end_waits();
  void end_wait(Guest& guest);
  void refuse(Guest& guest, const HttpError& error);
  void leave(Guest& guest);

  const ServerConfig& config_;
  Clock::duration head_time_, body_time_, stop_time_;
  std::unique_ptr<Descriptor> listening_;  // null when it is closed
  Descriptor epoll_, waker_;
  std::size_t most_guests_;
  // Used by the lobby's thread alone:
  std::map<std::uint64_t, std::unique_ptr<Guest>> guests_;  // in the order of their arrival
  std::set<std::uint64_t> seekers_;                         // those that wait for a seat
  std::map<std::string, int> seats_;                        // taken, by address
  int seats_taken_ = 0;
  std::uint64_t last_number_ = 0;
  // Used by all threads:
  Clock::time_point overdue_at_;  // written before closed_, read after it
  std::atomic<bool> closed_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Guest>> whole_;
  std::vector<Returned> returned_;
  bool ended_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace enfilade::net::connections
