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
  std::string state;                    ///< "queued", "scored", "failed", "withdrawn"
  std::map<std::string, double> means;  ///< by metric; empty until scored, and where hidden
  std::vector<std::string> warnings;    ///< of the file; in the answer to submit() only
};

/// A team's connection to a server. Not thread-safe. Every function \throws InvalidInput with the
/// faults that the server found in a file; Error, naming the server, if it refuses the request for
/// another reason or can't be reached.
class Client {
 public:
  /// \param server "https://vln.example.org", "http://127.0.0.1:8080"; certificates are checked
  Client(std::string server, const std::string& token);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Submits a results file. Submitting the same file again changes nothing.
  SubmissionStatus submit(const std::string& phase, const std::string& method,
                          std::string_view results);
  SubmissionStatus status(std::int64_t submission);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::service
