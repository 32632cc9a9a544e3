#include "rollerrig/simulate/recorder.hpp"

#include "rollerrig/simulate/recorded_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rollerrig {
namespace {

constexpr Field body_table[] = {
    {"longitudinal", "m", "longitudinal displacement from the design position"},
    {"lateral", "m", "lateral displacement from the design position, positive to the left"},
    {"vertical", "m", "vertical displacement from the design position, positive upwards"},
    {"roll", "rad", "roll angle about the running direction"},
    {"pitch", "rad", "pitch angle; of wheelsets and rollers the angle turned since the start"},
    {"yaw", "rad", "yaw angle, positive to the left"},
    {"longitudinal_velocity", "m/s", "longitudinal velocity"},
    {"lateral_velocity", "m/s", "lateral velocity"},
    {"vertical_velocity", "m/s", "vertical velocity"},
    {"roll_rate", "rad/s", "roll rate"},
    {"pitch_rate", "rad/s", "pitch rate; of wheelsets and rollers the spin"},
    {"yaw_rate", "rad/s", "yaw rate"},
    {"longitudinal_acceleration", "m/s^2", "longitudinal acceleration"},
    {"lateral_acceleration", "m/s^2", "lateral acceleration"},
    {"vertical_acceleration", "m/s^2", "vertical acceleration"},
    {"roll_acceleration", "rad/s^2", "second derivative of the roll angle"},
    {"pitch_acceleration", "rad/s^2", "second derivative of the pitch angle"},
    {"yaw_acceleration", "rad/s^2", "second derivative of the yaw angle"},
    {"drive_torque", "N m", "torque about +y that a speed-controlled roller takes from its drive"},
    {"lateral_specific_force", "m/s^2",
     "reading of an accelerometer at the centre of mass to the left of the body; in a curve with the uncompensated "
     "part"},
    {"vertical_specific_force", "m/s^2", "the same upwards; +g at rest"},
    {"inertial_roll_rate", "rad/s",
     "angular velocity against the ground about the body's longitudinal axis, as a gyroscope fixed to it shows it: "
     "with "
     "the turning of the track; of wheelsets and rollers without the spin"},
    {"inertial_pitch_rate", "rad/s", "the same about its lateral axis"},
    {"inertial_yaw_rate", "rad/s", "the same about its vertical axis"},
    {"inertial_roll_acceleration", "rad/s^2", "rate of change of the inertial roll rate"},
    {"inertial_pitch_acceleration", "rad/s^2", "rate of change of the inertial pitch rate"},
    {"inertial_yaw_acceleration", "rad/s^2", "rate of change of the inertial yaw rate"},
};

constexpr Field wheel_table[] = {
    {"patch_count", "1", "contact patches under load"},
    {"normal_force", "N", "sum of the patches' normal forces"},
    {"longitudinal_force", "N",
     "force on the wheel along the running direction: creep force, and the normal force's part where the contact lies "
     "off "
     "the roller's crown"},
    {"longitudinal_creep_force", "N",
     "sum of the patches' creep forces on the wheel along the rolling direction, in the contact plane"},
    {"lateral_force", "N", "force on the wheel to the left (Y, positive to the left)"},
    {"vertical_force", "N", "force on the wheel upwards (Q)"},
    {"spin_moment", "N m", "sum of the patches' spin moments on the wheel"},
    {"longitudinal_sliding", "m/s", "mean over patches, weighted with normal force: wheel minus roller surface speed"},
    {"lateral_sliding", "m/s", "the same to the left"},
    {"longitudinal_creepage", "1", "longitudinal sliding over rolling speed, weighted mean"},
    {"lateral_creepage", "1", "lateral sliding over rolling speed, weighted mean"},
    {"rolling_speed", "m/s", "mean of wheel and roller surface speed, weighted mean"},
    {"creep_power", "W", "power dissipated by creep forces"},
    {"contact_abscissa", "m", "EN abscissa S of the contact on the wheel profile, weighted mean"},
    {"rolling_radius", "m", "wheel radius at the contact, weighted mean"},
    {"wear_number", "N", "heat of creep per metre: sum of its patches' wear numbers"},
    {"rail_lateral", "m",
     "displacement of the rail (irregularity, gauge), or of the roller that stands for it, to the left"},
    {"rail_vertical", "m", "the same upwards"},
};

constexpr Field patch_table[] = {
    {"wheel_abscissa", "m", "EN abscissa S on the wheel profile, negative towards the flange"},
    {"rail_abscissa", "m", "abscissa on the generatrix, negative towards the gauge side"},
    {"contact_angle", "rad",
     "angle between the contact normal and the vertical, positive where the wheel is pushed to the track centre"},
    {"approach", "m", "elastic approach of the surfaces"},
    {"normal", "N", "normal force"},
    {"a", "m", "semi-axis along the rolling direction"},
    {"b", "m", "semi-axis across the rolling direction"},
    {"creepage_x", "1", "longitudinal creepage"},
    {"creepage_y", "1", "lateral creepage, positive to the left"},
    {"creepage_spin", "1/m", "spin creepage about the normal out of the roller"},
    {"creep_force_x", "N", "tangential force on the wheel along the rolling direction"},
    {"creep_force_y", "N", "tangential force on the wheel across it, positive to the left"},
    {"creep_moment", "N m", "spin moment on the wheel about the normal out of the roller"},
    {"saturation", "1", "factor that reduces the linear creep force"},
    {"sliding_x", "m/s", "longitudinal sliding, wheel minus roller"},
    {"sliding_y", "m/s", "lateral sliding, positive to the left"},
    {"wear_number", "N", "creep forces and moment times creepages: heat of creep per metre"},
};

constexpr Field element_table[] = {
    {"force_x", "N", "force on the element's second body along x of its first body"},
    {"force_y", "N", "the same along y"},
    {"force_z", "N", "the same along z"},
    {"moment_roll", "N m", "moment on the second body conjugate to the relative roll angle"},
    {"moment_pitch", "N m", "moment conjugate to the relative pitch angle"},
    {"moment_yaw", "N m", "moment conjugate to the relative yaw angle"},
};

constexpr Field run_table[] = {
    {"energy_kinetic", "J", "kinetic energy of all bodies"},
    {"energy_gravity", "J", "potential energy of weight over the design position"},
    {"energy_elements", "J", "elastic energy of the force elements, preload included"},
    {"energy_work_of_drive", "J", "work put in by roller drives or moving rails since the start"},
    {"energy_work_of_torque", "J", "work put in by axle torques"},
    {"energy_dissipated_elements", "J", "heat in the force elements' dampers"},
    {"energy_dissipated_normal", "J", "heat in the normal damping of the contacts"},
    {"energy_dissipated_creep", "J", "heat of creep and sliding in the contacts"},
    {"energy_dissipated_brakes", "J", "heat in the friction brakes"},
    {"energy_stored_contacts", "J", "work done against the contacts' elastic normal force"},
    {"distance", "m",
     "arc length of the vehicle's reference point along the line; on a rig how much of the rollers' crowns has passed "
     "under "
     "the wheels since the start, mean over the wheels"},
    {"curvature", "1/m", "plan curvature of the line there, positive to the left"},
    {"cant", "m", "cant there, positive with the right rail raised"},
    {"speed", "m/s", "running speed: mean crown speed of the rollers, or speed of the vehicle on track"},
};

constexpr std::string_view reading_table[] = {"lateral_force", "vertical_force", "wear_number"};

double const nan = std::numeric_limits<double>::quiet_NaN();

void record_body(Dynamics const& d, std::size_t b, double const* z, double* out) {
  static_assert(body_columns == std::size(body_table));
  body_row(d.model(), d.work(), b, out);
  if (int const angle = d.map().angle[b]; angle >= 0) out[coord_pitch] = z[angle];
}

void record_patch(Patch<double> const& p, double side, double* out) {
  double const row[] = {p.point.wheel_s,
                        p.point.rail_y,
                        std::atan2(p.point.n.y, p.point.n.z) * -1.0,
                        -p.point.gap,
                        p.normal.total(),
                        p.a,
                        p.b,
                        p.creepage.longitudinal,
                        side * p.creepage.lateral,
                        side * p.creepage.spin,
                        p.creep.longitudinal,
                        side * p.creep.lateral,
                        side * p.creep.spin_moment,
                        p.creep.saturation,
                        p.slip_longitudinal,
                        side * p.slip_lateral,
                        p.wear_number()};
  static_assert(std::size(row) == std::size(patch_table));
  std::copy(std::begin(row), std::end(row), out);
}

void record_wheel(Dynamics const& d, int wheel, double* out) {
  static_assert(wheel_columns == std::size(wheel_table));
  wheel_row(d.model(), d.work(), at(wheel), out);
}

}  // namespace

std::span<Field const> Recorder::body_fields() { return body_table; }
std::span<Field const> Recorder::wheel_fields() { return wheel_table; }
std::span<Field const> Recorder::patch_fields() { return patch_table; }
std::span<Field const> Recorder::element_fields() { return element_table; }
std::span<Field const> Recorder::run_fields() { return run_table; }
std::span<std::string_view const> Recorder::reading_fields() { return reading_table; }

Recorder::Recorder(Model const& model)
    : bodies_{static_cast<int>(model.bodies.size())},
      wheels_{static_cast<int>(model.contacts.size())},
      elements_{static_cast<int>(model.elements.size())},
      width_{bodies_ * static_cast<int>(std::size(body_table)) + wheels_ * static_cast<int>(std::size(wheel_table)) +
             wheels_ * patches * static_cast<int>(std::size(patch_table)) +
             elements_ * static_cast<int>(std::size(element_table)) + static_cast<int>(std::size(run_table))} {}

void Recorder::record(Dynamics& d, double t, double const* x, double const* z, double* row,
                      Inputs const& inputs) const {
  d.evaluate(t, x, inputs);
  for (int b = 0; b < bodies_; ++b, row += std::size(body_table)) record_body(d, at(b), z, row);
  for (int w = 0; w < wheels_; ++w, row += std::size(wheel_table)) record_wheel(d, w, row);
  for (int w = 0; w < wheels_; ++w) {
    double const side = d.model().contacts[at(w)].right ? -1.0 : 1.0;
    for (int k = 0; k < patches; ++k, row += std::size(patch_table)) {
      std::fill_n(row, std::size(patch_table), nan);
      if (k < d.patch_count(w)) record_patch(d.patch(w, k), side, row);
    }
  }
  for (int e = 0; e < elements_; ++e, row += std::size(element_table))
    std::ranges::copy(d.evaluation().element_force[at(e)], row);
  row[0] = kinetic_energy(d);
  row[1] = gravity_energy(d);
  row[2] = element_energy(d);
  std::copy_n(z + d.map().angles, account_count, row + 3);
  row += 3 + account_count;
  auto const running = running_motion(d, t, z, inputs);
  row[0] = running.s;
  row[1] = d.model().line.curvature.at(running.s).value;
  row[2] = d.model().line.cant.at(running.s).value;
  row[3] = running.speed;
}

void Recorder::record_reading(Dynamics& d, double t, double const* x, double const* z, double* row,
                              Inputs const& inputs) const {
  d.evaluate(t, x, inputs);
  for (int w = 0; w < wheels_; ++w, row += std::size(reading_table)) {
    Vec3<double> const force = track_force(d.model(), d.work(), at(w));
    double wear = 0.0;
    for (int k = 0; k < d.patch_count(w); ++k) wear += d.patch(w, k).wear_number();
    double const side = d.model().contacts[at(w)].right ? -1.0 : 1.0;
    double const values[] = {side * force.y, force.z, wear};
    static_assert(std::size(values) == std::size(reading_table));
    std::ranges::copy(values, row);
  }
  *row = running_motion(d, t, z, inputs).s;
}

}  // namespace rollerrig
