// bindings/contact.cpp - the static contact of a wheelset, for `contact` and for verification.
#include <nanobind/stl/shared_ptr.h>

#include <ctime>

#include "arguments.hpp"
#include "rollerrig/system/static_wheelset_contact.hpp"

using namespace nb::literals;
using namespace rollerrig;

void bind_contact(nb::module_& m) {
  using Contact = StaticWheelsetContact;
  using P = StaticPatch;
  bind_result(m, "StaticPatch", "One patch of a wheelset at rest; SI, b frame.", Member{"right", &P::right},
              Member{"wheel_s", &P::wheel_s}, Member{"rail_y", &P::rail_y}, Member{"angle", &P::angle},
              Member{"a", &P::a}, Member{"b", &P::b}, Member{"approach", &P::approach}, Member{"normal", &P::normal},
              Member{"weight", &P::weight}, Member{"peak_pressure", &P::peak_pressure}, Member{"length", &P::length},
              Member{"width", &P::width}, Member{"area", &P::area}, Member{"point", &P::point},
              Member{"direction", &P::direction}, Member{"wheel_radius", &P::wheel_radius},
              Member{"limited", &P::limited});
  bind_result(m, "LoadedWheelset", "Equilibrium of a wheelset on its patches; SI.",
              Member{"converged", &LoadedWheelset::converged}, Member{"vertical", &LoadedWheelset::vertical},
              Member{"roll_moment", &LoadedWheelset::roll_moment}, Member{"patches", &LoadedWheelset::patches})
      .def_prop_ro("z", [](LoadedWheelset const& w) { return w.position.z; })
      .def_prop_ro("roll", [](LoadedWheelset const& w) { return w.position.roll; });
  auto contact =
      nb::class_<Contact>(m, "StaticWheelsetContact", "A wheelset on its rollers or rails, quasi-static; SI, b frame.");
  contact.def(nb::init<std::shared_ptr<Model const>, int, int>(), "model"_a, "left"_a, "right"_a);
  Argument const along{"x"}, across{"y"}, height{"z"}, turned{"yaw"}, tilted{"roll"}, side{"right"};
  def_method(
      contact, "solve", "The equilibrium under a vertical load [N].",
      +[](Contact& self, double x, double y, double yaw, double roll, double load, bool free_to_roll) {
        return self.solve({x, y, 0.0, roll, yaw}, load, free_to_roll);
      },
      along, across, turned, tilted, Argument{"load", positive}, Argument{"free_to_roll"});
  def_method(
      contact, "touch_height", "Height z at which the wheel of one side just touches [m].",
      +[](Contact& self, double x, double y, double yaw, double roll, bool right) {
        return self.touch_height({x, y, 0.0, roll, yaw}, right);
      },
      along, across, turned, tilted, side);
  def_method(
      contact, "patches", "The patches of one side.",
      +[](Contact& self, double x, double y, double z, double yaw, double roll, bool right) {
        return self.patches({x, y, z, roll, yaw}, right);
      },
      along, across, height, turned, tilted, side);
  def_method(
      contact, "seconds_per_contact",
      "Processor time of the normal contact per wheel [s], of `wheels` wheels 0.1 mm apart across in one evaluation.",
      +[](Contact& self, double x, double y, double z, double yaw, double roll, bool right, int wheels, int repeats) {
        WheelBatch batch(self, {x, y, z, roll, yaw}, right, wheels);
        std::clock_t const start = std::clock();  // of this process: others on the machine do not count
        for (int i = 0; i < repeats; ++i) batch.evaluate();
        return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / repeats / wheels;
      },
      along, across, height, turned, tilted, side, Argument{"wheels", Range{1.0, 64.0, "between 1 and 64"}},
      Argument{"repeats", Range{1.0, 1e5, "between 1 and 100000"}});
  def_method(
      contact, "minima", "All minima of the gap closer than `reach` [m] of one side.",
      +[](Contact& self, double x, double y, double z, double yaw, double roll, bool right, double reach) {
        return self.minima({x, y, z, roll, yaw}, right, reach);
      },
      along, across, height, turned, tilted, side, Argument{"reach"});
}
