// integrate/matrix_phi_functions.hpp - phi functions of a matrix, for a step and its halves.
//
//     phi_0(A) = e^A,   phi_k(A) = integral over theta of e^((1 - theta) A) theta^(k-1) / (k-1)!,   A = h L
//
//   L, h -> [scaled, Taylor series, doubled] -> what multiplies the differences of N over a step of h, h/2, h/4 ...
//
// The series holds for a step that is short against everything in L; from there a step is doubled until it is h, so that all
// shorter ones are found on the way. Positions are counted in velocity times h and quadratures in what one step may bring: an
// entry k/m of L, or the power of a force, would otherwise seem fast.
// Source  Hochbruck, Ostermann, Exponential integrators, Acta Numerica 19 (2010), section 2; doubling: Skaflestad, Wright,
//         The scaling and modified squaring method for matrix functions, Appl. Numer. Math. 59 (2009).
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "rollerrig/integrate/differential_equation.hpp"

namespace rollerrig::integrate {

/// Weights of one step for N(theta) = sum of C(theta + m - 1, m) D^m N, D^m the m-th backward difference.
struct StepWeights {
  Eigen::MatrixXd slope;  ///< (n, n) phi_1, of the slope at the start
  /// (n, n - kinematic) integrals of e^((1 - theta) A) times theta, theta (theta + 1) / 2, theta (theta + 1) (theta + 2) / 6.
  std::array<Eigen::MatrixXd, 3> difference;
};

class MatrixPhiFunctions {
 public:
  /// @param kinematic    of the states: positions; they come first
  /// @param quadratures  nothing depends on them; they come last
  MatrixPhiFunctions(Eigen::Index states, Eigen::Index kinematic, Eigen::Index quadratures)
      : states_{states}, kinematic_{kinematic}, units_(Eigen::VectorXd::Ones(states + quadratures)) {
    auto const n = units_.size();
    for (auto* m : {&scaled_, &sum_, &product_, &phi_[0], &phi_[1], &phi_[2], &phi_[3], &phi_[4]}) m->setZero(n, n);
  }

  /// Of the matrix of states and quadratures h [df/dx, 0; dg/dx, 0].
  ///
  /// @param weights  of the steps h, h/2, h/4 ...
  void compute(JacobianData const& j, double h, std::vector<StepWeights>& weights);

 private:
  static constexpr int highest = 4;        // phi_4: N is a cubic of time
  static constexpr int series_terms = 14;  // of phi_4 for a matrix of norm 1: the rest is below 1e-16

  /// phi_4 by its series, the others by phi_k = A phi_k+1 + 1 / k!.
  void series();

  /// phi_k(2 A) = 2^-k [phi_0(A) phi_k(A) + sum over j = 1 ... k of phi_j(A) / (k - j)!].
  void double_step();

  void store(StepWeights& w);

  Eigen::Index states_, kinematic_;
  Eigen::VectorXd units_;
  Eigen::MatrixXd scaled_, sum_, product_;
  std::array<Eigen::MatrixXd, highest + 1> phi_;
};

}  // namespace rollerrig::integrate
