// contact/creep/rolling_reference.hpp - the exact tangential contact of two rolling half-spaces of one material, on an elliptic
// patch or on one given row by row; for verification and for building tables. Offline: it allocates, and a solution takes
// milliseconds.
//
// Kalker's variational theory, discretised with boundary elements: piecewise constant tractions, exact displacements of a
// rectangle under uniform traction, Coulomb's law in every element. How, and how well: docs/theory/creep_laws.md, (C1)-(C4).
//
// Units   reduced: forces in mu N, lengths in c = sqrt(ab) or in any other c where the patch is no ellipse,
//         so the result depends on the shape of the patch and its pressure, nu and the reduced creepages only
//             xi = G ab e_x / (mu N),   eta = G ab e_y / (mu N),   chi = G (ab)^1.5 e_sp / (mu N).
// Signs   as in contact/creep/creep_law.hpp: forward rolling along x, forces and moment on the wheel.
// Source  Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), ch. 4, with its active-set algorithm; James, Comput. Methods Appl. Mech. Eng. 1 (1972) for the places of loads and slip in an element.
#pragma once
#include <array>
#include <cmath>
#include <vector>

namespace rollerrig {

/// Displacement difference (wheel less roller) per unit of uniform traction on a rectangle, times G.
struct RectangleInfluence {
  double xx, xy, yy;
};

/// @param x, y    from the rectangle's centre to the point
/// @param dx, dy  sides of the rectangle
RectangleInfluence rectangle_influence(double x, double y, double dx, double dy, double poisson_ratio);

/// xi, eta, chi.
struct ReducedCreepage {
  double longitudinal{0.0}, lateral{0.0}, spin{0.0};
};

/// One solution, in units of mu N and c.
struct RollingSolution {
  double longitudinal{0.0}, lateral{0.0}, spin_moment{0.0};
  double adhesion{0.0};  ///< fraction of the patch that sticks
  int steps{0};
  bool converged{false};
};

/// Rows of the patch along the rolling direction, and elements in each row: every row is cut into equally many.
struct RollingGrid {
  int rows{16};
  int elements{24};
  /// @param fineness  1: errors below 1 % of mu N; proportional to elements per semi-axis
  static RollingGrid for_ellipse(double a_over_b, double fineness = 1.0);
};

/// A row of the patch, its pressure semi-elliptic along it.
struct PatchRow {
  double across;       ///< y of its middle [c]
  double middle;       ///< x of its middle [c]
  double half_length;  ///< [c]
  double load;         ///< of the row, in any unit: only the ratios of the rows count
};

class RollingReference {
 public:
  /// @param spacing  of the rows, equal [c]; the outermost ones end 0.1 of it inside the patch's edges
  RollingReference(std::vector<PatchRow> const& rows, double spacing, double poisson_ratio, int elements);
  RollingReference(double a_over_b, double poisson_ratio, RollingGrid grid)
      : RollingReference(ellipse_rows(a_over_b, grid.rows), ellipse_spacing(a_over_b, grid.rows), poisson_ratio,
                         grid.elements) {}
  RollingReference(double a_over_b, double poisson_ratio)
      : RollingReference(a_over_b, poisson_ratio, RollingGrid::for_ellipse(a_over_b)) {}

  /// Starts from the last solution: cases in an order of small steps are cheaper. Where that does not converge, from full stick,
  /// then along creepages in the same ratio that fall or rise to the one asked for.
  RollingSolution solve(ReducedCreepage const& creepage);

  /// Rows that turn against each other, as on a bent patch: each with its own slip and spin, in its own plane. The surfaces stay
  /// elastic as a half-space, rolled out. Of the solution the sums over the rows mean little: forces_of_rows().
  ///
  /// @param creepage  of each row: slip along it, slip across it at x = 0, spin
  RollingSolution solve(std::vector<ReducedCreepage> const& creepage);

  struct RowForce {
    double longitudinal{0.0}, lateral{0.0}, moment{0.0};  ///< [mu N], [mu N c] about the row's x = 0
  };
  std::size_t rows() const { return across_.size(); }
  std::vector<RowForce> forces_of_rows() const;

  double tolerance{1e-6};  ///< largest change of a traction over its bound in the last step
  int max_steps{60};

  // The last solution, element by element: centre [c], largest and present traction [mu N / c^2].
  std::vector<double> x, y, bound, traction_x, traction_y;

 private:
  struct NewtonSystem;
  static double ellipse_spacing(double a_over_b, int rows) { return 2.0 / std::sqrt(a_over_b) / (rows + 0.2); }
  static std::vector<PatchRow> ellipse_rows(double a_over_b, int rows);
  void place_elements(PatchRow const& row, double spacing, std::vector<double>& length);
  void find_influences(std::vector<double> const& length, double dy, double poisson_ratio);
  void find_slip(double factor);
  void fill_sticking(std::size_t element, NewtonSystem& system) const;
  void fill_slipping(std::size_t element, NewtonSystem& system) const;
  double newton_step();
  bool iterate(double factor, int& steps);
  int revise(bool may_stick);
  void release();  ///< full stick, no traction
  std::size_t count() const { return x.size(); }

  int elements_;
  std::vector<double> across_;                   // y of each row
  std::vector<ReducedCreepage> creepage_;        // of each row
  std::vector<double> area_;                     // of an element [c^2]
  std::vector<double> arm_;                      // x of the centre of its bound [c]
  std::vector<double> slip_x_, slip_y_;          // where slip is taken
  std::vector<double> b_xx_, b_xy_, b_yy_;       // [slip point][element]: slip per unit of traction
  std::vector<double> velocity_x_, velocity_y_;  // slip over V at the slip points, of the present tractions
  std::vector<char> slipping_;
  std::vector<long> first_;  // unknown of each element
};

}  // namespace rollerrig
