// fmu/handles.hpp - what this library has given out, instances and saved states: a pointer that is none of them is an error, no crash.
//
//   object -> [handles] -> handle of C -> [handles] -> object, or none
#pragma once
#include <algorithm>
#include <memory>
#include <mutex>
#include <vector>

namespace rollerrig::fmu {

/// Calls on one instance come one after the other, as the standards ask; those on several may come together.
template <class Object>
class Handles {
 public:
  Object* keep(std::unique_ptr<Object> object) {
    std::scoped_lock const lock(mutex_);
    return all_.emplace_back(std::move(object)).get();
  }
  /// Null: freed, or never given out.
  Object* find(void const* handle) {
    std::scoped_lock const lock(mutex_);
    auto const found = place(handle);
    return found == all_.end() ? nullptr : found->get();
  }
  void free(void const* handle) {
    std::unique_ptr<Object> last;  // ends after the lock
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
  std::vector<std::unique_ptr<Object>> all_;
};

}  // namespace rollerrig::fmu
