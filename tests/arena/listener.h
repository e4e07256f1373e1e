/// \file  A small HTTP server that keeps the requests to it.
#pragma once
#include <httplib.h>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace enfilade::tests {

/// Answers each request alike, or by a function. Also as a proxy, whose requests have whole
/// addresses. Set its fields before the first request.
class Listener {
 public:
  explicit Listener(std::unique_ptr<httplib::Server> server = std::make_unique<httplib::Server>())
      : server_(std::move(server)) {
    const auto reply = [this](const httplib::Request& request, httplib::Response& response) {
      const std::scoped_lock lock(mutex_);
      requests_.push_back(request);
      response.status = status;
      response.headers.insert(headers.begin(), headers.end());
      if (drips) return drip(response);
      response.set_content(answer ? answer(request) : body, type.c_str());
    };
    server_->Post(".*", reply);
    server_->Get(".*", reply);
    port = server_->bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_->listen_after_bind(); });
    while (!server_->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~Listener() {
    server_->stop();
    thread_.join();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::string host() const { return "http://127.0.0.1:" + std::to_string(port); }
  std::string url() const { return host() + "/v1"; }
  std::vector<httplib::Request> requests() const {
    const std::scoped_lock lock(mutex_);
    return requests_;
  }

  int status = 200, port = 0;
  bool drips = false;  // comments of a stream, for 5 seconds
  std::string body = "{}", type = "application/json";
  httplib::Headers headers;                                            // of each response
  std::function<std::string(const httplib::Request& request)> answer;  // in place of the body

 private:
  static void drip(httplib::Response& response) {
    response.set_chunked_content_provider(
        "text/event-stream", [k = 0](std::size_t, httplib::DataSink& sink) mutable {
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
          if (++k == 100) sink.done();
          return sink.write(": wait\n\n", 8);
        });
  }

  std::unique_ptr<httplib::Server> server_;
  mutable std::mutex mutex_;
  std::vector<httplib::Request> requests_;
  std::thread thread_;
};

}  // namespace enfilade::tests
