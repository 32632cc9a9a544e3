// geometry/search.hpp - finds every contact patch of one wheel, and knows when it need not look again.
//
// The wheel profile is cut into cells. In each cell the reduced equation F(s) and its exact slope at both ends give a
// cubic; its monotone stretches bracket the roots. A cell whose normals miss the generatrix at one end is cut to the part
// that meets it. A root where F falls is a minimum of the gap (the paper's curvature check); one where it rises is a maximum,
// and only the height of those between two minima is kept; a minimum with gap < 0 is a patch (indentation check).
//
// Warm search. A cell is left alone while one of two bounds holds. The gap: it falls at most as fast as the wheel moves, so
// a cell cannot be indented before half its lowest gap is used up. The roots of F: F changes by the turning of the wheel's
// slope (roll; yaw and longitudinal offset a little) and by the generatrix sliding along underneath (lateral shift times its
// second derivative); while that is less than how far F was from changing its roots, a known root is only polished by Newton.
// The weights carry a margin and are not proved; tests compare with the exhaustive search along whole runs.
// Equations (G5), (G6) of docs/theory/contact_geometry.md.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "rollerrig/geometry/reduction.hpp"

namespace rollerrig {

/// A stationary point of the gap: root of F; with gradient < 0 a minimum, else a maximum.
struct GapMinimum {
  double s{0.0};         ///< wheel abscissa [m]
  double gradient{0.0};  ///< dF/ds [1/m]
  double gap{0.0};       ///< [m]
};

class ContactSearch {
 public:
  static constexpr int max_minima = 8;
  static constexpr double cell_width = 1e-3;  ///< of a full-scale pair, others in proportion to its size [m]

  explicit ContactSearch(WheelRollerPair const& pair);

  /// All minima of the gap with gap < reach, ordered by s; exhaustive search over the whole wheel.
  int find_all(RelativePose<double> const& pose, double reach);

  /// The same with reach = 0, using what is known from the previous call.
  int find_indented(RelativePose<double> const& pose);

  int count() const { return count_; }
  GapMinimum const& operator[](int i) const { return minima_[static_cast<std::size_t>(i)]; }
  /// The maximum of the gap between the minima i and i + 1, kept by find_indented() and find_all(pose, 0).
  GapMinimum const& barrier(int i) const { return barriers_[static_cast<std::size_t>(i)]; }

  std::int64_t node_evaluations() const { return node_evaluations_; }

  /// Everything that changes in a run, for plant/state_archive.hpp.
  template <class Archive>
  void state(Archive& archive) {
    archive(nodes_, cells_, node_rail_y_, minima_, barriers_, count_, call_, node_evaluations_, motion_, last_pose_,
            now_);
  }

 private:
  enum class CellState : char { unknown, empty, one_minimum, many };
  struct Node {
    double residual{0.0}, gradient{0.0}, gap{0.0};
    double y{0.0};  ///< of the wheel's point on the generatrix' abscissa [m]
    bool valid{false};
    std::int64_t call{-1};
  };
  /// What the bounds on F are made of.
  struct Placement {
    double x{0.0}, y{0.0}, z{0.0}, roll{0.0}, yaw{0.0};
  };
  struct Cell {
    double asleep_until{-1.0};                 ///< accumulated motion up to which the cell need not be looked at [m]
    double room_up{0.0};                       ///< how far F may rise before it changes its roots in this cell [-]
    double room_down{0.0};                     ///< how far it may fall [-]
    double lowest_second{0.0};                 ///< range of the generatrix' second derivative around [1/m]
    double highest_second{0.0};                ///< its upper end [1/m]
    double first_slope{0.0}, last_slope{0.0};  ///< of the wheel profile at both ends [-]
    Placement seen{};                          ///< where the wheel was then
    GapMinimum root{};                         ///< as last polished
    double root_slope{0.0}, root_shift{0.0};   ///< wheel's slope and dF over lateral shift there [-], [1/m]
    Placement root_seen{};                     ///< where the wheel was then
    CellState state{CellState::unknown};
  };

  /// A cell, or the part of it whose normals meet the generatrix, with F at its ends.
  struct Span {
    double first, last;  ///< wheel abscissae [m]
    Node a, b;
    bool partial{false};  ///< the wheel's normals miss the generatrix somewhere in the cell
  };

  /// Parameters t in 0..1 that cut a cell into `count` stretches in which F rises or falls, and F there.
  struct Stretches {
    std::array<double, 4> cut, value;
    int count;
  };

  Stretches monotone_stretches(RelativePose<double> const& pose, double first, double h, Node const& a,
                               Node const& b) const;
  bool still_holds(Cell& cell) const;
  void move_to(RelativePose<double> const& pose);
  double left(int cell) const { return first_ + cell_ * cell; }
  Node const& node(RelativePose<double> const& pose, int i);
  void trim(RelativePose<double> const& pose, double& first, Node& a, double& last, Node& b) const;
  bool within_reach(RelativePose<double> const& pose, Cell& cell, Span& span, double reach, double ahead) const;
  void find_roots(RelativePose<double> const& pose, Cell& cell, Span const& span, double reach);
  void analyse(RelativePose<double> const& pose, int cell, double reach, double ahead);
  void roots_between(RelativePose<double> const& pose, Cell& cell, double s0, double f0, double s1, double f1,
                     double reach);
  bool polish(RelativePose<double> const& pose, double low, double high, double guess, double falling, GapMinimum& root,
              ReducedSlope& at_root) const;
  bool polish(RelativePose<double> const& pose, double low, double high, double guess, Cell& cell) const;
  double expected_root(Cell const& cell, double low, double high) const;
  void find_barriers(RelativePose<double> const& pose);
  void keep(GapMinimum const& root, double reach);
  void bound_rail(double y0, double y1, double& lowest, double& highest) const;

  WheelRollerPair const* pair_;
  double size_;  ///< of the pair [-]
  double cell_;  ///< width of a cell [m]
  double first_;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
  std::vector<double> lowest_second_, highest_second_;  ///< range of h'' in each millimetre of the generatrix [1/m]
  std::vector<double> node_rail_y_;                     ///< abscissa on the generatrix under each node [m]
  std::array<GapMinimum, max_minima> minima_, barriers_;
  int count_{0};
  std::int64_t call_{0};
  std::int64_t node_evaluations_{0};
  double motion_{0.0};
  RelativePose<double> last_pose_;
  Placement now_;
};

}  // namespace rollerrig
