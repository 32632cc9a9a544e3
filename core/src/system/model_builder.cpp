#include "rollerrig/system/model_builder.hpp"

#include <cmath>
#include <stdexcept>

#include "rollerrig/geometry/gap_nodes.hpp"

namespace rollerrig {
namespace {

/// Of an inner node: beyond it a step of any length looks infinitely long to it, and an error estimate loses its digits.
constexpr Range relaxation_rate{0.0, 1e12, "at most 1e12"};

/// What a law with an inner node divides by.
template <NamedLaw Law>
void need_law(Law const& law, std::string const& what) {
  check_fields(law, what + Law::name);
  if constexpr (HasNode<Law>) {
    check_value(law.node().damping, positive, what + Law::name, "damping of its inner node");
    check_value(law.node().stiffness, positive, what + Law::name, "stiffness at its inner node");
    check_value(law.node().stiffness / law.node().damping, relaxation_rate, what + Law::name,
                Label{"stiffness over damping of its inner node", "1/s"});
  }
}

constexpr Range spline_step{1e-9, 1e6, "between 1e-9 and 1e6"};
constexpr double widest_profile = 10.0;  ///< over the size of its contact [m]
constexpr Range on_profile{-10.0, 10.0, "within 10 m"};
constexpr Range profile_slope{-1e3, 1e3, "at most 1000"};

void need_spline(UniformSpline const& spline, std::string const& what) {
  check_value(spline.start, finite_number, what, "start");
  check_value(spline.step, spline_step, what, "step");
  need(!spline.pieces.empty(), what + ": pieces must not be empty");
  need(spline.start + spline.step > spline.start, what + ": step must move the start");
  check_value(spline.pieces, finite_number, what, "pieces");
}
/// A profile is searched cell by cell: where it lies and how long its arc is must stay within reason.
void need_profile(UniformSpline const& profile, std::string const& what) {
  need_spline(profile, what);
  for (double end : {profile.start, profile.end()}) check_value(end, on_profile, what, "start and end");
  for (auto const& [c0, c1, c2, c3] : profile.pieces) {
    double const h = profile.step;
    for (double z : {c0, c0 + h * (c1 + h * (c2 + h * c3))}) check_value(z, on_profile, what, "pieces: height");
    for (double slope : {c1, c1 + h * (2.0 * c2 + 3.0 * h * c3)})
      check_value(slope, profile_slope, what, "pieces: slope");
  }
}
void need_curve(PiecewiseCubic const& curve, std::string const& what) {
  need(curve.start.size() == curve.coefficient.size(), what + " must have one row per break");
  check_value(curve.start, finite_number, what, "breaks");
  check_value(curve.coefficient, finite_number, what, "coefficients");
  for (std::size_t i = 1; i < curve.start.size(); ++i)
    need(curve.start[i - 1] < curve.start[i], what + ": breaks must increase");
}

std::string number(std::string const& what, std::size_t i) { return what + " " + std::to_string(i); }

/// The flange tip is the highest point of the wheel profile on the flange side; a wheel without flange has none to climb.
double flange_tip(UniformSpline const& wheel, double size) {
  double const least_height = 0.015 * size;  // [m]
  double tip = wheel.start;
  double s = wheel.start;
  for (std::size_t i = 0; i < wheel.pieces.size() && s < 0.0;
       ++i, s = wheel.start + wheel.step * static_cast<double>(i))
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

template <class V>
bool same(V const& a, V const& b) {
  return a == b;
}
template <Described V>
bool same(V const& a, V const& b);
template <class... Laws>
bool same(std::variant<Laws...> const& a, std::variant<Laws...> const& b) {
  return a.index() == b.index() && std::visit([&]<class L>(L const& law) { return same(law, std::get<L>(b)); }, a);
}
template <Described V>
bool same(V const& a, V const& b) {
  return V::fields()([&](auto const&... field) { return (same(a.*field.member, b.*field.member) && ...); });
}

/// Contacts that one call of each law may see together. Friction is asked patch by patch.
std::vector<std::vector<int>> contact_groups(std::vector<WheelContact> const& contacts) {
  std::vector<std::vector<int>> groups;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    auto const like = [&](std::vector<int> const& group) {
      ContactLaws without_friction = contacts[i].laws;
      without_friction.friction = contacts[at(group.front())].laws.friction;
      bool const both_on_map = !contacts[i].laws.friction.map == !without_friction.friction.map;
      return both_on_map && same(without_friction, contacts[at(group.front())].laws);
    };
    auto const group = std::ranges::find_if(groups, like);
    (group == groups.end() ? groups.emplace_back() : *group).push_back(static_cast<int>(i));
  }
  return groups;
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
  check_value(gravity, finite_number, "model", "gravity");
  model_.gravity = gravity;
}

void ModelBuilder::check_body(int body, std::string const& what, bool may_be_ground) const {
  bool const known = body >= 0 && body < static_cast<int>(model_.bodies.size());
  need(known || (may_be_ground && body == ground), what + ": there is no body " + std::to_string(body));
}

int ModelBuilder::add_body(Body const& body) {
  check_fields(body, number("body", model_.bodies.size()));
  model_.bodies.push_back(body);
  return static_cast<int>(model_.bodies.size()) - 1;
}

int ModelBuilder::add_element(ForceElement const& element) {
  std::string const what = number("element", model_.elements.size());
  check_body(element.body_a, what + ": body_a", true);
  check_body(element.body_b, what + ": body_b", true);
  check_fields(element, what);
  for (DirectionLaw const& direction : element.law) {
    check_fields(direction, what);
    for (ForceLaw const& law : direction.laws)
      std::visit([&](auto const& chosen) { need_law(chosen, what + ": "); }, law);
  }
  ForceElement& added = model_.elements.emplace_back(element);
  for (std::size_t c = 0; c < 6; ++c) {
    added.node[c] = static_cast<int>(model_.nodes.size());
    for (ForceLaw const& law : added.law[c].laws)
      if (auto const node = inner_node(law)) model_.nodes.push_back(*node);
  }
  added.node.back() = static_cast<int>(model_.nodes.size());
  for (int c : {coord_roll, coord_pitch, coord_yaw}) added.rotational |= added.law[at(c)].active();
  return static_cast<int>(model_.elements.size()) - 1;
}

int ModelBuilder::add_profile(UniformSpline const& profile) {
  need_profile(profile, number("profile", model_.profiles.size()));
  model_.profiles.push_back(profile);
  model_.splines.push_back(std::make_shared<UniformSpline const>(profile));
  return static_cast<int>(model_.profiles.size()) - 1;
}

int ModelBuilder::add_contact(ContactDescription const& d) {
  std::string const what = number("contact", model_.contacts.size());
  check_body(d.wheelset, what + ": wheelset");
  check_body(d.roller, what + ": roller", d.roller_radius == 0.0);
  for (int profile : {d.wheel_profile, d.rail_profile})
    need(profile >= 0 && profile < static_cast<int>(model_.profiles.size()),
         what + ": there is no profile " + std::to_string(profile));
  check_fields(d, what);
  for (int profile : {d.wheel_profile, d.rail_profile})
    need(model_.profiles[at(profile)].end() - model_.profiles[at(profile)].start <= widest_profile * d.size,
         what + ": size is too small for profile " + std::to_string(profile));
  if (d.laws.friction.map) d.laws.friction.map->check();
  Body const& wheelset = model_.bodies[at(d.wheelset)];
  bool const rail = d.roller_radius == 0.0;

  WheelContact c;
  c.wheelset = d.wheelset, c.roller = d.roller, c.right = d.right, c.rail = rail;
  c.distance_ahead = wheelset.position.x;
  c.wheelset_from_crown = {0.0, wheelset.position.y, wheelset.position.z};
  if (d.roller != ground) {
    Body const& roller = model_.bodies[at(d.roller)];
    need(rail || std::abs(roller.position.z + d.roller_radius) < 1e-9,
         what + ": the crown of its roller is not at z = 0");
    c.crown_in_roller = {wheelset.position.x - roller.position.x, -roller.position.y,
                         rail ? -roller.position.z : d.roller_radius};
  }
  c.pair = {model_.splines[at(d.wheel_profile)].get(),
            model_.splines[at(d.rail_profile)].get(),
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
  auto& nodes = nodes_[{d.wheel_profile, d.size}];
  if (!nodes) nodes = std::make_shared<GapNodes const>(*c.pair.wheel, d.size);
  c.laws.nodes = nodes;
  auto& tip = flange_tips_[{d.wheel_profile, d.size}];
  if (!tip) tip = flange_tip(*c.pair.wheel, d.size);
  c.flange_tip = *tip;
  model_.contacts.push_back(c);
  model_.described_contacts.push_back(d);
  return static_cast<int>(model_.contacts.size()) - 1;
}

int ModelBuilder::add_axle_torque(AxleTorque const& torque) {
  std::string const what = number("axle torque", model_.axle_torques.size());
  check_body(torque.wheelset, what + ": wheelset");
  check_body(torque.reaction, what + ": reaction", true);
  check_fields(torque, what);
  need(torque.link == 0.0 || torque.reaction != ground, what + ": a link needs a body to hang on");
  AxleTorque& added = model_.axle_torques.emplace_back(torque);
  auto const x = [&](int body) { return model_.bodies[at(body)].position.x; };
  if (torque.link != 0.0) added.link_on_reaction = x(torque.wheelset) + torque.link - x(torque.reaction);
  return static_cast<int>(model_.axle_torques.size()) - 1;
}

int ModelBuilder::add_roller_torque(RollerTorque const& torque) {
  std::string const what = number("roller torque", model_.roller_torques.size());
  check_body(torque.roller, what + ": roller");
  check_fields(torque, what);
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

int ModelBuilder::add_track_brake(BodyTrackBrake const& brake) {
  check_body(brake.body, number("track brake", model_.track_brakes.size()) + ": body");
  model_.track_brakes.push_back(brake);
  return static_cast<int>(model_.track_brakes.size()) - 1;
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
  for (int body : {wheelset, added.roller})
    need(wheels != 2 || !model_.bodies[at(body)].locked[coord_pitch],
         "rolling constraint: body " + std::to_string(body) + " cannot turn");
  need(wheels == 2, "rolling constraint: body " + std::to_string(wheelset) + " has not two wheels");
  model_.rolling_constraints.push_back(added);
  model_.rolling_wheelsets.push_back(wheelset);
  return static_cast<int>(model_.rolling_constraints.size()) - 1;
}

void ModelBuilder::set_adhesion(int contact, std::shared_ptr<AdhesionMap const> const& map) {
  need(contact >= 0 && contact < static_cast<int>(model_.contacts.size()),
       "adhesion map: there is no contact " + std::to_string(contact));
  need(map != nullptr, "adhesion map: there is none");
  map->check();
  for (ContactLaws* laws : {&model_.contacts[at(contact)].laws, &model_.described_contacts[at(contact)].laws})
    laws->friction.map = map;
}

void ModelBuilder::set_contact_loss_limit(double duration) {
  check_value(duration, positive, "model", "contact_loss_limit");
  model_.contact_loss_limit = duration;
}

void ModelBuilder::set_resistance(RunningResistance const& resistance) {
  check_body(resistance.body, "running resistance: body", true);
  check_fields(resistance, "running resistance");
  constexpr Range newton{0.0, 1e9, "within 1e9 N", false, false, true};
  constexpr Range per_speed{0.0, 1e6, "within 1e6 N s/m, N s^2/m^2", false, false, true};
  check_value(resistance.constant, newton, "running resistance", "constant");
  check_value(resistance.linear, per_speed, "running resistance", "linear");
  check_value(resistance.quadratic, per_speed, "running resistance", "quadratic");
  model_.resistance = resistance;
}

void ModelBuilder::set_speed(TimeTable const& speed) {
  check_value(speed, finite_number, "model", "speed");
  model_.speed = speed;
}

void ModelBuilder::set_line(Line const& line, double start) {
  need_curve(line.curvature, "curvature");
  need_curve(line.cant, "cant");
  check_value(line.cant_base, positive, "line", "cant_base");
  check_value(start, finite_number, "line", "start");
  model_.start = start;
  set_rails(line.left, line.right);
  model_.line = line;
}

void ModelBuilder::set_rails(RailLayout const& left, RailLayout const& right) {
  auto const need_layout = [](PiecewiseCubic const& curve, std::string const& what) {
    constexpr Range near{0.0, 1.0, "within 1 m or rad", false, false, true};
    need_curve(curve, what);
    for (auto const& row : curve.coefficient) check_value(row[0], near, what, "displacement");
  };
  for (bool const is_right : {false, true}) {
    std::string const side = is_right ? "rails: right_" : "rails: left_";
    RailLayout const& rail = is_right ? right : left;
    need_layout(rail.y, side + "y");
    need_layout(rail.z, side + "z");
    need_layout(rail.roll, side + "roll");
  }
  model_.line.left = left, model_.line.right = right;
}

void ModelBuilder::set_heads(RailHeads const& left, RailHeads const& right) {
  for (RailHeads const* heads : {&left, &right}) {
    check_value(heads->period, not_negative, "heads", "period");
    check_value(heads->profiles, an_index, "heads", "profiles");
    need_curve(heads->place, heads == &left ? "heads: left_place" : "heads: right_place");
    auto const last = static_cast<double>(heads->profiles.size()) - 1.0;
    for (auto const& row : heads->place.coefficient)
      need(row[0] >= 0.0 && row[0] <= last, "heads: place must be between the first and the last of them");
    need(heads->profiles.empty() == heads->place.empty(), "heads: place and profiles are needed together");
    for (int const i : heads->profiles) {
      need(i < static_cast<int>(model_.profiles.size()), "heads: there is no profile " + std::to_string(i));
      UniformSpline const &one = model_.profiles[at(i)], &first = model_.profiles[at(heads->profiles.front())];
      need(one.start == first.start && one.step == first.step && one.pieces.size() == first.pieces.size(),
           "heads: profile " + std::to_string(i) + " must have the knots of the first");
    }
  }
  model_.left_heads = left, model_.right_heads = right;
}

void ModelBuilder::set_irregularity(Irregularity const& irregularity) {
  check_value(irregularity.period, positive, "irregularity", "period");
  check_value(irregularity.fade_in, not_negative, "irregularity", "fade_in");
  auto const need_curve_of = [&](UniformSpline const& curve, std::string const& name) {
    std::string const what = "irregularity: " + name;
    need_spline(curve, what);
    need(curve.start == 0.0, what + " must start at 0");
    need(std::abs(curve.end() - irregularity.period) <= 1e-9 * irregularity.period,
         what + " must have period / step pieces");
    constexpr Range displacement{0.0, 10.0, "within 10 m", false, false, true};
    for (auto const& c : curve.pieces)
      for (double const s : {0.0, curve.step})
        check_value(c[0] + s * (c[1] + s * (c[2] + s * c[3])), displacement, what, "displacements");
  };
  need_curve_of(irregularity.left_y, "left_y");
  need_curve_of(irregularity.left_z, "left_z");
  need_curve_of(irregularity.right_y, "right_y");
  need_curve_of(irregularity.right_z, "right_z");
  model_.irregularity = irregularity;
}

std::shared_ptr<Model const> ModelBuilder::finish() const {
  auto model = std::make_shared<Model>(model_);
  model->contact_groups = contact_groups(model->contacts);
  model->map = StateMap(model->bodies, model->nodes.size());
  for (WheelContact const& c : model->contacts) {
    model->on_rails = model->on_rails || c.rail;
    model->on_adhesion_map = model->on_adhesion_map || c.laws.friction.map != nullptr;
    model->foremost_wheel = std::max(model->foremost_wheel, c.distance_ahead);
    need(!model->changes_heads() || std::holds_alternative<ElasticStrips>(c.laws.normal),
         "heads that change need elastic strips: one rise for all patches of a wheel is for patches that move little");
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
  check_value(speed, finite_number, "model", "speed");
  auto copy = std::make_shared<Model>(model);
  copy->speed = speed;
  return copy;
}

}  // namespace rollerrig
