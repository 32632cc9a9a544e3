#include "rollerrig/system/model.hpp"

#include <cmath>
#include <map>

#include "rollerrig/geometry/gap_nodes.hpp"
#include "rollerrig/math/lu.hpp"

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

constexpr double widest_profile = 10.0;  ///< over the size of its contact [m]
constexpr Range on_profile{-10.0, 10.0, "within 10 m"};
constexpr Range profile_slope{-1e3, 1e3, "at most 1000"};

/// A profile is searched cell by cell: where it lies and how long its arc is must stay within reason.
void check_profile(UniformSpline const& profile, std::string const& what) {
  for (double end : {profile.start, profile.end()}) check_value(end, on_profile, what, "start and end");
  for (auto const& [c0, c1, c2, c3] : profile.pieces) {
    double const h = profile.step;
    for (double z : {c0, c0 + h * (c1 + h * (c2 + h * c3))}) check_value(z, on_profile, what, "pieces: height");
    for (double slope : {c1, c1 + h * (2.0 * c2 + 3.0 * h * c3)})
      check_value(slope, profile_slope, what, "pieces: slope");
  }
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

/// The inverse of G, with 1/J on the diagonal of rotors.
Eigen::MatrixXd coupling_matrix(std::vector<Coupling> const& couplings, std::vector<Body> const& bodies) {
  auto const n = static_cast<Eigen::Index>(couplings.size());
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    Coupling const& own = couplings[at(i)];
    if (own.inertia > 0.0) G(i, i) = 1.0 / own.inertia;
    for (Eigen::Index k = 0; k < n; ++k)
      for (CouplingTerm const& a : own.term)
        for (CouplingTerm const& b : couplings[at(k)].term) {
          if (a.body < 0 || a.body != b.body) continue;
          Body const& body = bodies[at(a.body)];
          if (!body.locked[coord_x]) G(i, k) += a.x * b.x / body.mass;
          if (!body.locked[coord_z]) G(i, k) += a.z * b.z / body.mass;
          if (!body.locked[coord_pitch] && !body.speed_controlled()) G(i, k) += a.pitch * b.pitch / body.inertia.y;
        }
  }
  return G.inverse();
}

// ------------------------------------------------------------------------------ checks: every index, size and number

void need_body(ModelParts const& parts, int body, std::string const& what, bool may_be_ground = false) {
  bool const known = body >= 0 && body < static_cast<int>(parts.bodies.size());
  need(known || (may_be_ground && body == ground), what + ": there is no body " + std::to_string(body));
}

void check_element(ModelParts const& parts, ForceElement const& element, std::string const& what) {
  need_body(parts, element.body_a, what + ": body_a", true);
  need_body(parts, element.body_b, what + ": body_b", true);
  check_fields(element, what);
  for (DirectionLaw const& direction : element.law) {
    check_fields(direction, what);
    for (ForceLaw const& law : direction.laws)
      std::visit([&](auto const& chosen) { need_law(chosen, what + ": "); }, law);
  }
}

void check_contact(ModelParts const& parts, ContactDescription const& d, std::string const& what) {
  need_body(parts, d.wheelset, what + ": wheelset");
  need_body(parts, d.roller, what + ": roller", d.roller_radius == 0.0);
  check_fields(d, what);
  for (int const i : {d.wheel_profile, d.rail_profile}) {
    need(i < static_cast<int>(parts.profiles.size()), what + ": there is no profile " + std::to_string(i));
    UniformSpline const& profile = parts.profiles[at(i)];
    need(profile.end() - profile.start <= widest_profile * d.size,
         what + ": size is too small for profile " + std::to_string(i));
  }
  if (d.friction.map) d.friction.map->check();
  need(!d.friction.map == !parts.described_contacts.front().friction.map,
       what + ": friction by a map is that of all contacts or of none");
  need(d.roller == ground || d.roller_radius == 0.0 ||
           std::abs(parts.bodies[at(d.roller)].position.z + d.roller_radius) < 1e-9,
       what + ": the crown of its roller is not at z = 0");
}

void check_machines(ModelParts const& parts) {
  for (std::size_t i = 0; i < parts.axle_torques.size(); ++i) {
    AxleTorque const& torque = parts.axle_torques[i];
    std::string const what = number("axle torque", i);
    need_body(parts, torque.wheelset, what + ": wheelset");
    need_body(parts, torque.reaction, what + ": reaction", true);
    check_fields(torque, what);
    need(torque.link == 0.0 || torque.reaction != ground, what + ": a link needs a body to hang on");
  }
  for (std::size_t i = 0; i < parts.roller_torques.size(); ++i) {
    need_body(parts, parts.roller_torques[i].roller, number("roller torque", i) + ": roller");
    check_fields(parts.roller_torques[i], number("roller torque", i));
  }
  for (std::size_t i = 0; i < parts.brakes.size(); ++i) {
    need_body(parts, parts.brakes[i].wheelset, number("brake", i) + ": wheelset");
    need_body(parts, parts.brakes[i].reaction, number("brake", i) + ": reaction", true);
  }
  for (std::size_t i = 0; i < parts.track_brakes.size(); ++i)
    need_body(parts, parts.track_brakes[i].body, number("track brake", i) + ": body");
}

void check_resistance(ModelParts const& parts) {
  RunningResistance const& resistance = parts.resistance;
  need_body(parts, resistance.body, "running resistance: body", true);
  check_fields(resistance, "running resistance");
  constexpr Range newton{0.0, 1e9, "within 1e9 N", false, false, true};
  constexpr Range per_speed{0.0, 1e6, "within 1e6 N s/m, N s^2/m^2", false, false, true};
  check_value(resistance.constant, newton, "running resistance", "constant");
  check_value(resistance.linear, per_speed, "running resistance", "linear");
  check_value(resistance.quadratic, per_speed, "running resistance", "quadratic");
}

void check_rail(RailLayout const& rail, std::string const& owner) {
  check_fields(rail, owner);
  constexpr Range near{0.0, 1.0, "within 1 m or rad", false, false, true};
  for (PiecewiseCubic const* curve : {&rail.y, &rail.z, &rail.roll})
    for (auto const& row : curve->coefficient) check_value(row[0], near, owner, "displacement");
}

void check_heads(ModelParts const& parts, RailHeads const& heads) {
  check_fields(heads, "heads");
  auto const last = static_cast<double>(heads.profiles.size()) - 1.0;
  for (auto const& row : heads.place.coefficient)
    need(row[0] >= 0.0 && row[0] <= last, "heads: place must be between the first and the last of them");
  need(heads.profiles.empty() == heads.place.empty(), "heads: place and profiles are needed together");
  for (int const i : heads.profiles) {
    need(i < static_cast<int>(parts.profiles.size()), "heads: there is no profile " + std::to_string(i));
    UniformSpline const &one = parts.profiles[at(i)], &first = parts.profiles[at(heads.profiles.front())];
    need(one.start == first.start && one.step == first.step && one.pieces.size() == first.pieces.size(),
         "heads: profile " + std::to_string(i) + " must have the knots of the first");
  }
  need(heads.empty() || std::holds_alternative<ElasticStrips>(parts.laws.normal),
       "heads that change need elastic strips: one rise for all patches of a wheel is for patches that move little");
}

void check_irregularity(Irregularity const& irregularity) {
  check_fields(irregularity, "irregularity");
  auto const need_rail = [&](UniformSpline const& curve, std::string const& name) {
    std::string const what = "irregularity: " + name;
    need(curve.start == 0.0, what + " must start at 0");
    need(std::abs(curve.end() - irregularity.period) <= 1e-9 * irregularity.period,
         what + " must have period / step pieces");
    constexpr Range displacement{0.0, 10.0, "within 10 m", false, false, true};
    for (auto const& c : curve.pieces)
      for (double const s : {0.0, curve.step})
        check_value(c[0] + s * (c[1] + s * (c[2] + s * c[3])), displacement, what, "displacements");
  };
  need_rail(irregularity.left_y, "left_y");
  need_rail(irregularity.left_z, "left_z");
  need_rail(irregularity.right_y, "right_y");
  need_rail(irregularity.right_z, "right_z");
}

void check_parts(ModelParts const& parts) {
  check_fields(parts, "model");
  for (std::size_t i = 0; i < parts.bodies.size(); ++i) check_fields(parts.bodies[i], number("body", i));
  for (std::size_t i = 0; i < parts.elements.size(); ++i) check_element(parts, parts.elements[i], number("element", i));
  for (std::size_t i = 0; i < parts.profiles.size(); ++i) check_profile(parts.profiles[i], number("profile", i));
  for (std::size_t i = 0; i < parts.described_contacts.size(); ++i)
    check_contact(parts, parts.described_contacts[i], number("contact", i));
  check_machines(parts);
  check_resistance(parts);
  check_fields(parts.line, "line");
  check_rail(parts.line.left, "line: left rail");
  check_rail(parts.line.right, "line: right rail");
  if (parts.irregularity) check_irregularity(*parts.irregularity);
  check_heads(parts, parts.left_heads);
  check_heads(parts, parts.right_heads);
}

// ------------------------------------------------------------------------------ what follows from the parts

void place_nodes(Model& model) {
  for (ForceElement& element : model.elements) {
    for (std::size_t c = 0; c < 6; ++c) {
      element.node[c] = static_cast<int>(model.nodes.size());
      for (ForceLaw const& law : element.law[c].laws)
        if (auto const node = inner_node(law)) model.nodes.push_back(*node);
    }
    element.node.back() = static_cast<int>(model.nodes.size());
    element.rotational = std::ranges::any_of(std::array{coord_roll, coord_pitch, coord_yaw},
                                             [&](int c) { return element.law[at(c)].active(); });
  }
}

/// Wheels of one profile and size have their tables in common.
void place_contacts(Model& model) {
  struct WheelTables {
    std::shared_ptr<GapNodes const> nodes;
    double flange_tip;
  };
  std::map<std::pair<int, double>, WheelTables> tables;
  model.laws.kalker = std::make_shared<KalkerTable const>(model.laws.material.poisson_ratio);
  for (UniformSpline const& profile : model.profiles)
    model.splines.push_back(std::make_shared<UniformSpline const>(profile));
  for (ContactDescription const& d : model.described_contacts) {
    Vec3<double> const& wheelset = model.bodies[at(d.wheelset)].position;
    WheelContact& c = model.contacts.emplace_back(WheelContact{d});
    c.rail = d.roller_radius == 0.0;
    c.distance_ahead = wheelset.x;
    c.wheelset_from_crown = {0.0, wheelset.y, wheelset.z};
    if (d.roller != ground) {
      Vec3<double> const& roller = model.bodies[at(d.roller)].position;
      c.crown_in_roller = {wheelset.x - roller.x, -roller.y, c.rail ? -roller.z : d.roller_radius};
    }
    c.pair = {model.splines[at(d.wheel_profile)].get(),
              model.splines[at(d.rail_profile)].get(),
              d.wheel_radius,
              d.tape_circle_y,
              d.rail_origin_y,
              c.rail ? 0.0 : 1.0 / d.roller_radius,
              model.laws.roller,
              d.size};
    auto const [of, fresh] = tables.try_emplace({d.wheel_profile, d.size});
    if (fresh)
      of->second = {std::make_shared<GapNodes const>(*c.pair.wheel, d.size), flange_tip(*c.pair.wheel, d.size)};
    c.nodes = of->second.nodes, c.flange_tip = of->second.flange_tip;
    model.on_rails = model.on_rails || c.rail;
    model.on_adhesion_map = c.friction.map != nullptr;
    model.foremost_wheel = std::max(model.foremost_wheel, c.distance_ahead);
  }
}

RollingConstraint rolling_constraint(Model const& model, int wheelset) {
  RollingConstraint found;
  int wheels = 0;
  for (WheelContact const& c : model.contacts) {
    if (c.wheelset != wheelset) continue;
    need(!c.rail && (wheels == 0 || c.roller == found.roller),
         "rolling constraint: both wheels must stand on one roller");
    found = {wheelset, c.roller, c.pair.wheel_radius, c.roller_radius};
    ++wheels;
  }
  need(wheels == 2, "rolling constraint: body " + std::to_string(wheelset) + " has not two wheels");
  for (int body : {wheelset, found.roller})
    need(!model.bodies[at(body)].locked[coord_pitch],
         "rolling constraint: body " + std::to_string(body) + " cannot turn");
  return found;
}

void couple(Model& model) {
  for (AxleTorque& t : model.axle_torques) {
    auto const x = [&](int body) { return model.bodies[at(body)].position.x; };
    if (t.link != 0.0) t.link_on_reaction = x(t.wheelset) + t.link - x(t.reaction);
    if (t.rotor_inertia > 0.0) model.couplings.push_back(rotor_of(t));
  }
  for (RollerTorque const& t : model.roller_torques)  // its casing is fixed to the ground
    if (t.rotor_inertia > 0.0)
      model.couplings.push_back({{{{t.roller, 0.0, 0.0, t.gear_ratio}, {}}}, t.rotor_inertia, 0.0});
  model.rotors = model.couplings.size();
  model.constraint_of_contact.assign(model.contacts.size(), -1);
  for (int const wheelset : model.rolling_wheelsets) {
    for (std::size_t c = 0; c < model.contacts.size(); ++c)
      if (model.contacts[c].wheelset == wheelset)
        model.constraint_of_contact[c] = static_cast<int>(model.rolling_constraints.size());
    model.rolling_constraints.push_back(rolling_constraint(model, wheelset));
    model.couplings.push_back(coupling_of(model.rolling_constraints.back()));
  }
  model.coupling_matrix = coupling_matrix(model.couplings, model.bodies);
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

std::shared_ptr<Model const> model_of(ModelParts const& parts) {
  check_parts(parts);
  auto model = std::make_shared<Model>(parts);
  place_nodes(*model);
  place_contacts(*model);
  couple(*model);
  model->map = StateMap(model->bodies, model->nodes.size());
  for (Body const& b : model->bodies) {
    model->rear = std::min(model->rear, b.position.x);
    model->front = std::max(model->front, b.position.x);
  }
  return model;
}

std::shared_ptr<Model const> with_speed(Model const& model, TimeTable const& speed) {
  check_value(speed, finite_number, "model", "speed");
  auto copy = std::make_shared<Model>(model);
  copy->speed = speed;
  return copy;
}

}  // namespace rollerrig
