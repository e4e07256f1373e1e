#include "enfilade/neural/ranks.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <torch/version.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <set>
#include <thread>
#include <utility>

#include "enfilade/neural/core/packing.h"
#ifdef EN_WITH_C10D
#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include "enfilade/neural/core/card_link.h"

#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>
#endif

namespace enfilade::neural {
namespace {

using namespace std::string_view_literals;
using std::chrono::milliseconds;
using std::chrono::seconds;

template <class T>
std::optional<T> number_of(const Variables& variables, const char* name) {
  const char* const text = variables(name);
  if (text == nullptr) return std::nullopt;
  T value{};
  const char* const end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, value);
  if (error != std::errc() || stop != end || value < 0) {
    throw ArgumentError(fmt::format("{}={}: a whole number from 0 is expected", name, text));
  }
  return value;
}

template <class T>
T require(const Variables& variables, const char* name, const char* launcher) {
  const auto value = number_of<T>(variables, name);
  if (!value) {
    throw ArgumentError(
        fmt::format("{}: the variable {} is not set, by which processes find each "
                    "other",
                    launcher, name));
  }
  return *value;
}

std::string text_of(const Variables& variables, const char* name, std::string otherwise = {}) {
  const char* const text = variables(name);
  return text != nullptr ? text : std::move(otherwise);
}

RankPlace checked(RankPlace place) {
  if (place.size < 1 || place.rank >= place.size) {
    throw ArgumentError(fmt::format("{}: rank {} of {} processes; ranks are from 0 to one less",
                                    place.launcher, place.rank, place.size));
  }
  place.local_size = std::max(place.local_size, 1);
  return place;
}

std::uint16_t some_port(std::uint64_t number) {
  constexpr std::uint64_t kFirst = 20'000, kPorts = 12'000;  // below those that Linux gives away
  return static_cast<std::uint16_t>(kFirst + number % kPorts);
}

constexpr std::uint64_t kAttempts = 7919;  // between the ports of attempts: a prime

std::optional<RankPlace> place_of_torchrun(const Variables& variables) {
  const auto rank = number_of<int>(variables, "RANK");
  const auto size = number_of<int>(variables, "WORLD_SIZE");
  if (!rank || !size) return std::nullopt;
  RankPlace place{.rank = *rank, .size = *size, .launcher = "torchrun"};
  place.local_rank = number_of<int>(variables, "LOCAL_RANK").value_or(0);
  place.local_size = number_of<int>(variables, "LOCAL_WORLD_SIZE").value_or(1);
  place.host = text_of(variables, "MASTER_ADDR");
  if (place.host.empty() && place.size > 1) {
    throw ArgumentError(
        "RANK and WORLD_SIZE are set, but MASTER_ADDR is not: the machine of rank 0");
  }
  if (place.size == 1) return place;
  place.port = require<std::uint16_t>(variables, "MASTER_PORT", "torchrun");
  if (text_of(variables, "TORCHELASTIC_USE_AGENT_STORE") == "True") {
    // That port is taken by torchrun's own store, which another version of libtorch cannot speak
    // with. An attempt after a failure has a port of its own.
    const auto attempt = number_of<unsigned>(variables, "TORCHELASTIC_RESTART_COUNT").value_or(0);
    place.port = some_port(place.port + kAttempts * (attempt + 1));
  }
  return checked(std::move(place));
}

// A default port for a run: other runs of its computer have other numbers.
std::uint16_t port_for(const Variables& variables, std::uint64_t run) {
  const auto named = number_of<std::uint16_t>(variables, "MASTER_PORT");
  return named.value_or(some_port(run));
}

struct MpiNames {
  const char *rank, *size, *local_rank, *local_size;
};
constexpr std::array<MpiNames, 2> kMpi{{
    {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_RANK",
     "OMPI_COMM_WORLD_LOCAL_SIZE"},
    {"PMI_RANK", "PMI_SIZE", "MPI_LOCALRANKID", "MPI_LOCALNRANKS"},
}};

std::optional<RankPlace> place_of_mpi(const Variables& variables, const MpiNames& names) {
  const auto rank = number_of<int>(variables, names.rank);
  const auto size = number_of<int>(variables, names.size);
  if (!rank || !size) return std::nullopt;
  RankPlace place{.rank = *rank, .size = *size, .launcher = "mpirun"};
  place.local_rank = number_of<int>(variables, names.local_rank).value_or(*rank);
  place.local_size = number_of<int>(variables, names.local_size).value_or(*size);
  place.host = text_of(variables, "MASTER_ADDR");
  if (place.host.empty()) {
    if (place.local_size < place.size) {
      throw ArgumentError(
          "mpirun: processes of several machines find each other by MASTER_ADDR, the machine of "
          "rank 0: mpirun -x MASTER_ADDR=HOST ...");
    }
    place.host = "127.0.0.1";
  }
  place.port = port_for(variables, static_cast<std::uint64_t>(getppid()));
  return checked(std::move(place));
}

std::optional<RankPlace> place_of_slurm(const Variables& variables) {
  // A batch script has a rank and a number of tasks, too, but no step of its own.
  const auto size = number_of<int>(variables, "SLURM_STEP_NUM_TASKS");
  const auto rank = number_of<int>(variables, "SLURM_PROCID");
  const auto step = number_of<std::uint64_t>(variables, "SLURM_STEP_ID");
  if (!size || !rank || !step || *size < 2) return std::nullopt;
  RankPlace place{.rank = *rank, .size = *size, .launcher = "srun"};
  place.local_rank = number_of<int>(variables, "SLURM_LOCALID").value_or(0);
  const std::string nodes = text_of(variables, "SLURM_STEP_NODELIST");
  // "4(x2)" or "4,3": tasks of each machine. Only their order of size is wanted, for threads.
  const std::string tasks = text_of(variables, "SLURM_STEP_TASKS_PER_NODE", "1");
  std::from_chars(tasks.data(), tasks.data() + tasks.size(), place.local_size);
  place.host = text_of(variables, "MASTER_ADDR", first_host(nodes));
  if (place.host.empty()) {
    throw ArgumentError("srun: neither SLURM_STEP_NODELIST nor MASTER_ADDR names a machine");
  }
  const auto job = number_of<std::uint64_t>(variables, "SLURM_JOB_ID").value_or(0);
  place.port = port_for(variables, 64 * job + *step);
  return checked(std::move(place));
}

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace

std::string first_host(std::string_view nodes) {
  const std::size_t bracket = nodes.find('['), comma = nodes.find(',');
  if (bracket == std::string_view::npos || comma < bracket) {
    return std::string(nodes.substr(0, comma));
  }
  const std::size_t end = nodes.find_first_of("-,]", bracket);
  return std::string(nodes.substr(0, bracket)) +
         std::string(nodes.substr(bracket + 1, end - bracket - 1));
}

std::optional<RankPlace> find_place(const Variables& variables) {
  if (auto place = place_of_torchrun(variables)) return place;
  for (const MpiNames& names : kMpi) {
    if (auto place = place_of_mpi(variables, names)) return place;
  }
  return place_of_slurm(variables);
}

#ifdef EN_WITH_C10D

namespace {

// The address of this machine on the way to another one. A machine's own name often leads to
// 127.0.1.1, which no other machine can reach, and a machine may have several networks.
std::string address_towards(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return {};
  std::string address;
  for (const addrinfo* one = found; one != nullptr && address.empty(); one = one->ai_next) {
    const int descriptor = socket(one->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0) continue;
    sockaddr_storage own{};
    socklen_t length = sizeof own;
    auto* const name = reinterpret_cast<sockaddr*>(&own);
    std::array<char, NI_MAXHOST> text{};
    if (connect(descriptor, one->ai_addr, one->ai_addrlen) == 0 &&
        getsockname(descriptor, name, &length) == 0 &&
        getnameinfo(name, length, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) == 0) {
      address = text.data();
    }
    close(descriptor);
  }
  freeaddrinfo(found);
  return address;
}

using Device = std::shared_ptr<::gloo::transport::Device>;

std::vector<Device> devices_for(const RankPlace& place) {
  std::vector<Device> devices;
  if (const char* const named = std::getenv("GLOO_SOCKET_IFNAME"); named != nullptr) {
    const std::string_view names(named);
    for (std::size_t begin = 0; begin <= names.size();) {
      const std::size_t end = std::min(names.find(',', begin), names.size());
      devices.push_back(c10d::ProcessGroupGloo::createDeviceForInterface(
          std::string(names.substr(begin, end - begin))));
      begin = end + 1;
    }
    return devices;
  }
  const std::string address = address_towards(place.host, place.port);
  devices.push_back(address.empty() ? c10d::ProcessGroupGloo::createDefaultDevice()
                                    : c10d::ProcessGroupGloo::createDeviceForHostname(address));
  return devices;
}

std::string key_of(const char* what, int rank) { return fmt::format("{}/{}", what, rank); }

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

// The first line of what c10d says; behind it are addresses of functions.
std::string first_line(const char* text) {
  const std::string_view all(text);
  return std::string(all.substr(0, all.find('\n')));
}

// Sets the options of a store. Newer versions of libtorch need another event loop than Debian has
// built theirs with.
template <class Options>
void plain_sockets(Options& options) {
  if constexpr (requires { options.useLibUV; }) options.useLibUV = false;
}

// \param place its rank 0 opens the store
c10::intrusive_ptr<c10d::TCPStore> store_of(const RankPlace& place, milliseconds timeout) {
  c10d::TCPStoreOptions options;
  options.port = place.port;
  options.isServer = place.rank == 0;
  options.waitWorkers = false;
  options.timeout = timeout;
  plain_sockets(options);
  return c10::make_intrusive<c10d::TCPStore>(place.host, options);
}

}  // namespace

struct Ranks::Impl {
  RankPlace place;
  milliseconds timeout{};
  c10::intrusive_ptr<c10d::Store> store;
  c10::intrusive_ptr<c10d::ProcessGroupGloo> group;
  std::unique_ptr<core::CardLink> cards;
  std::vector<std::string> names;  // "rank 2 (host, process 123)", by rank
  bool told = false;

  bool alone() const noexcept { return place.size == 1; }
  bool sends_by_cards(const at::Tensor& tensor) const { return cards && !tensor.is_cpu(); }

  void connect() {
    try {
      store = c10::make_intrusive<c10d::PrefixStore>("enfilade", store_of(place, timeout));
    } catch (const std::exception& error) {
      throw ArgumentError(
          fmt::format("rank {}: the store at {}:{}, by which the processes of {} find each other, "
                      "cannot be {}: {}",
                      place.rank, place.host, place.port, place.launcher,
                      place.rank == 0 ? "opened" : "reached", first_line(error.what())));
    }
    guarded([this] {
      const std::string own = fmt::format("rank {} ({}, process {})", place.rank, host_name(),
                                          static_cast<long>(getpid()));
      store->set(key_of("name", place.rank), bytes_of(own));
      for (int k = 0; k < place.size; ++k) {
        names.push_back(fmt::format("rank {}", k));
        const std::vector<std::uint8_t> name = store->get(key_of("name", k));
        names.back().assign(name.begin(), name.end());
      }
      const auto gloo = c10d::ProcessGroupGloo::Options::create(timeout);
      gloo->devices = devices_for(place);
      gloo->threads = 2;
      group = c10::make_intrusive<c10d::ProcessGroupGloo>(store, place.rank, place.size, gloo);
    });
  }

  // Calls what waits for the others. \throws LostRank
  template <class Call>
  void guarded(const Call& call) {
    try {
      call();
    } catch (const LostRank&) {
      throw;
    } catch (const std::exception& error) {
      const std::string reason = first_line(error.what());
      // Whoever waits for this rank has to notice now, while the store is there to be asked.
      group.reset();
      cards.reset();
      throw LostRank(fmt::format("rank {}: {}", place.rank, who_is_missing(reason)));
    }
  }

  // Who has died is not what Gloo says: it names an address, and a rank that ends for this reason
  // closes connections, too. So all that live leave a word in the store; who left none is missing.
  std::string who_is_missing(const std::string& reason) noexcept {
    constexpr milliseconds kPatience{3000}, kPause{20};
    try {
      if (store == nullptr) return reason;
      store->setTimeout(milliseconds(2000));
      store->set(key_of("alive", place.rank), bytes_of("1"));
      std::set<int> silent, failed;
      for (int k = 0; k < place.size; ++k) silent.insert(k);
      const auto end = std::chrono::steady_clock::now() + kPatience;
      while (!silent.empty() && std::chrono::steady_clock::now() < end) {
        for (int k = 0; k < place.size; ++k) {
          if (!silent.contains(k)) continue;
          if (store->check({key_of("failed", k)})) {
            failed.insert(k);
            silent.erase(k);
          } else if (store->check({key_of("alive", k)})) {
            silent.erase(k);
          }
        }
        if (!failed.empty()) break;
        std::this_thread::sleep_for(kPause);
      }
      std::vector<std::string> said;
      for (const int k : failed) {
        const auto why = store->get(key_of("failed", k));
        said.push_back(fmt::format("{} failed: {}", name(k), std::string(why.begin(), why.end())));
      }
      if (failed.empty()) {
        for (const int k : silent) {
          said.push_back(fmt::format("{} has died or does not answer", name(k)));
        }
      }
      // The store goes with the process that has it, so that one leaves last.
      if (place.rank == 0) std::this_thread::sleep_for(milliseconds(500));
      if (said.empty()) return fmt::format("the connection to the others broke: {}", reason);
      return fmt::format("{}; begin again to go on from the last checkpoint",
                         fmt::join(said, "; "));
    } catch (const std::exception&) {
      return fmt::format("{} has died, with the store by which ranks find each other", name(0));
    }
  }

  std::string name(int rank) const {
    const auto k = static_cast<std::size_t>(rank);
    return k < names.size() ? names[k] : fmt::format("rank {}", rank);
  }
};

Ranks::Ranks(const RankPlace& place, seconds timeout) : Ranks() {
  impl_->place = place;
  impl_->timeout = timeout;
  if (!alone()) impl_->connect();
}

namespace core {

void connect_cards(Ranks& ranks, c10::Device card) {
  Ranks::Impl& impl = ranks.implementation();
  if (impl.alone() || impl.cards) return;
  const std::string identity = identity_of_card(card);
  const char* const wanted = std::getenv("ENFILADE_NCCL");
  const bool without = identity.empty() || (wanted != nullptr && wanted == "0"sv);
  const std::vector<std::string> all = ranks.gather(without ? "" : identity);
  const std::set<std::string> cards(all.begin(), all.end());
  if (cards.contains("") || cards.size() != all.size()) return;
  try {
    impl.cards = link_cards(c10::make_intrusive<c10d::PrefixStore>("cards", impl.store),
                            impl.place.rank, impl.place.size, card, impl.timeout);
  } catch (const std::exception& error) {
    throw Error(fmt::format(
        "rank {}: the cards cannot be connected by {}: {}; with ENFILADE_NCCL=0 gradients go "
        "through the processor's memory",
        impl.place.rank, nccl_version(), first_line(error.what())));
  }
}

at::Tensor exchange(Ranks& ranks, const at::Tensor& given) {
  Ranks::Impl& impl = ranks.implementation();
  if (impl.sends_by_cards(given)) {
    at::Tensor received = at::empty_like(given);
    impl.guarded([&] { impl.cards->exchange(given, received); });
    return received;
  }
  at::Tensor in = given.cpu(), received = at::empty_like(in);
  impl.guarded([&] {
    std::vector<std::int64_t> equal;
    impl.group->alltoall_base(received, in, equal, equal)->wait();
  });
  return received.to(given.device());
}

void collect(Ranks& ranks, const at::Tensor& given, const at::Tensor& out) {
  Ranks::Impl& impl = ranks.implementation();
  if (impl.sends_by_cards(given)) {
    return impl.guarded([&] { impl.cards->collect(given, out); });
  }
  const at::Tensor all = out.is_cpu() ? out : at::empty_like(out, at::TensorOptions(at::kCPU));
  impl.guarded([&] {
    std::vector<std::vector<at::Tensor>> outputs{all.view({ranks.size(), given.numel()}).unbind(0)};
    std::vector<at::Tensor> inputs{given.cpu()};
    impl.group->allgather(outputs, inputs)->wait();
  });
  if (!out.is_cpu()) out.copy_(all);
}

void add_up(Ranks& ranks, const at::Tensor& values) {
  Ranks::Impl& impl = ranks.implementation();
  if (impl.sends_by_cards(values)) {
    return impl.guarded([&] { impl.cards->add_up(values); });
  }
  std::vector<at::Tensor> all{values.cpu()};
  impl.guarded([&] { impl.group->allreduce(all)->wait(); });
  if (!values.is_cpu()) values.copy_(all.front());
}

}  // namespace core

void Ranks::tell_failure(std::string_view why) noexcept {
  if (alone() || impl_->store == nullptr || std::exchange(impl_->told, true)) return;
  try {
    impl_->store->setTimeout(milliseconds(2000));
    impl_->store->set(key_of("failed", rank()), bytes_of(why));
    // The store of rank 0 is there for long enough that the others read this.
    if (rank() == 0) std::this_thread::sleep_for(seconds(1));
  } catch (const std::exception&) {  // then the others say that this one has died
  }
}

RanksReport examine_ranks() {
  try {
    RankPlace here;
    here.host = "127.0.0.1";
    store_of(here, seconds(5))->set("doctor", bytes_of("works"));
    c10d::ProcessGroupGloo::createDeviceForHostname(here.host);
    const std::string nccl = core::nccl_version();
    return {true, fmt::format("c10d's Gloo, of libtorch {}{}", TORCH_VERSION,
                              nccl.empty() ? "" : ", and cards by " + nccl)};
  } catch (const std::exception& error) {
    return {false, first_line(error.what())};
  }
}

#else

struct Ranks::Impl {
  RankPlace place;
};

Ranks::Ranks(const RankPlace& place, seconds /*timeout*/) : Ranks() {
  if (place.size > 1) {
    throw Error(fmt::format("{} started {} processes, but {}", place.launcher, place.size,
                            examine_ranks().text));
  }
}

namespace core {
void connect_cards(Ranks& /*ranks*/, c10::Device /*card*/) {}
at::Tensor exchange(Ranks& /*ranks*/, const at::Tensor& given) { return given; }
void collect(Ranks& /*ranks*/, const at::Tensor& given, const at::Tensor& out) {
  out.copy_(given.view_as(out));
}
void add_up(Ranks& /*ranks*/, const at::Tensor& /*values*/) {}
}  // namespace core

void Ranks::tell_failure(std::string_view /*why*/) noexcept {}

RanksReport examine_ranks() {
  return {false,
          "this build was made without Gloo's headers (Debian: libgloo-dev), so that it trains in "
          "one process"};
}

#endif

Ranks::Ranks() : impl_(std::make_unique<Impl>()) {}
Ranks::~Ranks() = default;
Ranks::Ranks(Ranks&&) noexcept = default;
Ranks& Ranks::operator=(Ranks&&) noexcept = default;

int Ranks::rank() const noexcept { return impl_->place.rank; }
int Ranks::size() const noexcept { return impl_->place.size; }

std::size_t usual_parts(int processes) {
  constexpr std::size_t kUsual = 8;
  auto parts = static_cast<std::size_t>(processes);
  while (parts < kUsual) parts *= 2;
  return parts;
}

void Ranks::meet() {
  if (!alone()) gather({});
}

std::vector<std::string> Ranks::gather(std::string_view bytes) {
  if (alone()) return {std::string(bytes)};
  // Lengths first, then all, padded to the longest.
  const at::Tensor length = at::full({1}, static_cast<std::int64_t>(bytes.size()), at::kLong);
  const at::Tensor lengths = at::empty({size()}, at::kLong);
  core::collect(*this, length, lengths);
  const std::int64_t longest = lengths.max().item<std::int64_t>();
  std::vector<std::string> all(static_cast<std::size_t>(size()));
  if (longest == 0) return all;
  const at::Tensor own = at::zeros({longest}, at::kByte);
  std::memcpy(own.data_ptr<std::uint8_t>(), bytes.data(), bytes.size());
  const at::Tensor padded = at::empty({size() * longest}, at::kByte);
  core::collect(*this, own, padded);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto* const begin =
        padded.data_ptr<std::uint8_t>() + static_cast<std::int64_t>(k) * longest;
    all[k].assign(begin, begin + lengths.data_ptr<std::int64_t>()[k]);
  }
  return all;
}

void Ranks::agree(const RankFacts& facts) {
  if (alone()) return;
  core::ValuePacker packer;
  for (const auto& [name, value] : facts) {
    packer.add(name);
    packer.add(value);
  }
  const auto unpacked = [](std::string_view bytes) {
    RankFacts found;
    for (core::Unpacker unpacker(bytes); !unpacker.done();) {
      auto name = unpacker.get<std::string>();
      found[std::move(name)] = unpacker.get<std::string>();
    }
    return found;
  };
  const std::vector<std::string> all = gather(packer.take());
  const RankFacts first = unpacked(all.front());
  std::vector<std::string> differ;
  for (std::size_t k = 1; k < all.size(); ++k) {
    const RankFacts own = unpacked(all[k]);
    std::set<std::string> names;
    for (const RankFacts& one : {first, own}) {
      for (const auto& [name, value] : one) names.insert(name);
    }
    const auto value_in = [](const RankFacts& one, const std::string& name) {
      const auto found = one.find(name);
      return found != one.end() ? found->second : std::string("none");
    };
    for (const std::string& name : names) {
      const std::string is = value_in(own, name), was = value_in(first, name);
      if (is != was) differ.push_back(fmt::format("rank {}: {}: {}, not {}", k, name, is, was));
    }
  }
  if (differ.empty()) return;
  constexpr std::size_t kMost = 20;
  const std::size_t more = differ.size() - std::min(differ.size(), kMost);
  differ.resize(differ.size() - more);
  if (more > 0) differ.push_back(fmt::format("and {} more", more));
  throw ArgumentError(
      fmt::format("the processes of this run are not alike; rank 0 says otherwise:"
                  "\n  {}",
                  fmt::join(differ, "\n  ")));
}

}  // namespace enfilade::neural
