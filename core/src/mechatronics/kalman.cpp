// The stationary gain of the Kalman filter: docs/theory/rig_control.md, (D10)-(D12).
#include "rollerrig/mechatronics/estimators.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace rollerrig {

KalmanFilter::Gain KalmanFilter::gain(AssumedParameters const& assumed, double period) const {
  using Matrix4 = Eigen::Matrix4d;
  double const per_root = bandwidth * bandwidth * speed_noise * std::sqrt(period);  // (D12)
  auto const [J_r, R, J_w, r] = assumed;
  double const force = force_change.value_or(per_root * J_r / R);
  double const torque = torque_change.value_or(per_root * (J_w + J_r * r / R));
  Matrix4 A = Matrix4::Zero(), Q = Matrix4::Zero();  // (D10)
  A(0, 2) = R / J_r;
  A(1, 2) = -r / J_w;
  A(1, 3) = 1.0 / J_w;
  Q(2, 2) = force * force;
  Q(3, 3) = torque * torque;
  double const h = period;
  // A A = 0: the exponential and the integral of the noise end after few terms.
  Matrix4 const F = Matrix4::Identity() + h * A;
  Matrix4 const noise = h * Q + h * h / 2.0 * (A * Q + Q * A.transpose()) + h * h * h / 3.0 * A * Q * A.transpose();
  Eigen::Matrix<double, 2, 4> const H = Eigen::Matrix<double, 2, 4>::Identity();
  Eigen::Matrix2d const measured = speed_noise * speed_noise * Eigen::Matrix2d::Identity();
  Matrix4 P = noise;
  P.topLeftCorner<2, 2>() += measured;
  Eigen::Matrix<double, 4, 2> K = Eigen::Matrix<double, 4, 2>::Zero();
  for (int i = 0; i < 200000; ++i) {  // (D11)
    Eigen::Matrix<double, 4, 2> const before = K;
    K = P * H.transpose() * (H * P * H.transpose() + measured).inverse();
    Matrix4 const left = Matrix4::Identity() - K * H;
    Matrix4 const corrected = left * P * left.transpose() + K * measured * K.transpose();  // stays symmetric
    P = F * corrected * F.transpose() + noise;
    if ((K - before).cwiseAbs().maxCoeff() < 1e-13 * K.cwiseAbs().maxCoeff()) break;
  }
  Gain gain{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 2; ++k) gain[i][k] = K(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
  return gain;
}

}  // namespace rollerrig
