/// \file  The arguments with which shared objects were opened, for other processes to open them
/// again.
#pragma once
#include <map>
#include <memory>
#include <utility>

namespace enfilade::python {

/// Stores a value for each object, for its lifetime. Under the GIL.
template <class T, class Value>
class Origins {
 public:
  /// Stores a value, and removes those of destroyed objects.
  void put(const std::shared_ptr<const T>& object, Value value) {
    std::erase_if(known_, [](const auto& entry) { return entry.second.first.expired(); });
    known_.insert_or_assign(object.get(), std::pair(std::weak_ptr<const T>(object), value));
  }
  /// Null for an unknown object.
  const Value* find(const T& object) const {
    const auto found = known_.find(&object);
    const bool alive = found != known_.end() && !found->second.first.expired();
    return alive ? &found->second.second : nullptr;
  }

 private:
  std::map<const T*, std::pair<std::weak_ptr<const T>, Value>> known_;
};

}  // namespace enfilade::python
