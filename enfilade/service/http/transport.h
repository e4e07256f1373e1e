/// \file  Passes requests to an App, by cpp-httplib. Only its source, sockets/ and client.cpp see
/// cpp-httplib.
#pragma once
#include <memory>

#include "enfilade/service/http/app.h"

namespace enfilade::service::http {

class Transport {
 public:
  /// Binds, and serves on threads of its own. \pre app outlives *this
  /// \throws ArgumentError if the address can't be bound
  Transport(App& app, const ServerConfig& config);
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  int port() const noexcept;
  void stop();  ///< returns when the running requests are answered

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::service::http
