// bindings/contact.cpp - the static contact of a wheelset, for `contact` and for verification.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <ctime>

#include "convert.hpp"
#include "rollerrig/system/static_wheelset_contact.hpp"

using namespace nb::literals;
using namespace rollerrig;

namespace {

/// Keeps the model alive that the contacts are part of.
struct Press {
  std::shared_ptr<Model const> model;
  WheelsetPress press;
  Press(std::shared_ptr<Model const> shared, int left, int right)
      : model(std::move(shared)),
        press(model->contacts.at(static_cast<std::size_t>(left)), model->contacts.at(static_cast<std::size_t>(right))) {
  }
};

nb::dict as_dict(PressedPatch const& p) {
  nb::dict d;
  d["side"] = p.right ? "right" : "left";
  d["wheel_s"] = p.wheel_s;
  d["rail_y"] = p.rail_y;
  d["angle"] = p.angle;
  d["a"] = p.a;
  d["b"] = p.b;
  d["approach"] = p.approach;
  d["normal"] = p.normal;
  d["weight"] = p.weight;
  d["peak_pressure"] = p.peak_pressure;
  d["width"] = p.width;
  d["area"] = p.area;
  d["point"] = p.point;
  d["direction"] = p.direction;
  d["wheel_radius"] = p.wheel_radius;
  d["limited"] = p.limited;
  return d;
}

nb::list as_list(std::vector<PressedPatch> const& patches) {
  nb::list list;
  for (auto const& p : patches) list.append(as_dict(p));
  return list;
}

}  // namespace

void bind_contact(nb::module_& m) {
  nb::class_<Press>(m, "WheelsetPress", "A wheelset on its rollers or rails, quasi-static; SI, b frame.")
      .def(nb::init<std::shared_ptr<Model const>, int, int>(), "model"_a, "left"_a, "right"_a)
      .def(
          "press",
          [](Press& self, double x, double y, double yaw, double roll, double load, bool free_to_roll) {
            auto const r = self.press.press({x, y, 0.0, roll, yaw}, load, free_to_roll);
            nb::dict d;
            d["converged"] = r.converged;
            d["z"] = r.position.z;
            d["roll"] = r.position.roll;
            d["vertical"] = r.vertical;
            d["roll_moment"] = r.roll_moment;
            d["patches"] = as_list(r.patches);
            return d;
          },
          "x"_a, "y"_a, "yaw"_a, "roll"_a, "load"_a, "free_to_roll"_a)
      .def(
          "touch_height",
          [](Press& self, double x, double y, double yaw, double roll, bool right) {
            return self.press.touch_height({x, y, 0.0, roll, yaw}, right);
          },
          "x"_a, "y"_a, "yaw"_a, "roll"_a, "right"_a)
      .def(
          "patches",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right) {
            return as_list(self.press.patches({x, y, z, roll, yaw}, right));
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a)
      .def(
          "seconds_per_contact",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right, int repeats) {
            std::clock_t const start = std::clock();  // of this process: others on the machine do not count
            for (int i = 0; i < repeats; ++i) self.press.patches({x, y, z, roll, yaw}, right);
            return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / repeats;
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a, "repeats"_a)
      .def(
          "minima",
          [](Press& self, double x, double y, double z, double yaw, double roll, bool right, double reach) {
            return as_list(self.press.minima({x, y, z, roll, yaw}, right, reach));
          },
          "x"_a, "y"_a, "z"_a, "yaw"_a, "roll"_a, "right"_a, "reach"_a);
}
