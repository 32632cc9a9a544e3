// integrate/stiff_modes.hpp - combinations of its states that decay fast, and how fast, for now.
//
//   system -> [s_i = d_i . x,  s_i' = N_i - rate_i s_i,  x moves by u_i where s_i moves by 1] -> exponential methods
//
// d_i . u_j = 1 for i = j, else 0: the modes are independent of each other. The value that s_i decays to may itself change
// steadily, as with the speed of a rail under a braking train: at about the trend.
//
// Rate and trend need not be exact, N takes up the rest. A rate between 0.6 and any multiple of the true one keeps the method
// stable; the nearer, the more accurate.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace rollerrig {

class StiffModes {
 public:
  /// One state's part in a mode, or with d = 0 what a quadrature, behind the states, gains when s_i is moved.
  struct Entry {
    int place;  ///< of the state
    double d, u;
    void state(auto& archive) { archive(place, d, u); }
  };
  struct Mode {
    double rate;   ///< [1/s]
    double trend;  ///< of the value it decays to [unit of s_i over s]
    std::size_t first, count;
    void state(auto& archive) { archive(rate, trend, first, count); }
  };

  StiffModes() = default;
  /// Everything is allocated here.
  StiffModes(std::size_t most_modes, std::size_t most_entries, std::size_t longest_origin) {
    mode_.reserve(most_modes);
    entry_.reserve(most_entries);
    origin.reserve(longest_origin);
  }

  void clear() {
    mode_.clear();
    entry_.clear();
    origin.clear();
  }
  /// A mode without entries, to be followed by add() for each.
  void begin(double rate, double trend) { mode_.push_back({rate, trend, entry_.size(), 0}); }
  void add(int state, double d, double u) {
    entry_.push_back({state, d, u});
    ++mode_.back().count;
  }

  std::size_t size() const { return mode_.size(); }
  std::size_t capacity() const { return mode_.capacity(); }
  double rate(std::size_t i) const { return mode_[i].rate; }
  double trend(std::size_t i) const { return mode_[i].trend; }
  std::span<Entry const> entries(std::size_t i) const { return {entry_.data() + mode_[i].first, mode_[i].count}; }
  /// s of mode i.
  double along(std::size_t i, double const* x) const {
    double s = 0.0;
    for (Entry const& e : entries(i)) s += e.d * x[e.place];
    return s;
  }
  /// Moves x so that s of mode i grows by `distance` and no other does.
  void move(std::size_t i, double distance, double* x) const {
    for (Entry const& e : entries(i)) x[e.place] += e.u * distance;
  }

  std::vector<double> origin;  ///< what the system made them from, for it to compare

  /// Everything that changes in a run, for plant/state_archive.hpp.
  ///
  /// @param states  numbers that a mode may move
  void state(auto& archive, int states) {
    archive.list(origin, origin.capacity());
    archive.list(mode_, mode_.capacity());
    archive.list(entry_, entry_.capacity());
    for (Mode const& mode : mode_)
      archive.need(mode.first <= entry_.size() && mode.count <= entry_.size() - mode.first);
    for (Entry const& entry : entry_) archive.need(entry.place >= 0 && entry.place < states);
  }

 private:
  std::vector<Mode> mode_;
  std::vector<Entry> entry_;
};

}  // namespace rollerrig
