#include "rollerrig/system/contact_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

constexpr double near_edge = 0.5e-3;        // of a profile: closer than this to its end counts as off it, along it [m]
constexpr double near_flange_tip = 1e-3;    // [m]
constexpr double rounding_of_power = 1e-6;  // dissipation less negative than this is round-off [W]

/// Along the profile, whose last piece before an end on the side of a head or flange is millimetres high and hardly wide.
bool is_off(UniformSpline const& profile, double abscissa, double edge) {
  double const end = 2.0 * abscissa < profile.start + profile.end() ? profile.start : profile.end();
  return !profile.contains(abscissa) ||
         std::hypot(end - abscissa, profile.at(end).value - profile.at(abscissa).value) < edge;
}

}  // namespace

void ContactLoss::add(double from, double to) {
  ++spells;
  total += to - from;
  if (to - from <= longest) return;
  longest = to - from;
  longest_from = from;
}

std::vector<ContactLoss> ContactMonitor::losses() const {
  auto all = losses_;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (lost_since_[i] >= 0.0) all[i].add(lost_since_[i], checked_at_);
  return all;
}

void ContactMonitor::reset() {
  counters_ = {};
  failed_contact_ = -1;
  std::fill(losses_.begin(), losses_.end(), ContactLoss{});
  std::fill(lost_since_.begin(), lost_since_.end(), -1.0);
}

Status ContactMonitor::check(Model const& model, Evaluation const& evaluation, double t) {
  checked_at_ = t;
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    int const n = evaluation.patch_count(static_cast<int>(i));
    ++counters_.checked;
    counters_.several_patches += n > 1;
    counters_.refined += n > 0 && evaluation.patch(static_cast<int>(i), 0).refined;
    failed_contact_ = static_cast<int>(i);
    if (n == 0) {
      ++counters_.lost;
      if (lost_since_[i] < 0.0) lost_since_[i] = t;
      if (t - lost_since_[i] > model.contact_loss_limit) return Status::contact_lost;
    } else if (lost_since_[i] >= 0.0) {
      losses_[i].add(lost_since_[i], t);
      lost_since_[i] = -1.0;
    }
    for (int k = 0; k < n; ++k)
      if (auto const status = check_patch(model, evaluation, failed_contact_, k); status != Status::ok) return status;
  }
  failed_contact_ = -1;
  return Status::ok;
}

Status ContactMonitor::check_patch(Model const& model, Evaluation const& evaluation, int index, int k) {
  WheelContact const& contact = model.contacts[at(index)];
  Patch<double> const& p = evaluation.patch(index, k);
  counters_.limited_curvature += p.limited;
  counters_.faded += p.weight < 1.0;
  counters_.clamped_aspect += !model.laws.kalker->covers(p.log_aspect);
  counters_.negative_dissipation += p.creep_dissipation() < -rounding_of_power;
  if (k > 0 && std::holds_alternative<HertzEllipses>(model.laws.normal)) {
    Patch<double> const& left = evaluation.patch(index, k - 1);
    double const distance = std::hypot(p.point.p.y - left.point.p.y, p.point.p.z - left.point.p.z);
    counters_.overlapping += distance < p.b + left.b;
  }
  double const size = contact.pair.size;
  if (p.point.wheel_s < contact.flange_tip + near_flange_tip * size) return Status::derailed;
  bool const off = is_off(*contact.pair.wheel, p.point.wheel_s, near_edge * size) ||
                   is_off(*contact.pair.rail, p.point.rail_y, near_edge * size);
  return off ? Status::off_profile : Status::ok;
}

}  // namespace rollerrig
