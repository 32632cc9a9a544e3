// A wheel with elastic strips on the rail or roller of the benchmark, in any pose.
#pragma once
#include <random>

#include "profiles.hpp"
#include "rollerrig/contact/normal/strip_contact.hpp"
#include "rollerrig/contact/normal/strip_layout.hpp"

namespace rollerrig::test {

/// The address sanitizer looks at memory and makes each pose many times as slow: a tenth of the poses there, and no counts of
/// what only many of them meet.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif
constexpr int some_of(int poses) { return sanitized ? poses / 10 : poses; }

inline Material const steel{};

struct Wheel {
  BenchmarkPair profiles;
  GapNodes nodes;
  NormalSetting setting;

  explicit Wheel(double inverse_radius)
      : profiles(inverse_radius), nodes(profiles.wheel, 1.0), setting{profiles.pair, steel, &nodes} {}
  StripSolution<double> at(double y, double depth, double roll = 0.0, double yaw = 0.0, double x = 0.0) const {
    return strip_contact(setting, pose_of(x, y, 0.46 - depth, roll, yaw));
  }
  GapScan scan(double y, double depth) const {
    return scan_gap(profiles.pair, nodes, pose_of(0.0, y, 0.46 - depth, 0.0, 0.0));
  }
};

inline Vec3<double> total(StripSolution<double> const& c) {
  Vec3<double> sum{};
  for (int k = 0; k < c.count; ++k) {
    auto const& p = c.patch[static_cast<std::size_t>(k)];
    sum += p.weight * p.normal * p.direction;
  }
  return sum;
}

/// One region as strips are laid on it.
inline void put(Wheel const& wheel, RelativePose<double> const& pose, InterpenetrationRegion const& region,
                RegionPack<double>& pack) {
  pack.pair.set_all(wheel.profiles.pair, wheel.nodes.arc().abscissae());
  pack.pose = pose;
  pack.compliance = steel.compliance() / pi;
  for (std::size_t k = 0; k < 2; ++k) {
    RegionEnd const& end = k == 0 ? region.left : region.right;
    pack.end[k] = {end.position, std::min(end.inside, end.outside), std::max(end.inside, end.outside),
                   end.is_root ? 1.0 : 0.0};
  }
}

/// Poses of all kinds, pressed until the wheel carries a load between these [N].
inline std::vector<RelativePose<double>> loaded_poses(Wheel const& wheel, int count, unsigned seed, double yaw_range,
                                                      double least = 3e3, double most = 150e3) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<RelativePose<double>> out;
  while (out.size() < static_cast<std::size_t>(count)) {
    double const y = 9e-3 * any(generator), roll = 8e-3 * any(generator), yaw = yaw_range * any(generator);
    double const x = wheel.profiles.pair.inverse_radius > 0.0 ? 4e-3 * any(generator) : 0.0;
    double const load = least * std::pow(most / least, 0.5 * (any(generator) + 1.0));
    double low = -0.03, high = 0.03;
    for (int i = 0; i < 40; ++i) {
      double const middle = 0.5 * (low + high);
      auto const f = total(wheel.at(y, middle, roll, yaw, x));
      (std::sqrt(dot(f, f)) < load ? low : high) = middle;
    }
    out.push_back(pose_of(x, y, 0.46 - high, roll, yaw));
  }
  return out;
}

}  // namespace rollerrig::test
