// fmu/live.hpp - the instances that this library has given out: a pointer that is none of them is an error, no crash.
//
//   Component -> [live] -> handle of C -> [live] -> Component, or none
#pragma once
#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

namespace rollerrig::fmu {

/// Calls on one instance come one after the other, as the standards ask; those on several may come together.
template <class Component>
class Live {
 public:
  Component* keep(std::unique_ptr<Component> component) {
    std::scoped_lock const lock(mutex_);
    return all_.emplace_back(std::move(component)).get();
  }
  /// Null: freed, or never given out.
  Component* find(void const* handle) {
    std::scoped_lock const lock(mutex_);
    auto const found = place(handle);
    return found == all_.end() ? nullptr : found->get();
  }
  void free(void const* handle) {
    std::unique_ptr<Component> last;  // ends after the lock
    std::scoped_lock const lock(mutex_);
    auto const found = place(handle);
    if (found == all_.end()) return;
    last = std::move(*found);
    all_.erase(found);
  }

 private:
  auto place(void const* handle) {
    return std::ranges::find(all_, handle, [](auto const& one) { return static_cast<void const*>(one.get()); });
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Component>> all_;
};

}  // namespace rollerrig::fmu
