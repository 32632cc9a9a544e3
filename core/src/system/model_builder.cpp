#include "rollerrig/system/model_builder.hpp"

#include <cmath>
#include <stdexcept>

#include "rollerrig/geometry/interpenetration.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void need(bool condition, std::string const& message) {
  if (!condition) throw std::invalid_argument(message);
}
void need_positive(double value, std::string const& what) {
  need(value > 0.0 && std::isfinite(value), what + " must be positive, got " + std::to_string(value));
}
void need_finite(std::initializer_list<double> values, std::string const& what) {
  for (double v : values) need(std::isfinite(v), what + " must be finite");
}
void need_table(PiecewiseLinear const& table, std::string const& what) {
  need(table.x.size() == table.y.size(), what + " must have one value per point");
  for (std::size_t i = 0; i < table.x.size(); ++i) {
    need_finite({table.x[i], table.y[i]}, what);
    need(i == 0 || table.x[i - 1] < table.x[i], what + " must be given at increasing points");
  }
}
/// Numbers and tables of a force law; damping and stiffness at an inner node, which are divided by.
template <NamedLaw Law>
void need_law(Law const& law, std::string const& what) {
  auto const need_field = [&](auto const& field) {
    auto const& value = law.*field.member;
    if constexpr (std::same_as<std::remove_cvref_t<decltype(value)>, double>)
      need_finite({value}, what + field.name);
    else
      need_table(value, what + field.name);
  };
  std::apply([&](auto const&... field) { (need_field(field), ...); }, Law::fields());
  if constexpr (HasNode<Law>) {
    need_positive(law.node().damping, what + Law::name + ": damping of its inner node");
    need_positive(law.node().stiffness, what + Law::name + ": stiffness at its inner node");
  }
}
void need_spline(UniformSpline const& spline, std::string const& what) {
  need_positive(spline.step, what + ": step");
  need(!spline.pieces.empty(), what + " has no pieces");
  for (auto const& c : spline.pieces) need_finite({c[0], c[1], c[2], c[3]}, what);
}
void need_increasing(PiecewiseCubic const& curve, std::string const& what) {
  need(curve.start.size() == curve.coefficient.size(), what + " must have one row per break");
  for (std::size_t i = 1; i < curve.start.size(); ++i)
    need(curve.start[i - 1] < curve.start[i], what + ": breaks must increase");
}

std::string number(std::string const& what, std::size_t i) { return what + " " + std::to_string(i); }

/// The flange tip is the highest point of the wheel profile on the flange side; a wheel without flange has none to climb.
double flange_tip(UniformSpline const& wheel, double size) {
  double const least_height = 0.015 * size;  // [m]
  double tip = wheel.start;
  for (double s = wheel.start; s < 0.0; s += wheel.step)
    if (wheel.at(s).value > wheel.at(tip).value) tip = s;
  return wheel.at(tip).value > least_height ? tip : wheel.start - 1.0;
}

/// The rotor of a motor turns with n Omega_axle + (1 - n) Omega_casing (n < 0: against the axle, as with one pair of gears).
/// Casing: the reaction body; the ground; or, axle-hung, a body between the axle and a link at distance d on the reaction body,
/// with Omega_casing = -(z'_link - z'_axle) / d. Source: docs/theory/adhesion.md, (A9)-(A11).
Coupling rotor_of(AxleTorque const& torque) {
  double const n = torque.gear_ratio;
  CouplingTerm axle{torque.wheelset, 0.0, 0.0, n}, casing{torque.reaction, 0.0, 0.0, 1.0 - n};
  if (torque.link != 0.0) {
    axle.z = (1.0 - n) / torque.link;
    casing.z = -axle.z;
    casing.pitch = axle.z * torque.link_on_reaction;
  }
  return {{axle, casing}, torque.rotor_inertia, 0.0};
}

/// u is the mean longitudinal slip at nominal radii, (D13).
Coupling coupling_of(RollingConstraint const& c) {
  return {{{{c.wheelset, 1.0, 0.0, -c.wheel_radius}, {c.roller, -1.0, 0.0, -c.roller_radius}}}, 0.0, c.rate};
}

}  // namespace

StateMap::StateMap(std::vector<Body> const& bodies, std::size_t inner_nodes) : nodes(static_cast<int>(inner_nodes)) {
  std::size_t const n = bodies.size();
  coordinate.assign(n, {-1, -1, -1, -1, -1, -1});
  rate.assign(n, {-1, -1, -1, -1, -1, -1});
  angle.assign(n, -1);
  for (std::size_t b = 0; b < n; ++b)
    for (std::size_t c = 0; c < 6; ++c) {
      if (bodies[b].locked[c]) continue;
      if (c == coord_pitch && bodies[b].axisymmetric)
        angle[b] = angles++;
      else
        coordinate[b][c] = coordinates++;
    }
  for (std::size_t b = 0; b < n; ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (!bodies[b].locked[c]) rate[b][c] = coordinates + rates++;
  velocity_column.assign(at(coordinates), -1);
  for (std::size_t b = 0; b < n; ++b)
    for (std::size_t c = 0; c < 6; ++c)
      if (coordinate[b][c] >= 0) velocity_column[at(coordinate[b][c])] = rate[b][c];
}

ModelBuilder::ModelBuilder(double gravity) { set_gravity(gravity); }

void ModelBuilder::set_gravity(double gravity) {
  need_finite({gravity}, "gravity");
  model_.gravity = gravity;
}

void ModelBuilder::check_body(int body, std::string const& what, bool may_be_ground) const {
  bool const known = body >= 0 && body < static_cast<int>(model_.bodies.size());
  need(known || (may_be_ground && body == ground), what + ": there is no body " + std::to_string(body));
}

int ModelBuilder::add_body(Body const& body) {
  std::string const what = number("body", model_.bodies.size());
  need_positive(body.mass, what + ": mass");
  for (double moment : {body.inertia.x, body.inertia.y, body.inertia.z}) need_positive(moment, what + ": inertia");
  need_finite({body.position.x, body.position.y, body.position.z}, what + ": position");
  need(body.speed_controlled_radius >= 0.0, what + ": speed_controlled_radius must not be negative");
  model_.bodies.push_back(body);
  return static_cast<int>(model_.bodies.size()) - 1;
}

int ModelBuilder::add_element(ForceElement const& element) {
  std::string const what = number("element", model_.elements.size());
  check_body(element.body_a, what + ": body_a", true);
  check_body(element.body_b, what + ": body_b", true);
  need_finite({element.r_b.x, element.r_b.y, element.r_b.z}, what + ": point_on_b");
  ForceElement& added = model_.elements.emplace_back(element);
  for (std::size_t c = 0; c < 6; ++c) {
    added.node[c] = static_cast<int>(model_.nodes.size());
    need_finite({added.law[c].preload}, what + ": preload");
    for (ForceLaw const& law : added.law[c].laws) {
      std::visit([&](auto const& chosen) { need_law(chosen, what + ": "); }, law);
      if (auto const node = inner_node(law)) model_.nodes.push_back(*node);
    }
  }
  added.node.back() = static_cast<int>(model_.nodes.size());
  for (int c : {coord_roll, coord_pitch, coord_yaw}) added.rotational |= added.law[at(c)].active();
  return static_cast<int>(model_.elements.size()) - 1;
}

int ModelBuilder::add_profile(UniformSpline const& profile) {
  need_spline(profile, number("profile", profiles_.size()));
  profiles_.push_back(std::make_shared<UniformSpline const>(profile));
  model_.tables.push_back(profiles_.back());
  return static_cast<int>(profiles_.size()) - 1;
}

int ModelBuilder::add_contact(ContactDescription const& d) {
  std::string const what = number("contact", model_.contacts.size());
  check_body(d.wheelset, what + ": wheelset");
  check_body(d.roller, what + ": roller", d.roller_radius == 0.0);
  for (int profile : {d.wheel_profile, d.rail_profile})
    need(profile >= 0 && profile < static_cast<int>(profiles_.size()),
         what + ": there is no profile " + std::to_string(profile));
  need_positive(d.wheel_radius, what + ": wheel_radius");
  need_positive(d.size, what + ": size");
  Body const& wheelset = model_.bodies[at(d.wheelset)];
  bool const rail = d.roller_radius == 0.0;

  WheelContact c;
  c.wheelset = d.wheelset, c.roller = d.roller, c.right = d.right, c.rail = rail;
  c.distance_ahead = wheelset.position.x;
  c.wheelset_from_crown = {0.0, wheelset.position.y, wheelset.position.z};
  if (d.roller != ground) {
    Body const& roller = model_.bodies[at(d.roller)];
    need(std::abs(roller.position.z + d.roller_radius) < 1e-9, what + ": the crown of its roller is not at z = 0");
    c.crown_in_roller = {wheelset.position.x - roller.position.x, -roller.position.y, d.roller_radius};
  }
  c.pair = {profiles_[at(d.wheel_profile)].get(),
            profiles_[at(d.rail_profile)].get(),
            d.wheel_radius,
            d.tape_circle_y,
            d.rail_origin_y,
            rail ? 0.0 : 1.0 / d.roller_radius,
            d.laws.roller,
            d.size};
  c.laws = d.laws;
  auto& kalker = kalker_[d.laws.material.poisson_ratio];
  if (!kalker) kalker = std::make_shared<KalkerTable const>(d.laws.material.poisson_ratio);
  c.laws.kalker = kalker;
  if (std::holds_alternative<ElasticStrips>(d.laws.normal)) {
    auto& arc = arcs_[d.wheel_profile];
    if (!arc) arc = std::make_shared<ArcLength const>(*c.pair.wheel);
    c.laws.wheel_arc = arc;
  }
  c.flange_tip = flange_tip(*c.pair.wheel, d.size);
  model_.contacts.push_back(c);
  return static_cast<int>(model_.contacts.size()) - 1;
}

int ModelBuilder::add_axle_torque(AxleTorque const& torque) {
  std::string const what = number("axle torque", model_.axle_torques.size());
  check_body(torque.wheelset, what + ": wheelset");
  check_body(torque.reaction, what + ": reaction", true);
  need_table(torque.torque.points, what);
  need(torque.link == 0.0 || torque.reaction != ground, what + ": a link needs a body to hang on");
  AxleTorque& added = model_.axle_torques.emplace_back(torque);
  auto const x = [&](int body) { return model_.bodies[at(body)].position.x; };
  if (torque.link != 0.0) added.link_on_reaction = x(torque.wheelset) + torque.link - x(torque.reaction);
  return static_cast<int>(model_.axle_torques.size()) - 1;
}

int ModelBuilder::add_roller_torque(RollerTorque const& torque) {
  std::string const what = number("roller torque", model_.roller_torques.size());
  check_body(torque.roller, what + ": roller");
  need_table(torque.torque.points, what);
  model_.roller_torques.push_back(torque);
  return static_cast<int>(model_.roller_torques.size()) - 1;
}

int ModelBuilder::add_brake(AxleBrake const& brake) {
  std::string const what = number("brake", model_.brakes.size());
  check_body(brake.wheelset, what + ": wheelset");
  check_body(brake.reaction, what + ": reaction", true);
  model_.brakes.push_back(brake);
  return static_cast<int>(model_.brakes.size()) - 1;
}

int ModelBuilder::add_rolling_constraint(int wheelset) {
  RollingConstraint added;
  int wheels = 0;
  for (WheelContact const& c : model_.contacts) {
    if (c.wheelset != wheelset) continue;
    need(!c.rail && (wheels == 0 || c.roller == added.roller),
         "rolling constraint: both wheels must stand on one roller");
    added = {wheelset, c.roller, c.pair.wheel_radius, c.roller_radius()};
    ++wheels;
  }
  need(wheels == 2, "rolling constraint: body " + std::to_string(wheelset) + " has not two wheels");
  model_.rolling_constraints.push_back(added);
  return static_cast<int>(model_.rolling_constraints.size()) - 1;
}

void ModelBuilder::set_adhesion(int contact, std::shared_ptr<AdhesionMap const> const& map) {
  need(contact >= 0 && contact < static_cast<int>(model_.contacts.size()),
       "adhesion map: there is no contact " + std::to_string(contact));
  map->check();
  model_.contacts[at(contact)].laws.friction.map = map;
}

void ModelBuilder::set_contact_loss_limit(double duration) {
  need_positive(duration, "contact_loss_limit");
  model_.contact_loss_limit = duration;
}

void ModelBuilder::set_resistance(RunningResistance const& resistance) {
  check_body(resistance.body, "running resistance: body", true);
  need_finite({resistance.constant, resistance.linear, resistance.quadratic, resistance.gradient},
              "running resistance");
  model_.resistance = resistance;
}

void ModelBuilder::set_speed(TimeTable const& speed) {
  need_table(speed.points, "speed");
  model_.speed = speed;
}

void ModelBuilder::set_line(Line const& line, double start) {
  need_increasing(line.curvature, "curvature");
  need_increasing(line.cant, "cant");
  need_positive(line.cant_base, "cant_base");
  model_.line = line;
  model_.start = start;
}

void ModelBuilder::set_irregularity(Irregularity const& irregularity) {
  for (auto const* curve : {&irregularity.left_y, &irregularity.left_z, &irregularity.right_y, &irregularity.right_z}) {
    need_spline(*curve, "irregularity");
    need(std::abs(curve->end() - irregularity.period) <= 1e-9 * irregularity.period,
         "irregularity: each curve must have period / step pieces");
  }
  model_.irregularity = irregularity;
}

std::shared_ptr<Model const> ModelBuilder::finish() const {
  auto model = std::make_shared<Model>(model_);
  model->map = StateMap(model->bodies, model->nodes.size());
  for (WheelContact const& c : model->contacts) {
    model->on_rails = model->on_rails || c.rail;
    model->on_adhesion_map = model->on_adhesion_map || c.laws.friction.map != nullptr;
    model->foremost_wheel = std::max(model->foremost_wheel, c.distance_ahead);
  }
  for (Body const& b : model->bodies) {
    model->rear = std::min(model->rear, b.position.x);
    model->front = std::max(model->front, b.position.x);
  }
  for (AxleTorque const& t : model->axle_torques)
    if (t.rotor_inertia > 0.0) model->couplings.push_back(rotor_of(t));
  for (RollerTorque const& t : model->roller_torques)  // its casing is fixed to the ground
    if (t.rotor_inertia > 0.0)
      model->couplings.push_back({{{{t.roller, 0.0, 0.0, t.gear_ratio}, {}}}, t.rotor_inertia, 0.0});
  model->rotors = model->couplings.size();
  model->constraint_of_contact.assign(model->contacts.size(), -1);
  for (std::size_t i = 0; i < model->rolling_constraints.size(); ++i) {
    model->couplings.push_back(coupling_of(model->rolling_constraints[i]));
    for (std::size_t c = 0; c < model->contacts.size(); ++c)
      if (model->contacts[c].wheelset == model->rolling_constraints[i].wheelset)
        model->constraint_of_contact[c] = static_cast<int>(i);
  }
  model->coupling_matrix = coupling_matrix(model->couplings, model->bodies);
  return model;
}

std::shared_ptr<Model const> with_speed(Model const& model, TimeTable const& speed) {
  need_table(speed.points, "speed");
  auto copy = std::make_shared<Model>(model);
  copy->speed = speed;
  return copy;
}

}  // namespace rollerrig
