/// \file  What shared objects were opened with, so that other processes can open them again.
#pragma once
#include <map>
#include <memory>
#include <utility>

namespace enfilade::python {

/// Remembers a value for each object as long as that lives. Under the GIL.
template <class T, class Value>
class Origins {
 public:
  /// Remembers, and forgets those of objects that are gone.
  void put(const std::shared_ptr<const T>& object, Value value) {
    std::erase_if(known_, [](const auto& entry) { return entry.second.first.expired(); });
    known_.insert_or_assign(object.get(), std::pair(std::weak_ptr<const T>(object), value));
  }
  /// Null for an object that it does not know.
  const Value* find(const T& object) const {
    const auto found = known_.find(&object);
    const bool alive = found != known_.end() && !found->second.first.expired();
    return alive ? &found->second.second : nullptr;
  }

 private:
  std::map<const T*, std::pair<std::weak_ptr<const T>, Value>> known_;
};

}  // namespace enfilade::python
