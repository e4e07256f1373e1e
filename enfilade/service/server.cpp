#include "enfilade/service/server.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/service/detail/app.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/detail/transport.h"
#include "enfilade/service/detail/web_files.h"

namespace enfilade::service {

struct Server::Impl {
  detail::App app;
  detail::Transport transport;

  Impl(std::shared_ptr<const Site> site, const ServerConfig& config)
      : app(std::move(site), config), transport(app, config) {}
};

Server::Server(std::shared_ptr<const Site> site, const ServerConfig& config) {
  check_range("port", config.port, 0, 65535);
  check_range("threads", config.threads, 1, 4096);
  impl_ = std::make_unique<Impl>(std::move(site), config);
}

Server::~Server() = default;

int Server::port() const noexcept { return impl_->transport.port(); }

void Server::stop() { impl_->transport.stop(); }

bool has_web_client() noexcept { return !detail::web_files().empty(); }

std::string create_staff_token(const std::filesystem::path& database, StaffRole role,
                               const std::string& label, std::optional<int> days) {
  constexpr std::size_t kLongestLabel = 80;
  if (!detail::is_label(label, kLongestLabel)) {
    throw ArgumentError(
        fmt::format("label: {:?}, not 1 to {} printable characters", label, kLongestLabel));
  }
  detail::Database db(database);
  const std::int64_t now = detail::system_clock()();
  std::optional<std::int64_t> expires;
  if (days) expires = now + std::int64_t{*days} * 24 * 3600;
  const detail::Role kept =
      role == StaffRole::kOrganiser ? detail::Role::kOrganiser : detail::Role::kReviewer;
  return detail::add_staff(db, kept, label, now, expires);
}

void back_up_database(const std::filesystem::path& database, const std::filesystem::path& copy) {
  if (!std::filesystem::exists(database)) {
    throw FileError(fmt::format("{}: there is no such database", database.string()));
  }
  detail::back_up(database, copy);
}

}  // namespace enfilade::service
