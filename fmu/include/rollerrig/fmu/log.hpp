// fmu/log.hpp - what an FMU tells the tool that runs it.
//
//   what went wrong -> [log] -> the tool's callback
#pragma once
#include <cstdarg>
#include <cstdio>

namespace rollerrig::fmu {

/// What a call ends with, in both versions of the standard.
enum class Answer : int { ok, discard, error };

/// A callback of C, and what it is called with.
struct Log {
  void (*write)(void* owner, Answer answer, char const* text){nullptr};
  void* owner{nullptr};

  /// A line as printf would write it, cut to the buffer; gives the answer back.
  [[gnu::format(printf, 3, 4)]] Answer operator()(Answer answer, char const* format, ...) const {
    if (write == nullptr) return answer;
    char text[1024];
    std::va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    write(owner, answer, text);
    return answer;
  }
};

}  // namespace rollerrig::fmu
