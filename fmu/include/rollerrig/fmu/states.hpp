// fmu/states.hpp - the saved states that an instance has given out: a pointer that is none of them is an error, no crash.
//
//   Instance -> [states] -> handles of C
#pragma once
#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "rollerrig/fmu/log.hpp"

namespace rollerrig::fmu {

class States {
 public:
  using Bytes = std::vector<std::byte>;

  /// Saves the instance; over the state that the handle names, if it names one.
  template <class Instance>
  Answer get(Instance& instance, char const* call, void** handle) {
    if (handle == nullptr) return instance.log(Answer::error, "%s: null pointer", call);
    return keep(handle, instance.save());
  }
  template <class Instance>
  Answer set(Instance& instance, char const* call, void* handle) {
    Bytes const* state = find(handle);
    if (state == nullptr) return unknown(instance, call);
    return instance.restore(call, *state);
  }
  /// Null, or a handle that names null: there is nothing to free.
  template <class Instance>
  Answer free(Instance& instance, char const* call, void** handle) {
    if (handle == nullptr || *handle == nullptr) return Answer::ok;
    if (find(*handle) == nullptr) return unknown(instance, call);
    std::erase_if(states_, [&](auto const& state) { return state.get() == *handle; });
    *handle = nullptr;
    return Answer::ok;
  }
  template <class Instance>
  Answer size(Instance& instance, char const* call, void* handle, std::size_t* size) {
    Bytes const* state = find(handle);
    if (state == nullptr || size == nullptr) return unknown(instance, call);
    *size = state->size();
    return Answer::ok;
  }
  template <class Instance>
  Answer write(Instance& instance, char const* call, void* handle, void* bytes, std::size_t size) {
    Bytes const* state = find(handle);
    if (state == nullptr || bytes == nullptr) return unknown(instance, call);
    if (size < state->size()) return instance.log(Answer::error, "%s: the state has %zu bytes", call, state->size());
    std::copy(state->begin(), state->end(), static_cast<std::byte*>(bytes));
    return Answer::ok;
  }
  template <class Instance>
  Answer read(Instance& instance, char const* call, void const* bytes, std::size_t size, void** handle) {
    if (bytes == nullptr || handle == nullptr) return instance.log(Answer::error, "%s: null pointer", call);
    auto const* begin = static_cast<std::byte const*>(bytes);
    if (!instance.is_state({begin, size}))
      return instance.log(Answer::error, "%s: these bytes are no saved state", call);
    return keep(handle, Bytes(begin, begin + size));
  }

 private:
  Bytes* find(void const* handle) const {
    for (auto const& state : states_)
      if (state.get() == handle) return state.get();
    return nullptr;
  }
  Answer keep(void** handle, Bytes bytes) {
    if (Bytes* old = find(*handle))
      *old = std::move(bytes);
    else
      *handle = states_.emplace_back(std::make_unique<Bytes>(std::move(bytes))).get();
    return Answer::ok;
  }
  template <class Instance>
  static Answer unknown(Instance& instance, char const* call) {
    return instance.log(Answer::error, "%s: that is no state of this instance", call);
  }

  std::vector<std::unique_ptr<Bytes>> states_;
};

}  // namespace rollerrig::fmu
