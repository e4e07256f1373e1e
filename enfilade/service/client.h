/// \file  Client of an evaluation server: submits results files, as `enfilade submit` does.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::service {

/// A submission as the server reports it.
struct SubmissionStatus {
  std::int64_t id = 0;
  std::string phase, method;
  /// "queued", "scored", "failed", "withdrawn"; "received" if the server reports no more for now.
  std::string state;
  std::map<std::string, double> means;  ///< by metric; empty until scored, and if withheld
  /// Why there are no means, if the phase withholds them: "until-end", "no-improvement",
  /// "not-best", "hidden".
  std::string withheld;
  std::vector<std::string> warnings;  ///< of the file; in the answer to submit() only
};

/// A team's connection to a server. Not thread-safe.
///
/// Every function throws InvalidInput with the faults that the server found in a file. It throws
/// Error, naming the server, if the server can't be reached or refuses the request for another
/// reason. Too late and too large responses are errors, too: the limits are 16 MiB unpacked, and 17
/// MiB of all that comes.
class Client {
 public:
  /// \param server "https://vln.example.org", "http://127.0.0.1:8080"; certificates are checked
  /// \param seconds for a request and its response, beside a second for each 32 KiB to send
  Client(std::string server, const std::string& token, double seconds = 60);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Submits a results file. Submitting the same file again changes nothing. While the server has
  /// no room for it (status 503), waits for the time that the server asks for, and retries, 12
  /// times in all.
  SubmissionStatus submit(const std::string& phase, const std::string& method,
                          std::string_view results);
  SubmissionStatus status(std::int64_t submission);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::service
