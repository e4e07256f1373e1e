/// \file  A cache of values that are expensive to make.
#pragma once
#include <cstddef>
#include <exception>
#include <functional>
#include <future>
#include <list>
#include <map>
#include <mutex>
#include <utility>

namespace enfilade::service::detail {

/// Makes a value at its first request; concurrent callers wait for it. Values are small and point
/// to large data. All functions may be called from any thread.
template <class Key, class Value>
class OnceCache {
 public:
  using Bytes = std::function<std::size_t(const Value&)>;

  /// \param most_bytes of all values; the least recently used is dropped first
  /// \param bytes of a value
  OnceCache(std::size_t most_bytes, Bytes bytes)
      : most_bytes_(most_bytes), bytes_of_(std::move(bytes)) {}

  /// The key's value, by `make()` if it is missing.
  /// \throws the errors of make(): waiting callers get them too, and later ones try again
  template <class Make>
  Value get(const Key& key, const Make& make) {
    std::promise<Value> promise;
    std::shared_future<Value> value;
    bool first = false;
    {
      const std::scoped_lock lock(mutex_);
      const auto found = entries_.find(key);
      first = found == entries_.end();
      if (first) {
        value = promise.get_future().share();
        by_use_.push_front(key);
        entries_.emplace(key, CachedValue{value, 0, by_use_.begin()});
      } else {
        value = found->second.value;
        by_use_.splice(by_use_.begin(), by_use_, found->second.use);
      }
    }
    if (!first) return value.get();
    try {
      Value made = make();
      promise.set_value(std::move(made));
      add_bytes(key, value.get());
    } catch (...) {
      promise.set_exception(std::current_exception());
      const std::scoped_lock lock(mutex_);
      const auto found = entries_.find(key);
      by_use_.erase(found->second.use);
      entries_.erase(found);
    }
    return value.get();
  }

 private:
  struct CachedValue {
    std::shared_future<Value> value;
    std::size_t bytes = 0;  // 0 while being made
    typename std::list<Key>::iterator use;
  };

  void add_bytes(const Key& key, const Value& value) {
    const std::scoped_lock lock(mutex_);
    CachedValue& entry = entries_.find(key)->second;
    entry.bytes = bytes_of_(value);
    bytes_ += entry.bytes;
    // Entries that are being made count as 0 bytes, and must stay until they are filled.
    for (auto use = by_use_.end(); bytes_ > most_bytes_ && use != by_use_.begin();) {
      const auto oldest = entries_.find(*--use);
      if (oldest->second.bytes == 0 || oldest->first == key) continue;
      bytes_ -= oldest->second.bytes;
      entries_.erase(oldest);
      use = by_use_.erase(use);
    }
  }

  std::size_t most_bytes_;
  Bytes bytes_of_;
  std::mutex mutex_;
  std::size_t bytes_ = 0;
  std::list<Key> by_use_;  // latest first
  std::map<Key, CachedValue> entries_;
};

}  // namespace enfilade::service::detail
