/// \file  An environment that measures its own time.
#pragma once
#include <chrono>
#include <span>

#include "enfilade/neural/environment.h"

namespace enfilade::neural::detail {

/// Forwards all calls and adds up their time.
class TimedEnvironment : public Environment {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TimedEnvironment(Environment& inner) : inner_(inner) {}
  Clock::duration spent() const noexcept { return spent_; }

  std::size_t size() const override { return inner_.size(); }
  std::size_t dimensions() const override { return inner_.dimensions(); }
  bool has_teacher() const override { return inner_.has_teacher(); }
  std::span<const std::uint8_t> ended() const override { return inner_.ended(); }
  void observe(const EnvironmentView& out) override {
    const Clock::time_point begin = Clock::now();
    inner_.observe(out);
    spent_ += Clock::now() - begin;
  }
  bool step(std::span<const std::int32_t> actions) override {
    const Clock::time_point begin = Clock::now();
    const bool walking = inner_.step(actions);
    spent_ += Clock::now() - begin;
    return walking;
  }

 private:
  Environment& inner_;
  Clock::duration spent_{};
};

}  // namespace enfilade::neural::detail
