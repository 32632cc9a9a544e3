#include "rollerrig/system/static_wheelset_contact.hpp"

#include <cmath>

#include "rollerrig/contact/patch.hpp"

namespace rollerrig {
namespace {

/// Root of f in [low, high] with f(low), f(high) of different sign: false position with Illinois' weights.
template <class F>
double root_between(F const& f, double low, double high, double resolution) {
  double f_low = f(low);
  double f_high = f(high);
  if ((f_low > 0.0) == (f_high > 0.0)) return std::abs(f_low) < std::abs(f_high) ? low : high;
  for (int i = 0; i < 200 && std::abs(high - low) > resolution; ++i) {
    // Every third step halves: safe where f is flat on one side (no contact).
    double x = (i % 3 == 2) ? 0.5 * (low + high) : (low * f_high - high * f_low) / (f_high - f_low);
    if (!(x > std::min(low, high) && x < std::max(low, high))) x = 0.5 * (low + high);
    double const value = f(x);
    if (value == 0.0) return x;
    if ((value > 0.0) == (f_high > 0.0)) {
      high = x, f_high = value;
      f_low *= 0.5;
    } else {
      low = x, f_low = value;
      f_high *= 0.5;
    }
  }
  return 0.5 * (low + high);
}

/// One patch with its weight applied; the right side is computed in its mirror image.
StaticPatch seen(WheelContact const& contact, NormalPatch<double> const& patch) {
  double const side = contact.right ? -1.0 : 1.0;
  auto const& point = patch.point;
  auto const profile = contact.pair.wheel->at(point.wheel_s);
  StaticPatch out;
  out.right = contact.right;
  out.wheel_s = point.wheel_s;
  out.rail_y = point.rail_y;
  out.angle = std::atan(profile.slope);
  out.wheel_radius = contact.pair.wheel_radius + profile.value;
  out.point = {point.p.x, side * point.p.y, point.p.z};
  out.direction = {point.n.x, side * point.n.y, point.n.z};
  out.a = patch.a, out.b = patch.b, out.area = pi * patch.a * patch.b;
  out.approach = -point.gap, out.peak_pressure = patch.peak_pressure;
  out.length = patch.length, out.width = patch.width;
  out.weight = patch.weight, out.normal = patch.weight * patch.elastic;
  out.limited = patch.limited;
  return out;
}

}  // namespace

StaticWheelsetContact::StaticWheelsetContact(std::shared_ptr<Model const> model, int left, int right)
    : model_{std::move(model)} {
  auto const& contacts = model_->contacts;
  for (int const i : {left, right})
    need(i >= 0 && i < static_cast<int>(contacts.size()), "left, right: there is no contact " + std::to_string(i));
  contact_ = {&contacts[at(left)], &contacts[at(right)]};
  if (contact_[0]->right || !contact_[1]->right || contact_[0]->wheelset != contact_[1]->wheelset)
    throw std::invalid_argument("left and right must be the two contacts of one wheelset");
}

RelativePose<double> StaticWheelsetContact::pose(WheelsetPosition const& p, bool right) const {
  Body body;
  body.axisymmetric = true;
  BodyMotion<double> m;
  double const side = right ? -1.0 : 1.0;
  m.q = {p.x, side * p.y, p.z, side * p.roll, 0.0, side * p.yaw};
  update_motion(body, m);
  Vec3<double> offset = contact_[right]->wheelset_from_crown;
  offset.y *= side;
  return {offset + m.p, m.R};
}

StaticWheelsetContact::Load StaticWheelsetContact::load_at(WheelsetPosition const& p) const {
  Load load{0.0, 0.0};
  for (bool right : {false, true}) {
    auto const at = pose(p, right);
    for (auto const& patch : patches(p, right)) {
      Vec3<double> const force = patch.normal * patch.direction;
      Vec3<double> const arm = patch.point - Vec3<double>{at.o.x, p.y + contact_[0]->wheelset_from_crown.y, 0.0};
      load.vertical += force.z;
      load.roll_moment += cross(arm, force).x;
    }
  }
  return load;
}

std::vector<StaticPatch> StaticWheelsetContact::patches(WheelsetPosition const& p, bool right) const {
  WheelContact const& contact = *contact_[right];
  auto const at = pose(p, right);
  PatchList<NormalPatch<double>> found;
  int count = 0;
  std::array const wheel{NormalContact<double, NormalPatch<double>>{
      {contact.pair, model_->laws.material, contact.nodes.get()}, &at, &found, &count}};
  normal_patches<double, NormalPatch<double>>(model_->laws.normal, wheel);
  std::vector<StaticPatch> list;
  for (int k = 0; k < count; ++k) list.push_back(seen(contact, found[static_cast<std::size_t>(k)]));
  return list;
}

std::vector<StaticPatch> StaticWheelsetContact::minima(WheelsetPosition const& position, bool right,
                                                       double reach) const {
  WheelContact const& contact = *contact_[right];
  auto const at = pose(position, right);
  auto const minima = find_minima(contact.pair, *contact.nodes, at, reach);
  std::vector<StaticPatch> list;
  for (std::size_t k = 0; k < minima.count; ++k) {
    NormalPatch<double> patch;
    patch.point = contact_point(contact.pair, at, minima.minimum[k]);
    hertz_patch(model_->laws.material, patch);
    list.push_back(seen(contact, patch));
  }
  return list;
}

double StaticWheelsetContact::touch_height(WheelsetPosition p, bool right) const {
  double reach = 1.0;  // [m]
  auto const lowest_gap = [&](double z) {
    p.z = z;
    double gap = reach;
    for (auto const& patch : minima(p, right, reach)) gap = std::min(gap, -patch.approach);
    return gap;
  };
  // From above: lowering the wheel by d takes at most d off any gap, so a step may be as long as the lowest gap, which only falls.
  double high = 0.05;
  double low = high;
  for (double gap = lowest_gap(low); gap >= 0.0 && low > -0.05; gap = lowest_gap(low)) {
    high = low;
    low -= gap < reach ? std::max(0.5e-3, gap) : 0.5e-3;
    reach = std::min(reach, gap + 1e-6);
  }
  return root_between(lowest_gap, low, high, 1e-13);
}

/// Height at which the contacts carry `load`, looked for around p.z.
double StaticWheelsetContact::height_for(WheelsetPosition p, double load) const {
  double const start = p.z;
  auto const surplus = [&](double z) {
    p.z = z;
    return load_at(p).vertical - load;
  };
  double const widest = 0.1;  // [m]
  double step = 0.02e-3;
  double low = start;
  while (surplus(low) < 0.0 && low > start - widest) low -= step, step *= 2.0;
  double high = low + step;
  while (surplus(high) > 0.0 && high < start + widest) high += step, step *= 2.0;
  return root_between(surplus, low, high, 1e-13);
}

LoadedWheelset StaticWheelsetContact::solve(WheelsetPosition p, double load, bool free_to_roll) const {
  p.z = std::max(touch_height(p, false), touch_height(p, true));
  if (free_to_roll) {
    auto const moment = [&](double roll) {
      WheelsetPosition trial = p;
      trial.roll = roll;
      trial.z = p.z = height_for(trial, load);  // the next one is looked for around it
      return load_at(trial).roll_moment;
    };
    // More roll lowers the right wheel (y < 0) into its roller, which turns the wheelset back.
    double reach = 0.2e-3;
    double const centre = p.roll;
    while (reach < 0.1 && !(moment(centre - reach) > 0.0 && moment(centre + reach) < 0.0)) reach *= 2.0;
    p.roll = root_between(moment, centre - reach, centre + reach, 1e-13);
  }
  p.z = height_for(p, load);
  LoadedWheelset result;
  result.position = p;
  auto const reached = load_at(p);
  result.vertical = reached.vertical;
  result.roll_moment = reached.roll_moment;
  result.converged = std::abs(reached.vertical - load) < 1e-6 * load + 1e-6 &&
                     (!free_to_roll || std::abs(reached.roll_moment) < 1e-5 * load);
  for (bool right : {false, true})
    for (auto const& patch : patches(p, right)) result.patches.push_back(patch);
  return result;
}

WheelBatch::WheelBatch(StaticWheelsetContact const& wheelset, WheelsetPosition position, bool right, int wheels)
    : law_{wheelset.model_->laws.normal}, patches_(static_cast<std::size_t>(wheels)), count_(patches_.size()) {
  WheelContact const& contact = *wheelset.contact_[right];
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    pose_.push_back(wheelset.pose(position, right));
    position.y += 0.1e-3;
  }
  for (std::size_t i = 0; i < patches_.size(); ++i)
    contacts_.push_back(
        {{contact.pair, wheelset.model_->laws.material, contact.nodes.get()}, &pose_[i], &patches_[i], &count_[i]});
}

void WheelBatch::evaluate() { normal_patches<double, NormalPatch<double>>(law_, contacts_); }

}  // namespace rollerrig
