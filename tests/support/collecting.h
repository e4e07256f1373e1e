/// \file  A server with a clock of its own, and collections on it.
#pragma once
#include <gtest/gtest.h>
#include <atomic>
#include <string>

#include "tests/support/served_data.h"
#include "tests/support/worker.h"

namespace enfilade::service::testing {

class Collecting : public ::testing::Test {
 protected:
  /// Asks for a collection; key_ is its link's.
  nlohmann::json create(const nlohmann::json& body) {
    auto made = read_answer(
        served_.client().Post("/api/v1/collections", organiser_, body.dump(), "application/json"));
    if (made.contains("link")) key_ = key_of(made);
    return made;
  }
  /// Whom the link's query brings.
  Worker come(nlohmann::json parameters, const std::string& collection = "pilot") {
    parameters["key"] = key_;
    return {served_.port(), collection, parameters};
  }
  Worker worker(const std::string& name, const std::string& collection = "pilot") {
    return come({{"worker", name}}, collection);
  }
  nlohmann::json progress(const std::string& collection = "pilot") {
    return served_.json("/api/v1/collections/" + collection, organiser_).at("progress");
  }
  /// Of a reviewer or an organiser.
  nlohmann::json put(const std::string& target, const httplib::Headers& who,
                     const nlohmann::json& body) {
    return read_answer(served_.client().Put(target, who, body.dump(), "application/json"));
  }

  std::atomic<std::int64_t> now_{1'000'000};
  Served served_{config()};
  httplib::Headers organiser_ = served_.organiser();
  httplib::Headers reviewer_ = served_.staff(TokenRole::kReviewer);
  std::string key_;

 private:
  ServerConfig config() {
    ServerConfig config;
    config.clock = [this] { return now_.load(); };
    return config;
  }
};

}  // namespace enfilade::service::testing
