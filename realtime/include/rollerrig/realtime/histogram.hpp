// realtime/histogram.hpp - how often a time was how long: written by one thread, read by any, never allocating.
//
//   durations [ns] -> [bins, 32 per octave] -> counts, quantiles within 1/32, the exact largest
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace rollerrig::realtime {

/// A counter of one writer: no locked instruction, and no torn value for those who look on.
class Counter {
 public:
  void add(std::uint64_t n = 1) { set(get() + n); }
  void set(std::uint64_t n) { value_.store(n, std::memory_order_relaxed); }
  std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

class Histogram {
 public:
  static constexpr int per_octave = 32;
  static constexpr int octaves = 36;  ///< up to 2^40 ns, 18 minutes; what is longer is counted as that

  void add(std::int64_t ns) {
    auto const v = static_cast<std::uint64_t>(std::clamp<std::int64_t>(ns, 0, longest));
    bin_[index_of(v)].add();
    count_.add();
    if (v > largest_.get()) largest_.set(v);
  }

  std::uint64_t count() const { return count_.get(); }
  std::uint64_t largest() const { return largest_.get(); }  ///< [ns]
  std::uint64_t in_bin(std::size_t i) const { return bin_[i].get(); }
  static constexpr std::size_t bins() { return static_cast<std::size_t>(per_octave * octaves); }
  /// First duration beyond a bin [ns].
  static constexpr std::uint64_t upper_edge(std::size_t i) {
    auto const n = static_cast<std::uint64_t>(per_octave);
    return i < n ? i + 1 : ((i % n) + n + 1) << (i / n - 1);
  }

  /// Duration that a part q of all does not exceed, by at most 1/32 too long [ns]; 0 without any.
  std::uint64_t quantile(double q) const {
    std::uint64_t const all = count();
    if (all == 0) return 0;
    double const wanted = q * static_cast<double>(all);
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < bins(); ++i) {
      seen += in_bin(i);
      if (seen > 0 && static_cast<double>(seen) >= wanted) return std::min(upper_edge(i), largest());
    }
    return largest();
  }

 private:
  static constexpr std::int64_t longest = (std::int64_t{1} << 40) - 1;
  static constexpr std::size_t index_of(std::uint64_t v) {
    if (v < per_octave) return static_cast<std::size_t>(v);
    int const shift = std::bit_width(v) - 6;
    return static_cast<std::size_t>((shift + 1) * per_octave) + static_cast<std::size_t>(v >> shift) - per_octave;
  }

  std::array<Counter, static_cast<std::size_t>(per_octave* octaves)> bin_{};
  Counter count_{}, largest_{};
};

}  // namespace rollerrig::realtime
