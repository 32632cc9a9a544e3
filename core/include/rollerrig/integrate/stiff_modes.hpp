// relaxing_directions.hpp - along which combinations of its states a system relaxes fast, and how fast, for now.
//
//   system -> [s_i = d_i . x,  s_i' = N_i - rate_i s_i,  x moves by u_i where s_i moves by 1] -> exponential methods
//
// d_i . u_j = 1 for i = j, else 0: the directions do not see each other. What s_i relaxes to may itself run away as time goes
// on, a rail under a braking train: at about the drift.
//
// Rate and drift need not be exact, N takes up the rest. A rate between 0.6 and any multiple of the true one keeps the method
// stable; the nearer, the more accurate.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace rollerrig {

class RelaxingDirections {
 public:
  /// One state's part in a direction, or with d = 0 what a quadrature, behind the states, gains when s_i is moved.
  struct Entry {
    int state;
    double d, u;
  };
  struct Direction {
    double rate;   ///< [1/s]
    double drift;  ///< [unit of s_i over s]
    std::size_t first, count;
  };

  RelaxingDirections() = default;
  /// Everything is allocated here.
  RelaxingDirections(std::size_t most_directions, std::size_t most_entries, std::size_t longest_origin) {
    direction_.reserve(most_directions);
    entry_.reserve(most_entries);
    origin.reserve(longest_origin);
  }

  void clear() {
    direction_.clear();
    entry_.clear();
    origin.clear();
  }
  /// A direction without entries, to be followed by add() for each.
  void begin(double rate, double drift) { direction_.push_back({rate, drift, entry_.size(), 0}); }
  void add(int state, double d, double u) {
    entry_.push_back({state, d, u});
    ++direction_.back().count;
  }

  std::size_t size() const { return direction_.size(); }
  std::size_t capacity() const { return direction_.capacity(); }
  double rate(std::size_t i) const { return direction_[i].rate; }
  double drift(std::size_t i) const { return direction_[i].drift; }
  std::span<Entry const> entries(std::size_t i) const {
    return {entry_.data() + direction_[i].first, direction_[i].count};
  }
  /// s of direction i.
  double along(std::size_t i, double const* x) const {
    double s = 0.0;
    for (Entry const& e : entries(i)) s += e.d * x[e.state];
    return s;
  }
  /// Moves x so that s of direction i grows by `distance` and no other does.
  void move(std::size_t i, double distance, double* x) const {
    for (Entry const& e : entries(i)) x[e.state] += e.u * distance;
  }

  std::vector<double> origin;  ///< what the system made them from; its own business

 private:
  std::vector<Direction> direction_;
  std::vector<Entry> entry_;
};

}  // namespace rollerrig
